#pragma once
// The observer's loop along a prediction, linear: what passes a small change on from row to row. Its coefficients are
// worked out once, for however many changes are passed through it.

#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "cogging/elementary.hpp"
#include "cogging/estimation/prediction.hpp"
#include "cogging/simulation/batch.hpp"

namespace cogging {

class ObserverLoop {
 public:
  enum class Kind { moves, rests, starts_anew };

  /// From one row to the next: dv/dt = a_x x + a_v v + f / M.
  struct Interval {
    double length;                        // s
    double keep, push;                    // 1, s: what is left of v, and what a steady acceleration of 1 adds to it
    double slope_position;                // 1/s^2
    double position_gain, velocity_gain;  // of the correction: 1, 1/s
    Kind kind;
  };

  ObserverLoop(const Prediction& along, const Recording& log, const PredictionOptions& options) : stop_(options.stop) {
    const std::size_t rows = log.time.size();
    require(along.moving.size() == rows, "along", "must be a prediction along this log, rows",
            static_cast<double>(along.moving.size()));
    const ObserverGain gain(options.bandwidth, median_step(log));
    std::vector<Interval> intervals;
    intervals.reserve(rows - 1);
    for (std::size_t k = 0; k + 1 < rows; ++k) {
      const double h = log.time[k + 1] - log.time[k];
      const double decay = along.slope_velocity[k] * h;
      const double grown = std::abs(decay) < 1e-4 ? 1.0 + 0.5 * decay : expm1(decay) / decay;
      const Kind kind = h > options.gap ? Kind::starts_anew : along.moving[k] == 0.0 ? Kind::rests : Kind::moves;
      intervals.push_back({h, 1.0 + decay * grown, h * grown, along.slope_position[k],
                           gain.position(step_after(log.time, k + 1)), gain.velocity(h), kind});
    }
    intervals_ = std::make_shared<const std::vector<Interval>>(std::move(intervals));
  }

  std::size_t rows() const { return intervals_->size() + 1; }
  const std::vector<Interval>& intervals() const { return *intervals_; }
  /// What passes through this loop asks.
  StopRequest* stop() const { return stop_; }
  /// The same loop, in which another is asked.
  ObserverLoop heeding(StopRequest* stop) const {
    ObserverLoop other = *this;
    other.stop_ = stop;
    return other;
  }

  /// What the innovations (m) gain from small forces: `width` independent changes side by side, one entry a row each.
  ///
  /// A force acts in each interval by its mean (V) and by its excess (V s^2), the integral of (h / 2 - s) f(s) from
  /// s = 0 to h: 0 where the force is steady, and more where it comes early, so that it has longer to move the axis.
  /// The reading may have an error (m). Either may be null.
  template <std::size_t width>
  void pass(double mass, const std::array<const double*, width>& force, const std::array<const double*, width>& excess,
            const std::array<const double*, width>& error, const std::array<double*, width>& innovation) const {
    Course<width> course{1.0 / mass, force, excess, error, innovation, {}, {}};
    course.begin();
    StopCheck stop(stop_);
    const std::vector<Interval>& intervals = *intervals_;
    for (std::size_t k = 0; k < intervals.size();) {
      const std::size_t asked_again = stop.rows_until(k, intervals.size());
      for (; k < asked_again; ++k) course.follow(intervals[k], k);
    }
  }

 private:
  /// Changes of position and velocity that go through the loop side by side.
  template <std::size_t width>
  struct Course {
    double inverse_mass;
    const std::array<const double*, width>&force, &excess, &error;
    const std::array<double*, width>& innovation;
    std::array<double, width> x, v;

    void begin() {
      for (std::size_t i = 0; i < width; ++i) {
        innovation[i][0] = 0.0;
        if (error[0] != nullptr) x[i] = -error[i][0];
      }
    }

