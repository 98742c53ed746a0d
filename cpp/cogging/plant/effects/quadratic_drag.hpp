#pragma once
// Drag that grows with the square of the speed.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// -coefficient v |v|, V.
template <class Scalar = double>
struct QuadraticDrag {
  static constexpr std::string_view name = "quadratic_drag";
  static constexpr std::string_view law = "-coefficient v |v|";

  Scalar coefficient = 0.0;  // V/(m/s)^2

  static constexpr auto fields() {
    return std::tuple{Field{"coefficient", &QuadraticDrag::coefficient, "V/(m/s)^2", "force a squared metre a second",
                            amplitude(Quantity::force_per_velocity_squared)}};
  }

  Scalar force(const Motion<Scalar>& motion) const { return -coefficient * motion.velocity * abs(motion.velocity); }
};

}  // namespace cogging
