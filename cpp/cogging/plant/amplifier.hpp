#pragma once
// The amplifier: what becomes of a command on its way to the motor.

#include <string>
#include <type_traits>

#include "cogging/delay_line.hpp"
#include "cogging/plant/amplifier_laws.hpp"
#include "cogging/plant/state.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// Shapes the command without memory (in the order of the effects), delays it, and passes it through the
/// current loop.
///
/// Each sample: accept(command), then over() says what acts before and after the delayed command changes, and settle()
/// moves the current loop on by the time that has passed.
template <class Scalar = double>
class Amplifier : public AmplifierLaws<Scalar> {
  using Laws = AmplifierLaws<Scalar>;

 public:
  Amplifier(const std::vector<Effect<Scalar>>& effects, double sample_time) : Laws(effects), sample_time_(sample_time) {
    const SampleMoment delay = Laws::delay_in_samples(sample_time);
    whole_ = static_cast<std::size_t>(delay.sample);
    switch_ = delay.since;
    commands_ = DelayLine<Scalar>(whole_ + 1);
  }

  /// Raises DivergedError where what is passed on to the motor would not be a number: behind a current loop or under
  /// friction that sticks, an infinity could look like rest.
  COGGING_INLINE void accept(const Scalar& command) {
    const Scalar shaped = Laws::shaped(command);
    if (!all_finite(shaped)) [[unlikely]]
      refuse_command(shaped);
    pass_on(shaped);
  }

  /// Passes on what `shaped` made of a command, a number.
  void pass_on(const Scalar& shaped) {
    commands_.push(shaped);
    ++accepted_;
  }

  /// Whether one command acts over a whole sample, and at once.
  bool holds() const { return switch_ == 0.0 && !Laws::lagging(); }
  /// The drive of such a sample.
  Drive<Scalar> held() const { return drive(whole_); }

  /// Calls piece(drive, from, to) for each part of the sample [time, time_next] in which one command acts; times in s.
  template <class Piece>
  COGGING_INLINE void over(double time, double time_next, const Piece& piece) {
    const double switch_time = std::min(time + switch_, time_next);
    if (time < switch_time) piece(drive(whole_ + 1), time, switch_time);
    if (switch_time < time_next) piece(drive(whole_), switch_time, time_next);
  }

  /// Raises DivergedError: the command of now is no number.
  template <class Value>
  [[noreturn]] COGGING_NOINLINE void refuse_command(const Value& command) const {
    std::string value = "a lane's";
    if constexpr (std::is_same_v<Value, double>) value = format(command);
    const double time = static_cast<double>(accepted_) * sample_time_;
    throw DivergedError("the run diverged at " + format(time) + " s: the command must be a finite number, got " + value,
                        time);
  }

  void settle(Drive<Scalar>& drive, double duration) {
    if (!Laws::lagging()) return;
    output_ = drive.at(Scalar(duration));
    drive.deviation = output_ - drive.target;
  }

 private:
  // As the command acts that is so many samples old.
  Drive<Scalar> drive(std::size_t age) const {
    const Scalar target = commands_.at(age);
    return {target, output_ - target, Laws::rate(), Scalar(0.0), Laws::lagging()};
  }

  double sample_time_, switch_ = 0.0;
  std::size_t whole_ = 0, accepted_ = 0;
  DelayLine<Scalar> commands_{0};
  Scalar output_ = 0.0;
};

}  // namespace cogging
