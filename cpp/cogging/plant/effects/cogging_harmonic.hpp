#pragma once
// A spatial period that the cogging model lacks.

#include <numbers>

#include "cogging/plant/effect.hpp"

namespace cogging {

/// -(sine sin(2 pi x / period) + cosine cos(2 pi x / period)), V: opposes the command, as F_cogging does.
template <class Scalar = double>
struct CoggingHarmonic {
  static constexpr std::string_view name = "cogging_harmonic";
  static constexpr std::string_view law = "-(sine sin(2 pi x / period) + cosine cos(2 pi x / period))";

  Scalar period = 0.01;  // m
  Scalar sine = 0.0;     // V
  Scalar cosine = 0.0;   // V

  static constexpr auto fields() {
    using E = CoggingHarmonic;
    return std::tuple{
        Field{"period", &E::period, "m", "in position", Rule::period, logarithmic_shape(Quantity::distance, 1e-4, 1.0)},
        Field{"sine", &E::sine, "V", "amplitude of the sine", amplitude(Quantity::force)},
        Field{"cosine", &E::cosine, "V", "amplitude of the cosine", amplitude(Quantity::force)}};
  }
  static Kinds kinds() { return {Wave{"period", "sine", "cosine"}}; }

  Scalar force(const Motion<Scalar>& motion) const {
    Scalar s, c;
    sin_cos(motion.position * (2.0 * std::numbers::pi) / period, s, c);
    return -(sine * s + cosine * c);
  }
  Variation variation() const {
    return {.force = largest(abs(sine)) + largest(abs(cosine)),
            .wavenumber = 2.0 * std::numbers::pi / smallest(period)};
  }
};

}  // namespace cogging
