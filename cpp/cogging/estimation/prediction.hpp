#pragma once
// One step ahead along a log: the plant is driven by the recorded command and held to the recorded position by
// a fixed-gain observer. What it fails to foresee, the innovation, is what the model does not explain.

#include "cogging/elementary.hpp"
#include "cogging/interruption.hpp"
#include "cogging/plant/integration.hpp"
#include "cogging/plant/plant.hpp"
#include "cogging/plant/recorded_amplifier.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// The columns of a log that a prediction needs; time strictly increasing.
struct Recording {
  std::span<const double> time;      // s
  std::span<const double> position;  // m, readings
  std::span<const double> command;   // V
  double median_step = 0.0;          // s; 0 = not known, to be found in `time`
};

struct PredictionOptions {
  double bandwidth = 30.0;        // Hz, of the observer: both its poles stand at exp(-2 pi bandwidth Ts)
  double gap = 1e30;              // s: after a longer step the observer starts anew
  double initial_velocity = 0.0;  // m/s
  int steps_per_sample = 1;
  StopRequest* stop = nullptr;  // asked in every few rows whether to end
};

/// One entry a row; entry k of the middle_* and slope_* columns belongs to the interval from row k to k + 1.
struct Prediction {
  std::vector<double> innovation;       // m, reading less what was foreseen; 0 in the first row and after a gap
  std::vector<double> position;         // m, corrected by the reading
  std::vector<double> velocity;         // m/s, corrected by the reading
  std::vector<double> middle_position;  // m, half-way through the interval
  std::vector<double> middle_velocity;  // m/s
  std::vector<double> slope_position;   // 1/s^2, d acceleration / d position
  std::vector<double> slope_velocity;   // 1/s, d acceleration / d velocity
  std::vector<double> moving;           // 1, or 0 where the axis stuck to the end of the interval
};

/// Correction of the observer, both its poles at exp(-2 pi bandwidth h) where the steps h are even.
///
/// Where they jitter, gains that go with each step alone would let the jitter through: a force that the model lacks
/// would then show at high frequencies, where encoders are quiet, and be taken for what it is not. With
///   velocity gain c h_before,  position gain d h_after + c h_after^2 / 2
/// a constant force leaves the same innovation, force / (M c), in every row, whatever the steps.
class ObserverGain {
 public:
  ObserverGain(double bandwidth, double sample_time) {
    const double pole = exp(-2.0 * std::numbers::pi * bandwidth * sample_time);
    curvature_ = (1.0 - pole) * (1.0 - pole) / (sample_time * sample_time);
    slope_ = (1.0 - pole * pole) / sample_time - 0.5 * curvature_ * sample_time;
    longest_ = 4.0 * sample_time;
  }

  /// Position gain in a row that is followed by a step of length `after`, s.
  double position(double after) const {
    const double h = std::min(after, longest_);
    return std::min(1.0, slope_ * h + 0.5 * curvature_ * h * h);
  }
  /// Velocity gain, 1/s, in a row that follows a step of length `before`, s.
  double velocity(double before) const { return curvature_ * std::min(before, longest_); }

 private:
  double curvature_, slope_, longest_;  // c, 1/s^2; d, 1/s; s
};

