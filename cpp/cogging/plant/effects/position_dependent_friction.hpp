#pragma once
// A Coulomb level that changes along the travel.

#include "cogging/plant/effect.hpp"
#include "cogging/plant/piecewise_linear.hpp"

namespace cogging {

/// Adds `levels` at `nodes` to the Coulomb level: linear between two nodes, constant beyond the first and last.
template <class Scalar = double>
struct PositionDependentFriction {
  static constexpr std::string_view name = "position_dependent_friction";
  static constexpr std::string_view law = "-level(x) S(v), level linear between the nodes";

  std::vector<double> nodes;   // m
  std::vector<double> levels;  // V

  static constexpr auto fields() {
    using E = PositionDependentFriction;
    return std::tuple{
        Field{"nodes", &E::nodes, "m", "positions, increasing", linear_shape(Quantity::position, 0.0, 1.0)},
        Field{"levels", &E::levels, "V", "added to Fc, one a node", amplitude(Quantity::friction, 2.0)}};
  }
  static Kinds kinds() { return {Knots{"position", "nodes", "levels"}}; }
  void validate() const { require_piecewise_linear("nodes", nodes, "levels", levels); }

  Scalar friction_level(const Motion<Scalar>& motion) const {
    return piecewise_linear<Scalar>(nodes, levels, motion.position);
  }

  std::vector<double> kinks() const { return nodes; }
};

}  // namespace cogging
