#pragma once
// The encoder: reading = resolution round((x + errors + noise) / resolution).

#include "cogging/parameters.hpp"
#include "cogging/plant/effects/list.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

struct EncoderParameters {
  double resolution = 0.0;  // m
  double noise = 0.0;       // m rms

  static constexpr auto fields() {
    using P = EncoderParameters;
    return std::tuple{Field{"resolution", &P::resolution, "m", "one count; 0 = ideal", Rule::not_negative},
                      Field{"noise", &P::noise, "m", "rms of the white noise before rounding", Rule::not_negative}};
  }
};

/// Where the encoder believes the axis to be, before noise and rounding: x plus the errors of the effects, each of
/// the true position.
template <class Scalar>
Scalar encoder_position(const std::vector<Effect<Scalar>>& effects, const Scalar& position) {
  Scalar seen = position;
  for_each_law(effects, [&](const HasReading<Scalar> auto& law) { seen += law.reading_error(position); });
  return seen;
}

/// A position as the encoder shows it. `noise` is a standard normal number.
template <class Scalar>
Scalar read_encoder(const EncoderParameters& encoder, const Scalar& position, double noise) {
  const Scalar seen = position + encoder.noise * noise;
  return encoder.resolution > 0.0 ? encoder.resolution * round(seen / encoder.resolution) : seen;
}

}  // namespace cogging