    COGGING_INLINE void follow(const Interval& interval, std::size_t k) {
      std::array<double, width> wrong{};
      if (error[0] != nullptr)
        for (std::size_t i = 0; i < width; ++i) wrong[i] = error[i][k + 1];
      if (interval.kind == Kind::starts_anew) {
        for (std::size_t i = 0; i < width; ++i) {
          innovation[i][k + 1] = 0.0;
          x[i] = -wrong[i];
          v[i] = 0.0;
        }
        return;
      }
      if (interval.kind == Kind::rests) {
        v.fill(0.0);
      } else {
        const double half = 0.5 * interval.length;
        std::array<double, width> next;
        for (std::size_t i = 0; i < width; ++i)
          next[i] =
              v[i] * interval.keep + (force[i][k] * inverse_mass + interval.slope_position * x[i]) * interval.push;
        for (std::size_t i = 0; i < width; ++i) x[i] += half * (v[i] + next[i]);
        if (excess[0] != nullptr)
          for (std::size_t i = 0; i < width; ++i) x[i] += excess[i][k] * inverse_mass;
        v = next;
      }
      for (std::size_t i = 0; i < width; ++i) {
        const double seen = -wrong[i] - x[i];
        innovation[i][k + 1] = seen;
        x[i] += interval.position_gain * seen;
        v[i] += interval.velocity_gain * seen;
      }
    }
  };

  std::shared_ptr<const std::vector<Interval>> intervals_;
  StopRequest* stop_;
};

/// Changes that are passed through the observer's loop side by side: one waits for the other's arithmetic.
inline constexpr std::size_t abreast = 4;

/// Numbers from 0 to count - 1 in blocks of `abreast` and then one by one, a job each, on threads.
template <class Block, class Single>
void in_blocks(std::size_t count, unsigned threads, StopRequest* stop, const Block& block, const Single& single) {
  const std::size_t blocks = count / abreast, left = count % abreast;
  run_batch(blocks + left, threads, stop, [&](std::size_t job) {
    if (job < blocks)
      block(job * abreast);
    else
      single(blocks * abreast + job - blocks);
  });
}

/// `width` rows of a table from the first one on; null pointers where there is no table.
template <std::size_t width, class Pointer>
std::array<Pointer, width> rows_from(Pointer table, std::size_t first, std::size_t rows) {
  std::array<Pointer, width> result{};
  if (table != nullptr)
    for (std::size_t i = 0; i < width; ++i) result[i] = table + (first + i) * rows;
  return result;
}

/// What forces (V, count rows of one entry a row of the log), and errors of the reading (m, or null), add to the
/// innovations, m.
inline std::vector<double> pass_all(const ObserverLoop& loop, double mass, std::size_t count, const double* force,
                                    const double* error, unsigned threads) {
  const std::size_t rows = loop.rows();
  std::vector<double> innovation(count * rows);
  const auto pass = [&]<std::size_t width>(std::integral_constant<std::size_t, width>, std::size_t first) {
    loop.pass<width>(mass, rows_from<width>(force, first, rows), rows_from<width, const double*>(nullptr, 0, 0),
                     rows_from<width>(error, first, rows), rows_from<width>(innovation.data(), first, rows));
  };
  in_blocks(
      count, threads, loop.stop(),
      [&](std::size_t first) { pass(std::integral_constant<std::size_t, abreast>(), first); },
      [&](std::size_t one) { pass(std::integral_constant<std::size_t, 1>(), one); });
  return innovation;
}

struct Adjoint {
  std::vector<double> force;    // by which a force over the interval from row k to k + 1 counts
  std::vector<double> reading;  // by which an error of the reading in row k counts
};

/// The transpose of ObserverLoop::pass: sum_k weight_k innovation_k = sum_k adjoint.force_k force_k +
/// adjoint.reading_k error_k. One backward pass answers for every force that one may think of.
inline Adjoint pass_transposed(const ObserverLoop& loop, double mass, std::span<const double> weight) {
  const std::size_t rows = loop.rows();
  Adjoint result{std::vector<double>(rows, 0.0), std::vector<double>(rows, 0.0)};
  double x = 0.0, v = 0.0;  // sensitivities of the sum to the state after the correction
  StopCheck stop(loop.stop());
  for (std::size_t k = rows - 1; k-- > 0;) {
    stop.row();
    const ObserverLoop::Interval& interval = loop.intervals()[k];
    if (interval.kind == ObserverLoop::Kind::starts_anew) {
      result.reading[k + 1] = -x;
      x = v = 0.0;
      continue;
    }
    const double seen = weight[k + 1] + interval.position_gain * x + interval.velocity_gain * v;
    result.reading[k + 1] = -seen;
    x -= seen;
    if (interval.kind == ObserverLoop::Kind::rests) {
      v = 0.0;
      continue;
    }
    const double half = 0.5 * interval.length;
    const double after = v + half * x;
    result.force[k] = after * interval.push / mass;
    v = after * interval.keep + half * x;
    x += after * interval.slope_position * interval.push;
  }
  result.reading[0] = -x;
  return result;
}

}  // namespace cogging
