#pragma once
// The observer's loop along a prediction, linear: what small forces and errors of the reading add to the innovations.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "cogging/elementary.hpp"
#include "cogging/estimation/prediction.hpp"
#include "cogging/simulation/batch.hpp"

namespace cogging {

class ObserverLoop {
 public:
  ObserverLoop(const Prediction& along, const Recording& log, const PredictionOptions& options) : stop_(options.stop) {
    const std::size_t rows = log.time.size();
    require(along.moving.size() == rows, "along", "must be a prediction along this log, rows",
            static_cast<double>(along.moving.size()));
    const ObserverGain gain(options.bandwidth, median_step(log));
    intervals_.reserve(rows - 1);
    for (std::size_t k = 0; k + 1 < rows; ++k) {
      const double h = log.time[k + 1] - log.time[k];
      const double decay = along.slope_velocity[k] * h;
      const double grown = std::abs(decay) < 1e-4 ? 1.0 + 0.5 * decay : expm1(decay) / decay;
      const Kind kind = h > options.gap ? Kind::starts_anew : along.moving[k] == 0.0 ? Kind::rests : Kind::moves;
      intervals_.push_back({h, 1.0 + decay * grown, h * grown, along.slope_position[k],
                            gain.position(step_after(log.time, k + 1)), gain.velocity(h), kind});
    }
  }

  std::size_t rows() const { return intervals_.size() + 1; }

  /// What each of `count` changes adds to the innovations (m, (count, rows)): forces (V, (count, rows)), steady over
  /// each interval, on a mass (V/(m/s^2)), and errors of the reading (m, (count, rows); null: none).
  std::vector<double> pass(double mass, std::size_t count, const double* force, const double* error,
                           unsigned threads) const {
    std::vector<double> innovation(count * rows());
    run_batch((count + abreast - 1) / abreast, threads, stop_, [&](std::size_t block) {
      std::array<std::size_t, abreast> first;  // entry of each change; of a block that is not full the last again
      for (std::size_t i = 0; i < abreast; ++i) first[i] = std::min(block * abreast + i, count - 1) * rows();
      pass_block(1.0 / mass, first, force, error, innovation.data());
    });
    return innovation;
  }

 private:
  static constexpr std::size_t abreast = 4;  // changes side by side: one waits for the other's arithmetic

  enum class Kind { moves, rests, starts_anew };

  /// From one row to the next: dv/dt = a_x x + a_v v + f / M.
  struct Interval {
    double length;                        // s
    double keep, push;                    // 1, s: what is left of v, and what a steady acceleration of 1 adds to it
    double slope_position;                // 1/s^2
    double position_gain, velocity_gain;  // of the correction: 1, 1/s
    Kind kind;
  };

  void pass_block(double inverse_mass, const std::array<std::size_t, abreast>& first, const double* force,
                  const double* error, double* innovation) const {
    std::array<double, abreast> x{}, v{}, wrong{}, next;
    const auto read_errors = [&](std::size_t row) {
      if (error != nullptr)
        for (std::size_t i = 0; i < abreast; ++i) wrong[i] = error[first[i] + row];
    };
    read_errors(0);
    for (std::size_t i = 0; i < abreast; ++i) x[i] = -wrong[i];
    StopCheck stop(stop_);
    for (std::size_t k = 0; k < intervals_.size(); ++k) {
      stop.row();
      const Interval& interval = intervals_[k];
      read_errors(k + 1);
      if (interval.kind == Kind::starts_anew) {
        v.fill(0.0);
        for (std::size_t i = 0; i < abreast; ++i) x[i] = -wrong[i];
        continue;
      }
      if (interval.kind == Kind::rests) {
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
  }

  std::vector<Interval> intervals_;
  StopRequest* stop_;
};

}  // namespace cogging
