#pragma once
// The amplifier of a log: commands at recorded times, which need not be evenly spaced.

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "cogging/plant/axis.hpp"

namespace cogging {

/// What Amplifier does in a run, for commands that were recorded: shaped, delayed, passed through the current
/// loop. Before the first row, the first command is taken to have acted for ever.
class RecordedAmplifier {
 public:
  RecordedAmplifier(const std::vector<Effect<double>>& effects, std::span<const double> time,
                    std::span<const double> command)
      : time_(time), shaped_(command.begin(), command.end()) {
    for (const Effect<double>& effect : effects)
      std::visit(
          [&]<class E>(const E& law) {
            if constexpr (HasShapeCommand<E, double>)
              for (double& value : shaped_) value = law.shape_command(value);
            if constexpr (HasCommandDelay<E>) delay_ += law.command_delay();
            if constexpr (HasLag<E>) {
              lagging_ = law.lag_time_constant() > 0.0;
              if (lagging_) rate_ = 1.0 / law.lag_time_constant();
            }
          },
          effect);
    output_ = shaped_.front();
  }

  /// Calls piece(drive, start, end) for each part of [start, end] in which one command acts; times in s. Calls
  /// must go forward in time.
  template <class Piece>
  void over(double start, double end, const Piece& piece) {
    double now = start;
    while (now < end) {
      while (acting_ + 1 < shaped_.size() && time_[acting_ + 1] + delay_ <= now + tolerance) ++acting_;
      const double switched =
          acting_ + 1 < shaped_.size() ? time_[acting_ + 1] + delay_ : std::numeric_limits<double>::infinity();
      const double next = switched < end - tolerance ? switched : end;
      Drive<double> drive{shaped_[acting_], output_ - shaped_[acting_], rate_, 0.0, lagging_};
      piece(drive, now, next);
      if (lagging_) output_ = drive.at(next - now);
      now = next;
    }
  }

  /// Mean of what acts over [start, end], V.
  double mean(double start, double end) {
    double sum = 0.0;
    over(start, end, [&](const Drive<double>& drive, double from, double to) {
      const double length = to - from;
      sum += drive.target * length;
      if (drive.lagging) sum += drive.deviation * (1.0 - std::exp(-drive.rate * length)) / drive.rate;
    });
    return sum / (end - start);
  }

 private:
  static constexpr double tolerance = 1e-9;  // s: two times closer than this are one

  std::span<const double> time_;
  std::vector<double> shaped_;
  double delay_ = 0.0, rate_ = 0.0, output_ = 0.0;
  std::size_t acting_ = 0;
  bool lagging_ = false;
};

}  // namespace cogging
