#pragma once
// A force constant that changes along the travel.

#include <numbers>

#include "cogging/plant/effect.hpp"

namespace cogging {

/// The motor pushes with u (1 + sine sin(2 pi x / period) + cosine cos(2 pi x / period)).
template <class Scalar = double>
struct ForceConstantRipple {
  static constexpr std::string_view name = "force_constant_ripple";
  static constexpr std::string_view law = "u (1 + sine sin(2 pi x / period) + cosine cos(2 pi x / period))";

  Scalar period = 0.01;  // m
  Scalar sine = 0.0;
  Scalar cosine = 0.0;

  static constexpr auto fields() {
    using E = ForceConstantRipple;
    return std::tuple{
        Field{"period", &E::period, "m", "in position", Rule::period, logarithmic_shape(Quantity::distance, 1e-4, 1.0)},
        Field{"sine", &E::sine, "1", "relative amplitude of the sine", amplitude(Quantity::relative)},
        Field{"cosine", &E::cosine, "1", "relative amplitude of the cosine", amplitude(Quantity::relative)}};
  }
  static Kinds kinds() { return {Wave{"period", "sine", "cosine"}}; }

  Scalar command_gain(const Scalar& position, double) const {
    Scalar s, c;
    sin_cos(position * (2.0 * std::numbers::pi) / period, s, c);
    return sine * s + cosine * c;
  }
  Variation variation() const {
    return {.gain = largest(abs(sine)) + largest(abs(cosine)), .wavenumber = 2.0 * std::numbers::pi / smallest(period)};
  }
};

}  // namespace cogging
