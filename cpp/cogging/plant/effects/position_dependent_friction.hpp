#pragma once
// A Coulomb level that changes along the travel.

#include <tuple>
#include <vector>

#include "cogging/plant/effect.hpp"

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
    return std::tuple{Field<E, std::vector<double>>{"nodes", &E::nodes, "m", "positions, increasing",
                                                    linear_shape(Quantity::position, 0.0, 1.0)},
                      Field<E, std::vector<double>>{"levels", &E::levels, "V", "added to Fc, one a node",
                                                    amplitude(Quantity::friction, 2.0)}};
  }
  void validate() const {
    require_finite("nodes", nodes);
    require_finite("levels", levels);
    for (std::size_t i = 1; i < nodes.size(); ++i)
      require(nodes[i] > nodes[i - 1], "nodes", "must increase: above " + format(nodes[i - 1]), nodes[i]);
    require(nodes.size() == levels.size(), "levels",
            "must have as many values as nodes = " + format(double(nodes.size())), double(levels.size()));
  }

  Scalar friction_level(const Motion<Scalar>& motion) const {
    if (nodes.empty()) return 0.0;
    Scalar level = levels[0];
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      const Scalar share = (motion.position - nodes[i - 1]) / (nodes[i] - nodes[i - 1]);
      level += (levels[i] - levels[i - 1]) * clamp(share, Scalar(0.0), Scalar(1.0));
    }
    return level;
  }
};

}  // namespace cogging
