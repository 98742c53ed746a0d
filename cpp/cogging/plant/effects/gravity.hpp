#pragma once
// An unbalanced mass on a rotary axis.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// -moment sin(x - angle), V, x in rad: the period is exactly one turn, and at `angle` the mass hangs where it is drawn
/// to.
template <class Scalar = double>
struct Gravity {
  static constexpr std::string_view name = "gravity";
  static constexpr std::string_view law = "-moment sin(x - angle)";

  Scalar moment = 0.0;  // V
  Scalar angle = 0.0;   // rad

  static constexpr auto fields() {
    using E = Gravity;
    return std::tuple{
        Field{"moment", &E::moment, "V", "weight times arm, felt a quarter turn from `angle`",
              // a swing-up in several strokes takes less than the weight
              positive_amplitude(Quantity::force, 5.0)},
        Field{"angle", &E::angle, "rad", "where the mass hangs at rest", linear_shape(Quantity::angle, -0.5, 0.5)}};
  }
  static Kinds kinds() { return {Turn{"angle"}}; }

  Scalar force(const Motion<Scalar>& motion) const {
    Scalar s, c;
    sin_cos(motion.position - angle, s, c);
    return -moment * s;
  }
  Variation variation() const { return {.force = largest(abs(moment)), .wavenumber = 1.0}; }
};

}  // namespace cogging
