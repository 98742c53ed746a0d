#pragma once
// Feedforward of acceleration, velocity and friction, as `pid`, `cascade` and `speed` add it.

#include "cogging/parameters.hpp"
#include "cogging/reference/reference.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// The fields with which every parameter struct with a feedforward ends: mass to command_limit.
template <class P>
constexpr auto feedforward_fields(std::string_view command_limit = "largest command; 0 = none") {
  return std::tuple{
      Field{"mass", &P::mass, "V/(m/s^2)", "feedforward of the reference acceleration; 0 = none", Rule::not_negative},
      Field{"viscous", &P::viscous, "V/(m/s)", "feedforward of the velocity", Rule::not_negative},
      Field{"coulomb", &P::coulomb, "V", "friction compensation", Rule::not_negative},
      Field{"coulomb_width", &P::coulomb_width, "m/s", "of the compensation's S(v); 0 = sgn", Rule::not_negative},
      Field{"feedforward_velocity", &P::feedforward_velocity, "",
            "\"reference\" or \"measured\" (backward difference of the reading)"},
      Field{"command_limit", &P::command_limit, "V", command_limit, Rule::not_negative}};
}

template <class Parameters>
void validate_feedforward(const Parameters& parameters) {
  if (parameters.feedforward_velocity != "reference" && parameters.feedforward_velocity != "measured")
    refuse("feedforward_velocity", "must be \"reference\" or \"measured\"", parameters.feedforward_velocity);
}

/// mass a_r + viscous v + coulomb S(v), v the reference's velocity or the backward difference of the reading.
template <class Scalar>
class Feedforward {
 public:
  template <class Parameters>
  explicit Feedforward(const Parameters& parameters)
      : mass_(parameters.mass),
        viscous_(parameters.viscous),
        coulomb_(parameters.coulomb),
        coulomb_width_(parameters.coulomb_width),
        sample_rate_(parameters.sample_rate),
        measured_(parameters.feedforward_velocity == "measured") {}

  /// The feedforward command, V. Call once a sample (see SampleGuard).
  template <class Sample>
  Scalar operator()(const Sample& sample, const ReferencePoint& reference, const Scalar& reading) noexcept {
    const Scalar measured_velocity = sample.per_sample(reading - reading_previous_) * sample_rate_;
    sample.set(measured_velocity_, measured_velocity);
    sample.set(reading_previous_, reading);
    const Scalar velocity = measured_ ? measured_velocity : Scalar(reference.velocity);
    return mass_ * reference.acceleration + viscous_ * velocity + coulomb_ * smooth_sign(velocity, coulomb_width_);
  }

  /// What changes while it runs (see Pid::state).
  auto state() noexcept { return std::tie(reading_previous_, measured_velocity_); }

  /// Backward difference of the readings, m/s; 0 in the first sample.
  const Scalar& measured_velocity() const { return measured_velocity_; }

 private:
  Scalar mass_, viscous_, coulomb_, coulomb_width_;
  double sample_rate_;
  bool measured_;
  Scalar reading_previous_ = 0.0, measured_velocity_ = 0.0;
};

}  // namespace cogging
