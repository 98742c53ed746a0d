#pragma once
// The amplifier of a log: commands at recorded times, which need not be evenly spaced.

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "cogging/elementary.hpp"
#include "cogging/plant/amplifier_laws.hpp"
#include "cogging/plant/state.hpp"

namespace cogging {

/// What acts over an interval of length h: its mean, and the integral of (h / 2 - s) u(s) from s = 0 to h.
struct CommandMoments {
  double mean = 0.0, excess = 0.0;  // V, V s^2
};

/// What Amplifier does in a run, for commands that were recorded: shaped, delayed, passed through the current
/// loop. Before the first row, the first command is taken to have acted for ever.
class RecordedAmplifier {
 public:
  RecordedAmplifier(const std::vector<Effect<double>>& effects, std::span<const double> time,
                    std::span<const double> command)
      : laws_(effects), time_(time), shaped_(command.begin(), command.end()) {
    for (double& value : shaped_) value = laws_.shaped(value);
    output_ = shaped_.front();
  }

  /// Calls piece(drive, start, end) for each part of [start, end] in which one command acts; times in s. Calls
  /// must go forward in time.
  template <class Piece>
  void over(double start, double end, const Piece& piece) {
    const double delay = laws_.delay();
    double now = start;
    while (now < end) {
      while (acting_ + 1 < shaped_.size() && time_[acting_ + 1] + delay <= now + tolerance) ++acting_;
      const double switched =
          acting_ + 1 < shaped_.size() ? time_[acting_ + 1] + delay : std::numeric_limits<double>::infinity();
      const double next = switched < end - tolerance ? switched : end;
      Drive<double> drive{shaped_[acting_], output_ - shaped_[acting_], laws_.rate(), 0.0, laws_.lagging()};
      piece(drive, now, next);
      if (laws_.lagging()) output_ = drive.at(next - now);
      now = next;
    }
  }

  /// See AmplifierLaws::followed_until.
  double followed_until(double now, double changed) const { return laws_.followed_until(now, changed); }

  /// Moves a drive on by the time that has passed.
  void settle(Drive<double>& drive, double duration) const {
    if (drive.lagging) drive.deviation *= exp(-drive.rate * duration);
  }

  /// Mean of what acts over [start, end], V.
  double mean(double start, double end) { return moments(start, end).mean; }

  /// What acts over [start, end], with how early it does.
  CommandMoments moments(double start, double end) {
    const double middle = 0.5 * (end - start);
    CommandMoments sum;
    over(start, end, [&](const Drive<double>& drive, double from, double to) {
      const double length = to - from, before = from - start;
      sum.mean += drive.target * length;
      sum.excess += drive.target * length * (middle - (before + 0.5 * length));
      if (!drive.lagging) return;
      const double decay = drive.rate * length, settled = -expm1(-decay);
      const double whole = settled / drive.rate;  // integral of exp(-rate s), and of s exp(-rate s)
      const double first = decay < 1e-3 ? length * length * (0.5 - decay * (1.0 / 3.0 - 0.125 * decay))
                                        : (settled - decay * (1.0 - settled)) / (drive.rate * drive.rate);
      sum.mean += drive.deviation * whole;
      sum.excess += drive.deviation * ((middle - before) * whole - first);
    });
    sum.mean /= end - start;
    return sum;
  }

 private:
  static constexpr double tolerance = 1e-9;  // s: two times closer than this are one

  AmplifierLaws<double> laws_;
  std::span<const double> time_;
  std::vector<double> shaped_;
  double output_ = 0.0;
  std::size_t acting_ = 0;
};

}  // namespace cogging
