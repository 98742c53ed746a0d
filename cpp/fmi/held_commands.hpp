#pragma once
// The amplifier of a unit: commands that come whenever they come, each held until the next.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <vector>

#include "cogging/plant/amplifier_laws.hpp"
#include "cogging/plant/state.hpp"

namespace cogging::fmi {

/// What Amplifier does in a run, without the grid of the samples: a moment is a sample's number and the time since that
/// sample, so that commands which come with the samples act at the times, to the bit, at which Amplifier has them act.
/// Before the first the command is 0.
class HeldCommands {
 public:
  HeldCommands(const std::vector<Effect<>>& effects, double sample_time) : laws_(effects), sample_time_(sample_time) {
    const double samples = laws_.delay() / sample_time;
    require(samples < 1e6, "command_delay.delay", "must be below a million samples", laws_.delay());
    whole_ = whole_part<std::int64_t>(samples);
    part_ = (samples - static_cast<double>(whole_)) * sample_time;
    carry(whole_, part_);
  }

  /// Raises DivergedError where what is passed on to the motor would not be a number.
  void accept(std::int64_t sample, double since, double command, double time) {
    const double shaped = laws_.shaped(command);
    if (!std::isfinite(shaped))
      throw DivergedError(
          "the run diverged at " + format(time) + " s: the command must be a finite number, got " + format(shaped),
          time);
    std::int64_t acting = sample + whole_;
    double part = since + part_;
    carry(acting, part);
    waiting_.push_back({acting, part, shaped});
  }

  /// Calls piece(drive, from, to) for each part of [from, to], within the sample that begins at `start`, in which one
  /// command acts; times in s.
  template <class Piece>
  void over(std::int64_t sample, double start, double from, double to, const Piece& piece) {
    while (from < to) {
      double until = to;
      while (!waiting_.empty() && waiting_.front().sample <= sample) {
        const double acts = waiting_.front().sample < sample ? from : start + waiting_.front().since;
        if (acts > from) {
          until = std::min(to, acts);
          break;
        }
        target_ = waiting_.front().command;
        waiting_.pop_front();
      }
      piece(Drive<double>{target_, output_ - target_, laws_.rate(), 0.0, laws_.lagging()}, from, until);
      from = until;
    }
  }

  /// See AmplifierLaws::followed_until.
  double followed_until(double now, double changed) const { return laws_.followed_until(now, changed); }

  /// Moves the current loop on by the time that has passed.
  void settle(Drive<double>& drive, double duration) {
    if (!laws_.lagging()) return;
    output_ = drive.at(duration);
    drive.deviation = output_ - drive.target;
  }

 private:
  struct Command {
    std::int64_t sample;    // in which it begins to act
    double since, command;  // s, V
  };

  // Two moments closer than a billionth of a sample are one.
  void carry(std::int64_t& sample, double& part) const {
    if (part > sample_time_ * (1.0 - 1e-9)) ++sample, part = std::max(0.0, part - sample_time_);
    if (part < sample_time_ * 1e-9) part = 0.0;
  }

  AmplifierLaws<> laws_;
  double sample_time_, part_ = 0.0, target_ = 0.0, output_ = 0.0;
  std::int64_t whole_ = 0;
  std::deque<Command> waiting_;
};

}  // namespace cogging::fmi
