#pragma once
// Friction that falls as speed rises from zero.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// Adds static_excess exp(-|v / velocity|^exponent) to the Coulomb level (Xu and Yao 2001, eq. 3, with the
/// sign that its eq. 4 needs: f_s - f_c is the excess).
template <class Scalar = double>
struct StribeckFriction {
  static constexpr std::string_view name = "stribeck_friction";
  static constexpr std::string_view law = "-static_excess exp(-|v / velocity|^exponent) S(v)";

  Scalar static_excess = 0.0;  // V
  Scalar velocity = 0.01;      // m/s
  Scalar exponent = 2.0;

  static constexpr auto fields() {
    using E = StribeckFriction;
    return std::tuple{Field{"static_excess", &E::static_excess, "V", "static level above the Coulomb level",
                            positive_amplitude(Quantity::friction, 2.0)},
                      Field{"velocity", &E::velocity, "m/s", "speed at which the excess has fallen to 1/e",
                            Rule::positive, logarithmic_shape(Quantity::velocity, 0.001, 0.5)},
                      Field{"exponent", &E::exponent, "1", "shape of the fall: 1 exponential, 2 Gaussian",
                            Rule::positive, linear_shape(Quantity::exponent, 0.5, 3.0)}};
  }

  Scalar friction_level(const Motion<Scalar>& motion) const {
    return static_excess * exp(-pow(abs(motion.velocity / velocity), exponent));
  }

  Variation variation() const { return {.velocity = all(static_excess == 0.0) ? infinity : smallest(velocity)}; }
};

}  // namespace cogging
