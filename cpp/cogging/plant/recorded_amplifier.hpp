#pragma once
// The amplifier of a log: commands at recorded times, which need not be evenly spaced.

#include <cstddef>
#include <span>

#include "cogging/elementary.hpp"
#include "cogging/plant/amplifier_laws.hpp"
#include "cogging/plant/state.hpp"

namespace cogging {

/// What Amplifier does in a run, for commands that were recorded: shaped, delayed, passed through the current
/// loop. Before the first row, the first command is taken to have acted for ever.
class RecordedAmplifier : public AmplifierLaws<double> {
 public:
  RecordedAmplifier(const std::vector<Effect<double>>& effects, std::span<const double> time,
                    std::span<const double> command)
      : AmplifierLaws(effects), time_(time), shaped_(command.begin(), command.end()) {
    for (double& value : shaped_) value = shaped(value);
    output_ = shaped_.front();
  }

  /// Calls piece(drive, start, end) for each part of [start, end] in which one command acts; times in s. Calls
  /// must go forward in time.
  template <class Piece>
  void over(double start, double end, const Piece& piece) {
    double now = start;
    while (now < end) {
      while (acting_ + 1 < shaped_.size() && time_[acting_ + 1] + delay() <= now + tolerance) ++acting_;
      const double switched = acting_ + 1 < shaped_.size() ? time_[acting_ + 1] + delay() : infinity;
      const double next = switched < end - tolerance ? switched : end;
      Drive<double> drive{shaped_[acting_], output_ - shaped_[acting_], rate(), 0.0, lagging()};
      piece(drive, now, next);
      if (lagging()) output_ = drive.at(next - now);
      now = next;
    }
  }

  /// Moves a drive on by the time that has passed.
  void settle(Drive<double>& drive, double duration) const {
    if (drive.lagging) drive.deviation *= exp(-drive.rate * duration);
  }

  /// Mean of what acts over [start, end], V.
  double mean(double start, double end) {
    double sum = 0.0;
    over(start, end, [&](const Drive<double>& drive, double from, double to) {
      sum += drive.target * (to - from);
      if (drive.lagging) sum += drive.deviation * (-expm1(-drive.rate * (to - from)) / drive.rate);
    });
    return sum / (end - start);
  }

 private:
  static constexpr double tolerance = 1e-9;  // s: two times closer than this are one

  std::span<const double> time_;
  std::vector<double> shaped_;
  double output_ = 0.0;
  std::size_t acting_ = 0;
};

}  // namespace cogging
