#pragma once
// PID with feedforward and friction compensation, from positions only.

#include <string>

#include "cogging/control/controller.hpp"
#include "cogging/control/feedforward.hpp"
#include "cogging/control/sample_guard.hpp"

namespace cogging {

template <class Scalar = double>
struct PidParameters {
  static constexpr std::string_view description = "Gains and feedforward of a Pid.";

  double sample_rate = 5000.0;  // Hz
  Scalar kp = 0.0;              // V/m
  Scalar ki = 0.0;              // V/(m s)
  Scalar kd = 0.0;              // V/(m/s)
  Scalar mass = 0.0;            // V/(m/s^2)
  Scalar viscous = 0.0;         // V/(m/s)
  Scalar coulomb = 0.0;         // V
  Scalar coulomb_width = 0.0;   // m/s
  std::string feedforward_velocity = "reference";
  double command_limit = 0.0;  // V

  static constexpr auto fields() {
    using P = PidParameters;
    return std::tuple_cat(std::tuple{Field{"sample_rate", &P::sample_rate, "Hz", "samples a second", Rule::positive},
                                     Field{"kp", &P::kp, "V/m", "proportional gain", Rule::not_negative},
                                     Field{"ki", &P::ki, "V/(m s)", "integral gain", Rule::not_negative},
                                     Field{"kd", &P::kd, "V/(m/s)", "derivative gain", Rule::not_negative}},
                          feedforward_fields<P>("largest command, with anti-windup; 0 = none"));
  }

  void validate() const { validate_feedforward(*this); }
};

/// The law of `description`; feedforward and friction term as Xu and Yao 2001, eq. 57, when the velocity is "measured".
///
/// A sample that is refused (see SampleGuard) adds nothing to the sum, and e_prev stays; (e - e_prev) / Ts is then the
/// mean over the samples that have passed.
template <class Scalar = double>
class Pid : public GuardedController<PidParameters<Scalar>, Scalar> {
  using Base = GuardedController<PidParameters<Scalar>, Scalar>;
  using Base::guard_, Base::parameters_;

 public:
  using typename Base::Parameters;
  static constexpr std::string_view name = "pid";
  static constexpr std::string_view description = R"(PID with feedforward, from positions only.

u = mass a_r + viscous v + coulomb S(v) - kp e - ki sum(e Ts) - kd (e - e_prev) / Ts, e = reading - reference. The sum
includes the current sample and starts at zero; e_prev = e in the first sample. With a command limit the sum does not
take up an error that pushes further into it.)";

  explicit Pid(const Parameters& parameters = {})
      : Base(parameters), feedforward_(parameters), sample_time_(1.0 / parameters.sample_rate) {}

  /// What changes while it runs, in order: by it controllers are compared and kept in files.
  auto state() noexcept { return std::tie(feedforward_, guard_, error_previous_, sum_, step_, computed_); }

  Scalar command(const ReferencePoint& reference, Scalar reading) noexcept {
    return guard_.command(guard_.usable(reference), reading,
                          [&](const auto& sample, const Scalar& y) { return law(sample, reference, y); });
  }

  void update(Scalar applied) noexcept {
    // (computed - applied) has the sign of the cut; -step is the way in which this sample moved the command.
    const Scalar cut = computed_ - guard_.acted(applied), step = guard_.if_taken(step_, Scalar(0.0));
    sum_ -= select(cut * step < 0.0, step, Scalar(0.0));
  }

 private:
  template <class Sample>
  COGGING_INLINE Scalar law(const Sample& sample, const ReferencePoint& reference, const Scalar& reading) noexcept {
    const Scalar error = reading - reference.position, step = error * sample_time_, sum = sum_ + step;
    const Scalar rate = sample.per_sample(error - error_previous_) / sample_time_;
    const Scalar computed = feedforward_(sample, reference, reading) - parameters_.kp * error - parameters_.ki * sum -
                            parameters_.kd * rate;
    sample.set(sum_, sum);
    sample.set(step_, step);
    sample.set(computed_, computed);
    sample.set(error_previous_, error);
    return computed;
  }

  Feedforward<Scalar> feedforward_;
  double sample_time_;
  Scalar error_previous_ = 0.0, sum_ = 0.0, step_ = 0.0, computed_ = 0.0;
};

}  // namespace cogging