/// The median step of a log, s.
inline double median_step(std::span<const double> time) {
  std::vector<double> steps(time.size() - 1);
  for (std::size_t k = 0; k + 1 < time.size(); ++k) steps[k] = time[k + 1] - time[k];
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// The median step of a recording, s.
inline double median_step(const Recording& log) {
  return log.median_step > 0.0 ? log.median_step : median_step(log.time);
}

/// The step that follows a row, s; behind the last row, the one before it.
inline double step_after(std::span<const double> time, std::size_t row) {
  return row + 1 < time.size() ? time[row + 1] - time[row] : time[row] - time[row - 1];
}

namespace detail {

inline Prediction empty_prediction(std::size_t rows, bool with_slopes) {
  Prediction result;
  for (auto* column : {&result.innovation, &result.position, &result.velocity}) column->assign(rows, 0.0);
  if (with_slopes)
    for (auto* column : {&result.middle_position, &result.middle_velocity, &result.slope_position,
                         &result.slope_velocity, &result.moving})
      column->assign(rows, 0.0);
  return result;
}

/// Moves the axis from one row of a log to the next; the mean of the command that acts, V.
inline double advance_interval(const Axis<double>& axis, RecordedAmplifier& amplifier, AxisState<double>& state,
                               double start, double end, int steps_per_sample) {
  const double h = end - start;
  const auto steps_of = [&](double from, double to) {
    return std::max(1, whole_part(std::ceil(steps_per_sample * (to - from) / h - 1e-9)));
  };
  double acting = 0.0;
  amplifier.over(start, end, [&](const Drive<double>& drive, double from, double to) {
    acting += drive.at(0.5 * (to - from)) * (to - from);
    Drive<double> settling = drive;
    advance_through_events(axis, amplifier, state, settling, from, to, steps_of);
  });
  return acting / h;
}

/// Half-way through the interval behind a row: where the axis is, and what a change there makes of its acceleration.
/// `command` (V) is what acts, `time` (s) that of the middle.
inline void write_slopes(Prediction& result, std::size_t row, const Axis<double>& axis, const AxisState<double>& before,
                         const AxisState<double>& after, double command, double time) {
  const double width = axis.parameters().coulomb_width;
  const double x = 0.5 * (before.position + after.position), v = 0.5 * (before.velocity + after.velocity);
  const auto acceleration = [&](double position, double velocity) {
    return axis.acceleration(position, velocity, command, time);
  };
  result.middle_position[row] = x;
  result.middle_velocity[row] = v;
  result.moving[row] = after.velocity == 0.0 ? 0.0 : 1.0;
  const double side = width == 0.0 ? 0.5 * std::abs(v) : std::max(1e-6, 0.3 * width);  // a sign must not be crossed
  if (side > 0.0) result.slope_velocity[row] = (acceleration(x, v + side) - acceleration(x, v - side)) / (2.0 * side);
  constexpr double across = 1e-6;
  result.slope_position[row] = (acceleration(x + across, v) - acceleration(x - across, v)) / (2.0 * across);
}

}  // namespace detail

inline Prediction predict(const Plant<double>& plant, const Recording& log, const PredictionOptions& options,
                          bool with_slopes) {
  const std::size_t rows = log.time.size();
  require(rows >= 2, "log", "must have at least 2 rows", rows);
  Axis<double> axis(plant.axis, plant.cogging, plant.effects);
  axis.leave_steps();  // each row is held to its reading: what one step errs by does not add up
  RecordedAmplifier amplifier(plant.effects, log.time, log.command);
  StopCheck stop(options.stop);
  stop.ask();  // finding the median takes long
  const ObserverGain gain(options.bandwidth, median_step(log));
  Prediction result = detail::empty_prediction(rows, with_slopes);

  // Where the axis is when the encoder shows `reading`: its error is small against the scale on which it changes.
  const auto behind = [&](double reading) { return 2.0 * reading - encoder_position(plant.effects, reading); };
  AxisState<double> state{behind(log.position[0]), options.initial_velocity};
  for (std::size_t k = 0; k < rows; ++k) {
    stop.row();
    result.position[k] = state.position;
    result.velocity[k] = state.velocity;
    if (k + 1 == rows) break;
    const double start = log.time[k], end = log.time[k + 1], h = end - start;
    const AxisState<double> before = state;
    if (h > options.gap) {  // not followed: it may last a year
      amplifier.over(start, end, [](const Drive<double>&, double, double) {});
      state = {behind(log.position[k + 1]), (log.position[k + 1] - log.position[k]) / h};
      if (with_slopes) result.middle_position[k] = 0.5 * (before.position + state.position);
      if (with_slopes) result.middle_velocity[k] = state.velocity;
      continue;
    }
    const double acting = detail::advance_interval(axis, amplifier, state, start, end, options.steps_per_sample);
    if (with_slopes) detail::write_slopes(result, k, axis, before, state, acting, 0.5 * (start + end));
    if (!std::isfinite(state.position) || !std::isfinite(state.velocity))
      throw DivergedError("the prediction diverged at " + format(end) + " s", end);
    const double innovation = log.position[k + 1] - encoder_position(plant.effects, state.position);
    result.innovation[k + 1] = innovation;
    state.position += gain.position(step_after(log.time, k + 1)) * innovation;
    state.velocity += gain.velocity(h) * innovation;
  }
  return result;
}

/// Writes what pushes the axis of each lane along a given motion: command that acts, effects, friction and cogging, V:
/// mass times acceleration. Position and velocity are those half-way between row k and row k + 1; the last entry
/// repeats. There is an amplifier for each lane, or one for all; lanes without a row in `forces` are left out.
template <class Scalar>
void write_net_force(const Plant<Scalar>& plant, std::vector<RecordedAmplifier> amplifiers, const Recording& log,
                     std::span<const double> middle_position, std::span<const double> middle_velocity,
                     std::span<double* const> forces, StopRequest* request = nullptr) {
  const std::size_t rows = log.time.size();
  require(rows >= 2, "log", "must have at least 2 rows", rows);
  const Axis<Scalar> axis(plant.axis, plant.cogging, plant.effects);
  StopCheck stop(request);
  for (std::size_t k = 0; k + 1 < rows; ++k) {
    stop.row();
    const double start = log.time[k], end = log.time[k + 1];
    Scalar command = amplifiers[0].mean(start, end);
    for (std::size_t i = 1; i < amplifiers.size(); ++i) set_lane(command, i, amplifiers[i].mean(start, end));
    const Scalar force = plant.axis.mass * axis.acceleration(Scalar(middle_position[k]), Scalar(middle_velocity[k]),
                                                             command, 0.5 * (start + end));
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i][k] = lane(force, i);
  }
  for (double* force : forces) force[rows - 1] = force[rows - 2];
}

}  // namespace cogging
