#pragma once
// An encoder that reads wrong with a period: interpolation error, eccentricity.

#include <numbers>

#include "cogging/plant/effect.hpp"

namespace cogging {

/// reading = x + sine sin(2 pi x / period) + cosine cos(2 pi x / period), before noise and rounding.
template <class Scalar = double>
struct EncoderPeriodicError {
  static constexpr std::string_view name = "encoder_periodic_error";
  static constexpr std::string_view law = "reading = x + sine sin(2 pi x / period) + cosine cos(2 pi x / period)";

  Scalar period = 0.001;  // m
  Scalar sine = 0.0;      // m
  Scalar cosine = 0.0;    // m

  static constexpr auto fields() {
    using E = EncoderPeriodicError;
    return std::tuple{
        Field{"period", &E::period, "m", "in position", Rule::period, logarithmic_shape(Quantity::distance, 1e-5, 1.0)},
        Field{"sine", &E::sine, "m", "amplitude of the sine", amplitude(Quantity::distance, 0.01)},
        Field{"cosine", &E::cosine, "m", "amplitude of the cosine", amplitude(Quantity::distance, 0.01)}};
  }
  static Kinds kinds() { return {Wave{"period", "sine", "cosine"}}; }

  Scalar reading_error(const Scalar& position) const {
    Scalar s, c;
    sin_cos(position * (2.0 * std::numbers::pi) / period, s, c);
    return sine * s + cosine * c;
  }
};

}  // namespace cogging
