#pragma once
// A viscous slope that differs with direction.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// Viscous coefficient B + difference/2 forward, B - difference/2 backward.
template <class Scalar = double>
struct ViscousAsymmetry {
  static constexpr std::string_view name = "viscous_asymmetry";
  static constexpr std::string_view law = "-(difference / 2) |v|";

  Scalar difference = 0.0;  // V/(m/s)

  static constexpr auto fields() {
    return std::tuple{Field{"difference", &ViscousAsymmetry::difference, "V/(m/s)", "forward slope less backward slope",
                            amplitude(Quantity::force_per_velocity)}};
  }

  Scalar force(const Motion<Scalar>& motion) const { return -0.5 * difference * abs(motion.velocity); }

  Variation variation() const { return {.velocity = all(difference == 0.0) ? infinity : 0.0}; }
};

}  // namespace cogging
