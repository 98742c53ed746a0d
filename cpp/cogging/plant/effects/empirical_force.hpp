#pragma once
// A force that was found in data and that nothing explains yet.

#include <algorithm>

#include "cogging/plant/effect.hpp"
#include "cogging/plant/piecewise_linear.hpp"

namespace cogging {

/// Forces by position, velocity and time, each given at nodes: linear between two, constant beyond the first and last.
///
/// It names no cause, and says nothing of motion on which it was not fitted.
template <class Scalar = double>
struct EmpiricalForce {
  static constexpr std::string_view name = "empirical_force";
  static constexpr std::string_view law = "f(x) + g(v) + h(t), each linear between its nodes";

  std::vector<double> position_nodes;   // m
  std::vector<double> position_forces;  // V
  std::vector<double> velocity_nodes;   // m/s
  std::vector<double> velocity_forces;  // V
  std::vector<double> time_nodes;       // s
  std::vector<double> time_forces;      // V

  static constexpr auto fields() {
    using E = EmpiricalForce;
    return std::tuple{
        Field{"position_nodes", &E::position_nodes, "m", "positions, increasing"},
        Field{"position_forces", &E::position_forces, "V", "pushes towards +x, one a node", amplitude(Quantity::force)},
        Field{"velocity_nodes", &E::velocity_nodes, "m/s", "velocities, increasing"},
        Field{"velocity_forces", &E::velocity_forces, "V", "pushes towards +x, one a node", amplitude(Quantity::force)},
        Field{"time_nodes", &E::time_nodes, "s", "times, increasing"},
        Field{"time_forces", &E::time_forces, "V", "pushes towards +x, one a node", amplitude(Quantity::force)}};
  }
  static Kinds kinds() {
    return {Knots{"position", "position_nodes", "position_forces"},
            Knots{"velocity", "velocity_nodes", "velocity_forces"}, Knots{"time", "time_nodes", "time_forces"}};
  }
  void validate() const {
    require_piecewise_linear("position_nodes", position_nodes, "position_forces", position_forces);
    require_piecewise_linear("velocity_nodes", velocity_nodes, "velocity_forces", velocity_forces);
    require_piecewise_linear("time_nodes", time_nodes, "time_forces", time_forces);
  }

  Scalar force(const Motion<Scalar>& motion) const {
    return piecewise_linear<Scalar>(position_nodes, position_forces, motion.position) +
           piecewise_linear<Scalar>(velocity_nodes, velocity_forces, motion.velocity) +
           piecewise_linear<Scalar>(time_nodes, time_forces, motion.time);
  }

  std::vector<double> kinks() const { return position_nodes; }
  std::vector<double> velocity_kinks() const { return velocity_nodes; }

  double next_event(double time) const {
    const auto next = std::upper_bound(time_nodes.begin(), time_nodes.end(), time);
    return next == time_nodes.end() ? infinity : *next;
  }
};

}  // namespace cogging
