#pragma once
// A controller in its loop, with every step timed: along the moves, at rest, and behind lost readings.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "cogging/reference/point_to_point.hpp"
#include "real_time_instruments.hpp"
#include "real_time_step.hpp"
#include "setups.hpp"
#include "simulated_axis.hpp"

namespace real_time {

using cogging::ReferencePoint;

/// A controller as the loop has it: some memory, its step, and two numbers.
struct Controlled {
  void* memory = nullptr;
  Step step = nullptr;
  double sample_rate = 5000.0, preview = 0.0;
};

/// What a run leaves.
struct Run {
  Histogram durations;
  std::vector<std::uint32_t>* shortest = nullptr;  // ticks of each call, the least of all runs that were given it
  long allocations = 0, denormal = 0;
  double error_squares = 0.0, error_max = 0.0, command_max = 0.0;

  /// One step, timed.
  double take(const Controlled& c, const ReferencePoint& now, const ReferencePoint& ahead, double reading) {
    Denormals::forget();
    const long before = real_time::allocations;
    const std::uint64_t begun = Clock::begin();
    const double command = c.step(c.memory, now, ahead, reading);
    const std::uint64_t ended = Clock::end();
    denormal += Denormals::met();
    allocations += real_time::allocations - before;
    if (shortest != nullptr) {
      auto& least = (*shortest)[static_cast<std::size_t>(durations.count())];
      least = static_cast<std::uint32_t>(std::min<std::uint64_t>(least, ended - begun));
    }
    durations.add(ended - begun);
    const double error = reading - now.position;
    error_squares += error * error;
    error_max = std::fmax(error_max, std::abs(error));
    command_max = std::fmax(command_max, std::abs(command));
    return command;
  }
};

/// The machine and its motion, and how far they have come.
class Loop {
 public:
  explicit Loop(const cogging::PointToPoint& motion) : motion_(motion), axis_(plant(), motion.at(0.0).position) {}

  /// Samples in closed loop; `between` is called before each.
  void run(const Controlled& c, long samples, Run& found, const std::function<void()>& between = {}) {
    for (const long end = sample_ + samples; sample_ < end; ++sample_) {
      if (between) between();
      const double time = static_cast<double>(sample_) / c.sample_rate;
      const double reading = axis_.read(time);
      axis_.write(found.take(c, motion_.at(time), motion_.at(time + c.preview), reading));
    }
  }

 private:
  const cogging::PointToPoint& motion_;
  SimulatedAxis axis_;
  long sample_ = 0;
};

/// A move there and back that ends exactly where it began, then rest: what is not driven any more dies away. Now and
/// then a reading is lost, where `losses` says so.
inline void rest(const Controlled& c, double start, long samples, bool losses, Run& found) {
  cogging::PointToPointParameters once = motion();
  once.start = start;
  once.repeats = 1;
  const cogging::PointToPoint move(once);
  const double resolution = plant().encoder.resolution;
  const long moving = static_cast<long>(move.end() * c.sample_rate) + 1;
  Run before;
  for (long k = 0; k < moving + samples; ++k) {
    const double time = static_cast<double>(k) / c.sample_rate;
    const ReferencePoint now = move.at(time);
    const double behind = resolution * std::round(5.0 * std::sin(300.0 * time));  // as a loop leaves it
    const double reading = losses && k % 5003 < k % 29 ? NAN : k < moving ? now.position + behind : start;
    (k < moving ? before : found).take(c, now, move.at(time + c.preview), reading);
  }
  found.denormal += before.denormal;
  found.allocations += before.allocations;
}

/// Samples behind as many lost readings as a controller makes up for at once.
inline void gaps(const Controlled& c, const cogging::PointToPoint& along, long samples, Run& found) {
  Run lost;
  for (long k = 0; k < 17 * samples; ++k) {
    const double time = static_cast<double>(k) / c.sample_rate;
    const ReferencePoint now = along.at(time), ahead = along.at(time + c.preview);
    if (k % 17 == 0)
      found.take(c, now, ahead, now.position);
    else
      lost.take(c, now, ahead, NAN);
  }
  found.allocations += lost.allocations;
}

/// Readings and reference that have died away into denormal numbers, as those of a simulation or of a filter may.
inline void tiny(const Controlled& c, long samples, Run& found) {
  for (long k = 0; k < samples; ++k) {
    const double x = 1e-310 * (2.0 + std::sin(0.1 * static_cast<double>(k)));
    found.take(c, {x, -x, x}, {x, -x, x}, 2.0 * x);
  }
}

/// What lies in the caches is pushed out, as by all that a machine does between two samples.
inline void evict() {
  static std::vector<unsigned char> other(std::size_t{1} << 25);
  for (std::size_t i = 0; i < other.size(); i += 64) ++other[i];
}

}  // namespace real_time
