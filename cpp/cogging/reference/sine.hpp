#pragma once
// A sine about a centre.

#include <numbers>

#include "cogging/elementary.hpp"
#include "cogging/parameters.hpp"
#include "cogging/reference/reference.hpp"

namespace cogging {

struct SineParameters {
  static constexpr std::string_view description = "Centre, amplitude and frequency of a Sine.";

  double center = 0.0;     // m
  double amplitude = 0.1;  // m
  double frequency = 1.0;  // Hz

  static constexpr auto fields() {
    using P = SineParameters;
    return std::tuple{Field{"center", &P::center, "m", "middle of the motion"},
                      Field{"amplitude", &P::amplitude, "m", "half the stroke", Rule::not_negative},
                      Field{"frequency", &P::frequency, "Hz", "strokes there and back a second", Rule::positive}};
  }
};

class Sine final : public Reference {
 public:
  using Parameters = SineParameters;
  static constexpr std::string_view name = "sine";
  static constexpr std::string_view description =
      "x_d(t) = center + amplitude sin(2 pi frequency t). It starts at speed: the axis does not.";

  explicit Sine(const SineParameters& parameters) : parameters_(validated(parameters)) {}
  const SineParameters& parameters() const { return parameters_; }

  double period() const override { return 1.0 / parameters_.frequency; }

  ReferencePoint at(double time) const override {
    const double omega = 2.0 * std::numbers::pi * parameters_.frequency, a = parameters_.amplitude;
    double s, c;
    sin_cos(omega * time, s, c);
    return {parameters_.center + a * s, a * omega * c, -a * omega * omega * s};
  }

 private:
  SineParameters parameters_;
};

}  // namespace cogging
