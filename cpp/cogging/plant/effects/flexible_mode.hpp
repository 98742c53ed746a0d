#pragma once
// A resonance between motor and load.

#include "cogging/plant/coupling.hpp"
#include "cogging/plant/effect.hpp"

namespace cogging {

/// Two masses, (1 - mass_ratio) M of the motor and mass_ratio M of the load, on a spring k = w^2 m1 m2 / (m1 + m2)
/// and a damper c = 2 damping_ratio w m1 m2 / (m1 + m2), w = 2 pi frequency. All forces act on the motor, and so
/// does the encoder; the load starts at ease.
template <class Scalar = double>
struct FlexibleMode {
  static constexpr std::string_view name = "flexible_mode";
  static constexpr std::string_view law = "m1 x'' = forces + k q + c q', m2 (x + q)'' = -k q - c q'";

  double frequency = infinity;  // Hz
  double damping_ratio = 0.01;
  double mass_ratio = 0.0;

  static constexpr auto fields() {
    using E = FlexibleMode;
    return std::tuple{Field{"frequency", &E::frequency, "Hz", "of the free-free vibration; infinite = rigid",
                            Rule::above_0, vanishing(logarithmic_shape(Quantity::frequency, 0.002, 0.9))},
                      Field{"damping_ratio", &E::damping_ratio, "1", "of that vibration", Rule::not_negative,
                            logarithmic_shape(Quantity::one, 0.001, 0.5)},
                      Field{"mass_ratio", &E::mass_ratio, "1", "load over total", Rule::share,
                            vanishing(linear_shape(Quantity::relative, 0.0, 0.9))}};
  }

  CouplingParameters coupling() const { return {mass_ratio, frequency, damping_ratio, 0.0, false}; }
};

}  // namespace cogging
