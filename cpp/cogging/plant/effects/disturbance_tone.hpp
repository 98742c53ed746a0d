#pragma once
// A force that is a sinusoid in time: a pump, a fan, the floor.

#include <numbers>

#include "cogging/plant/effect.hpp"

namespace cogging {

/// sine sin(2 pi frequency t) + cosine cos(2 pi frequency t), V.
template <class Scalar = double>
struct DisturbanceTone {
  static constexpr std::string_view name = "disturbance_tone";
  static constexpr std::string_view law = "sine sin(2 pi frequency t) + cosine cos(2 pi frequency t)";

  Scalar frequency = 1.0;  // Hz
  Scalar sine = 0.0;       // V
  Scalar cosine = 0.0;     // V

  static constexpr auto fields() {
    using E = DisturbanceTone;
    return std::tuple{Field{"frequency", &E::frequency, "Hz", "of the tone", Rule::positive,
                            logarithmic_shape(Quantity::frequency, 0.0005, 0.5)},
                      Field{"sine", &E::sine, "V", "amplitude of the sine", amplitude(Quantity::force)},
                      Field{"cosine", &E::cosine, "V", "amplitude of the cosine", amplitude(Quantity::force)}};
  }
  static Kinds kinds() { return {Wave{"frequency", "sine", "cosine"}}; }

  Scalar force(const Motion<Scalar>& motion) const {
    Scalar s, c;
    sin_cos(frequency * (2.0 * std::numbers::pi * motion.time), s, c);
    return sine * s + cosine * c;
  }
  Variation variation() const {
    return {.force = largest(abs(sine)) + largest(abs(cosine)), .rate = 2.0 * std::numbers::pi * largest(frequency)};
  }
};

}  // namespace cogging
