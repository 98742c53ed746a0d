#pragma once
// Spring-like hysteresis before breakaway.

#include "cogging/plant/bristle.hpp"
#include "cogging/plant/effect.hpp"

namespace cogging {

/// Friction stiffness z + damping z' with the bristle z' = v - stiffness |v| z / g, in place of g S(v): g is Fc
/// plus what other effects add to it. damping = 0 is Dahl's model with exponent 1, otherwise LuGre.
/// coulomb_width has then no influence.
template <class Scalar = double>
struct PreslidingFriction {
  static constexpr std::string_view name = "presliding_friction";
  static constexpr std::string_view law =
      "-(stiffness z + damping z'), z' = v - stiffness |v| z / g, in place of -g S(v)";

  double stiffness = infinity;  // V/m
  double damping = 0.0;         // V/(m/s)

  static constexpr auto fields() {
    using E = PreslidingFriction;
    return std::tuple{Field{"stiffness", &E::stiffness, "V/m", "of the contact at rest; infinite = none", Rule::above_0,
                            vanishing(logarithmic_shape(Quantity::stiffness, 10.0, 1e6))},
                      Field{"damping", &E::damping, "V/(m/s)", "of the bristle", Rule::not_negative,
                            linear_shape(Quantity::force_per_velocity, 0.0, 100.0)}};
  }

  Bristle bristle() const { return {stiffness, damping}; }
};

}  // namespace cogging
