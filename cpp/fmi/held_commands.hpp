#pragma once
// The amplifier of a unit: commands that come whenever they come, each held until the next.

#include <deque>

#include "cogging/plant/amplifier_laws.hpp"
#include "cogging/plant/state.hpp"

namespace cogging::fmi {

/// What Amplifier does in a run, without the grid of the samples: a moment is a sample's number and the time since that
/// sample, so that commands which come with the samples act at the times, to the bit, at which Amplifier has them act.
/// Before the first the command is 0.
class HeldCommands : public AmplifierLaws<> {
 public:
  HeldCommands(const std::vector<Effect<>>& effects, double sample_time)
      : AmplifierLaws(effects), sample_time_(sample_time), delay_(delay_in_samples(sample_time)) {
    // As in a run, the samples before the first command acts are cut where it would switch.
    for (std::int64_t sample = 0; sample < delay_.sample; ++sample) waiting_.push_back({{sample, delay_.since}, 0.0});
  }

  /// Raises DivergedError where what is passed on to the motor would not be a number.
  void accept(std::int64_t sample, double since, double command, double time) {
    const double passed = shaped(command);
    if (!std::isfinite(passed))
      throw DivergedError(
          "the run diverged at " + format(time) + " s: the command must be a finite number, got " + format(passed),
          time);
    SampleMoment acts{sample + delay_.sample, since + delay_.since};
    acts.carry(sample_time_);
    waiting_.push_back({acts, passed});
  }

  /// Calls piece(drive, from, to) for each part of [from, to], within the sample that begins at `start`, in which one
  /// command acts; times in s.
  template <class Piece>
  void over(std::int64_t sample, double start, double from, double to, const Piece& piece) {
    while (from < to) {
      double until = to;
      while (!waiting_.empty() && waiting_.front().acts.sample <= sample) {
        const SampleMoment& next = waiting_.front().acts;
        const double acts = next.sample < sample ? from : start + next.since;
        if (acts > from) {
          until = std::min(to, acts);
          break;
        }
        target_ = waiting_.front().value;
        waiting_.pop_front();
      }
      piece(Drive<double>{target_, output_ - target_, rate(), 0.0, lagging()}, from, until);
      from = until;
    }
  }

  /// Moves the current loop on by the time that has passed.
  void settle(Drive<double>& drive, double duration) {
    if (!lagging()) return;
    output_ = drive.at(duration);
    drive.deviation = output_ - drive.target;
  }

 private:
  struct Command {
    SampleMoment acts;  // when it begins to
    double value;       // V
  };

  double sample_time_, target_ = 0.0, output_ = 0.0;
  SampleMoment delay_;
  std::deque<Command> waiting_;
};

}  // namespace cogging::fmi
