#pragma once
// The observer's loop along a prediction, linear: what small forces and errors of the reading add to the innovations.

#include <array>

#include "cogging/elementary.hpp"
#include "cogging/estimation/prediction.hpp"
#include "cogging/simulation/batch.hpp"

namespace cogging {

/// What each of `count` changes adds to the innovations of a prediction along a log (m, (count, rows)): forces (V,
/// (count, rows)), steady over each interval, on a mass (V/(m/s^2)), and errors of the reading (m, (count, rows); null:
/// none).
inline std::vector<double> propagated(const Prediction& along, const Recording& log, const PredictionOptions& options,
                                      double mass, std::size_t count, const double* force, const double* error,
                                      unsigned threads) {
  enum class Way { moves, rests, starts_anew };

  /// From one row to the next: dv/dt = a_x x + a_v v + f / M.
  struct Interval {
    double length;                        // s
    double keep, push;                    // 1, s: what is left of v, and what a steady acceleration of 1 adds to it
    double slope_position;                // 1/s^2
    double position_gain, velocity_gain;  // of the correction: 1, 1/s
    Way way;
  };

  const std::size_t rows = log.time.size();
  require(along.moving.size() == rows, "along", "must be a prediction along this log, rows", along.moving.size());
  const ObserverGain gain(options.bandwidth, median_step(log));
  std::vector<Interval> intervals;
  intervals.reserve(rows - 1);
  for (std::size_t k = 0; k + 1 < rows; ++k) {
    const double h = log.time[k + 1] - log.time[k];
    const double decay = along.slope_velocity[k] * h;
    const double grown = std::abs(decay) < 1e-4 ? 1.0 + 0.5 * decay : expm1(decay) / decay;
    const Way way = h > options.gap ? Way::starts_anew : along.moving[k] == 0.0 ? Way::rests : Way::moves;
    intervals.push_back({h, 1.0 + decay * grown, h * grown, along.slope_position[k],
                         gain.position(step_after(log.time, k + 1)), gain.velocity(h), way});
  }

  constexpr std::size_t abreast = 4;  // changes side by side: one waits for the other's arithmetic
  const double inverse_mass = 1.0 / mass;
  std::vector<double> values(count * rows);
  double* const innovation = values.data();
  run_batch((count + abreast - 1) / abreast, threads, options.stop, [&](std::size_t block) {
    std::array<std::size_t, abreast> first;  // entry of each change; of a block that is not full the last again
    for (std::size_t i = 0; i < abreast; ++i) first[i] = std::min(block * abreast + i, count - 1) * rows;
    std::array<double, abreast> x{}, v{}, wrong{}, next;
    const auto read_errors = [&](std::size_t row) {
      if (error != nullptr)
        for (std::size_t i = 0; i < abreast; ++i) wrong[i] = error[first[i] + row];
    };
    read_errors(0);
    for (std::size_t i = 0; i < abreast; ++i) x[i] = -wrong[i];
    StopCheck stop(options.stop);
    for (std::size_t k = 0; k < intervals.size(); ++k) {
      stop.row();
      const Interval& interval = intervals[k];
      read_errors(k + 1);
      if (interval.way == Way::starts_anew) {
        v.fill(0.0);
        for (std::size_t i = 0; i < abreast; ++i) x[i] = -wrong[i];
        continue;
      }
      if (interval.way == Way::rests) {
        v.fill(0.0);
      } else {
        for (std::size_t i = 0; i < abreast; ++i)
          next[i] = v[i] * interval.keep +
                    (force[first[i] + k] * inverse_mass + interval.slope_position * x[i]) * interval.push;
        for (std::size_t i = 0; i < abreast; ++i) x[i] += 0.5 * interval.length * (v[i] + next[i]);
        v = next;
      }
      for (std::size_t i = 0; i < abreast; ++i) {
        const double seen = -wrong[i] - x[i];
        innovation[first[i] + k + 1] = seen;
        x[i] += interval.position_gain * seen;
        v[i] += interval.velocity_gain * seen;
      }
    }
  });
  return values;
}

}  // namespace cogging
