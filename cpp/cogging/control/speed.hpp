#pragma once
// A velocity loop alone.

#include <string>

#include "cogging/control/controller.hpp"
#include "cogging/control/feedforward.hpp"
#include "cogging/control/sample_guard.hpp"
#include "cogging/delay_line.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

template <class Scalar = double>
struct SpeedParameters {
  static constexpr std::string_view description = "Gain, delay and feedforward of a Speed.";

  double sample_rate = 1000.0;  // Hz
  Scalar kp = 0.0;              // V/(m/s)
  double delay = 0.0;           // s
  Scalar mass = 0.0;            // V/(m/s^2)
  Scalar viscous = 0.0;         // V/(m/s)
  Scalar coulomb = 0.0;         // V
  Scalar coulomb_width = 0.0;   // m/s
  std::string feedforward_velocity = "reference";
  double command_limit = 0.0;  // V

  static constexpr auto fields() {
    using P = SpeedParameters;
    return std::tuple_cat(
        std::tuple{Field{"sample_rate", &P::sample_rate, "Hz", "samples a second", Rule::positive},
                   Field{"kp", &P::kp, "V/(m/s)", "gain of the velocity loop", Rule::not_negative},
                   Field{"delay", &P::delay, "s", "from a reading to the command that it gives", Rule::not_negative}},
        feedforward_fields<P>());
  }

  void validate() const {
    require(delay * sample_rate < 1e6, "delay", "must be below a million samples", delay);
    validate_feedforward(*this);
  }
};

/// The law of `description`. A command is held over its sample, so it cannot change within one: hence the mean.
template <class Scalar = double>
class Speed : public GuardedController<SpeedParameters<Scalar>, Scalar> {
  using Base = GuardedController<SpeedParameters<Scalar>, Scalar>;
  using Base::guard_, Base::parameters_;

 public:
  using typename Base::Parameters;
  static constexpr std::string_view name = "speed";
  static constexpr std::string_view description = R"(A velocity loop, from positions only.

w = kp (v_r - v) + feedforward, put out `delay` later; v is the backward difference of the reading, 0 in the first
sample. With delay = (n + f) / sample_rate, 0 <= f < 1, the command of sample k is (1 - f) w[k-n] + f w[k-n-1], w = 0
before the first sample: the mean over the sample of the held w after the exact delay. What is held in a sample that is
refused is w, which goes through the delay as ever.)";

  explicit Speed(const Parameters& parameters = {}) : Base(parameters), feedforward_(parameters) {
    double samples = parameters.delay * parameters.sample_rate;
    // A delay of 2 ms at 1 kHz is two samples, whatever the rounding of the product.
    if (std::abs(samples - std::round(samples)) < 1e-9 * (1.0 + samples)) samples = std::round(samples);
    const double whole = std::floor(samples);
    fraction_ = samples - whole;
    whole_ = whole_part<std::size_t>(whole);
    commands_ = DelayLine<Scalar>(whole_ + 1);
  }

  double dead_time() const { return parameters_.delay; }  // s
  /// What changes while it runs (see Pid::state).
  auto state() noexcept { return std::tie(feedforward_, guard_, commands_); }

  Scalar command(const ReferencePoint& reference, Scalar reading) noexcept {
    commands_.push(guard_.command(guard_.usable(reference), reading, [&](const auto& sample, const Scalar& y) {
      const Scalar forward = feedforward_(sample, reference, y);
      return Scalar(parameters_.kp * (reference.velocity - feedforward_.measured_velocity()) + forward);
    }));
    const Scalar delayed = (1.0 - fraction_) * commands_.at(whole_) + fraction_ * commands_.at(whole_ + 1);
    return guard_.if_taken(delayed, guard_.limited(delayed));
  }

  void update(Scalar) noexcept {}

 private:
  Feedforward<Scalar> feedforward_;
  double fraction_ = 0.0;
  std::size_t whole_ = 0;
  DelayLine<Scalar> commands_{0};  // w, V
};

}  // namespace cogging
