#pragma once
// The amplifier: what becomes of a command on its way to the motor.

#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include "cogging/plant/axis.hpp"

namespace cogging {

/// Shapes the command without memory (in the order of the effects), delays it, and passes it through the
/// current loop.
///
/// Each sample: accept(command), then drive(before_switch) says what acts before or after the delayed command
/// changes, and settle() moves the current loop on by the time that has passed.
template <class Scalar = double>
class Amplifier {
 public:
  Amplifier(const std::vector<Effect<Scalar>>& effects, double sample_time) : sample_time_(sample_time) {
    double delay = 0.0;
    for (const Effect<Scalar>& effect : effects)
      std::visit(
          [&]<class E>(const E& law) {
            if constexpr (HasShapeCommand<E, Scalar>) shapes_.push_back(effect);
            if constexpr (HasCommandDelay<E>) delay += law.command_delay();
            if constexpr (HasLag<E>) {
              require(!lagging_, E::name, "may stand once among the effects, count", 2);
              lagging_ = all(law.lag_time_constant() > 0.0);
              if (lagging_) rate_ = Scalar(1.0) / law.lag_time_constant();
            }
          },
          effect);
    const double samples = delay / sample_time;
    require(samples < 1e6, "command_delay.delay", "must be below a million samples", delay);
    whole_ = static_cast<std::size_t>(samples);
    switch_ = (samples - static_cast<double>(whole_)) * sample_time;
    if (switch_ > sample_time * (1.0 - 1e-9)) ++whole_, switch_ = 0.0;
    if (switch_ < sample_time * 1e-9) switch_ = 0.0;
    history_.assign(whole_ + 2, Scalar(0.0));
  }

  void accept(Scalar command) {
    for (const Effect<Scalar>& effect : shapes_)
      std::visit(
          [&]<class E>(const E& law) {
            if constexpr (HasShapeCommand<E, Scalar>) command = law.shape_command(command);
          },
          effect);
    head_ = head_ + 1 == history_.size() ? 0 : head_ + 1;
    history_[head_] = command;
  }

  /// Within a sample: the offset, s, at which the delayed command changes; 0 where it changes at the sample.
  double switch_offset() const { return switch_; }

  Drive<Scalar> drive(bool before_switch) const {
    const std::size_t age = whole_ + (before_switch ? 1 : 0);
    const Scalar target = history_[head_ >= age ? head_ - age : head_ + history_.size() - age];
    return {target, output_ - target, rate_, Scalar(0.0), lagging_};
  }

  void settle(Drive<Scalar>& drive, double duration) {
    if (!lagging_) return;
    output_ = drive.at(Scalar(duration));
    drive.deviation = output_ - drive.target;
  }

 private:
  double sample_time_, switch_ = 0.0;
  std::size_t whole_ = 0, head_ = 0;
  std::vector<Scalar> history_;
  std::vector<Effect<Scalar>> shapes_;
  bool lagging_ = false;
  Scalar rate_ = 0.0, output_ = 0.0;
};

}  // namespace cogging
