#pragma once
// A jerk-limited move there and back, with rests.

#include "cogging/elementary.hpp"
#include "cogging/parameters.hpp"
#include "cogging/reference/reference.hpp"
#include "cogging/require.hpp"

namespace cogging {

struct PointToPointParameters {
  static constexpr std::string_view description = "Limits and rests of a PointToPoint.";

  double start = 0.0;         // m
  double distance = 0.1;      // m, signed
  double velocity = 0.1;      // m/s, limit
  double acceleration = 1.0;  // m/s^2, limit
  double jerk = infinity;     // m/s^3, limit
  double dwell = 0.0;         // s
  int repeats = 1;

  static constexpr auto fields() {
    using P = PointToPointParameters;
    return std::tuple{
        Field{"start", &P::start, "m", "position before the first move"},
        Field{"distance", &P::distance, "m", "length of a move, with its sign", Rule::any},
        Field{"velocity", &P::velocity, "m/s", "limit on the speed", Rule::positive},
        Field{"acceleration", &P::acceleration, "m/s^2", "limit on the acceleration", Rule::positive},
        Field{"jerk", &P::jerk, "m/s^3", "limit on the jerk; infinite = trapezoidal velocity", Rule::above_0},
        Field{"dwell", &P::dwell, "s", "rest after each move", Rule::not_negative},
        Field{"repeats", &P::repeats, "1", "number of moves there and back"}};
  }

  void validate() const {
    require(std::isfinite(distance) && distance != 0.0, "distance", "must be finite and not 0", distance);
    require(repeats >= 1, "repeats", "must be at least 1", repeats);
  }
};

/// The motion of `description`; a short move that cannot reach the velocity or the acceleration limit stays below it.
class PointToPoint final : public Reference {
 public:
  using Parameters = PointToPointParameters;
  static constexpr std::string_view name = "point_to_point";
  static constexpr std::string_view description = R"(Jerk-limited moves there and back.

start -> start + distance -> start, `repeats` times, resting `dwell` after each move. Each move is the fastest under
the limits on velocity, acceleration and jerk that starts and ends at rest with zero acceleration.)";

  explicit PointToPoint(const PointToPointParameters& parameters) : parameters_(validated(parameters)) {
    const double length = std::abs(parameters.distance), jerk = parameters.jerk;
    acceleration_peak_ = parameters.acceleration;
    velocity_peak_ = parameters.velocity;
    const double jerk_time = std::isinf(jerk) ? 0.0 : acceleration_peak_ / jerk;
    // Distance of speeding up and slowing down at once: v (v / a + a / j) once a is reached.
    if (velocity_peak_ * ramp_time(velocity_peak_) > length) {
      velocity_peak_ =
          0.5 * acceleration_peak_ * (std::sqrt(jerk_time * jerk_time + 4.0 * length / acceleration_peak_) - jerk_time);
      if (velocity_peak_ < acceleration_peak_ * jerk_time)  // the acceleration limit is not reached
        velocity_peak_ = jerk * pow(cube_root(length / (2.0 * jerk)), 2.0);
    }
    ramp_ = ramp_time(velocity_peak_);
    if (velocity_peak_ < acceleration_peak_ * jerk_time) {
      jerk_time_ = std::sqrt(velocity_peak_ / jerk);
      acceleration_peak_ = jerk * jerk_time_;
    } else {
      jerk_time_ = jerk_time;
    }
    move_ = ramp_ + length / velocity_peak_;
  }

  const PointToPointParameters& parameters() const { return parameters_; }
  double move_time() const { return move_; }
  /// One move there and back with both rests, s.
  double period() const override { return 2.0 * (move_ + parameters_.dwell); }
  double end() const override { return parameters_.repeats * period(); }

  ReferencePoint at(double time) const override {
    const double start = parameters_.start, goal = parameters_.start + parameters_.distance;
    if (time <= 0.0 || time >= end()) return {start, 0.0, 0.0};
    double local = std::fmod(time, period());
    const bool back = local >= 0.5 * period();
    if (back) local -= 0.5 * period();
    if (local >= move_) return {back ? start : goal, 0.0, 0.0};
    const double from = back ? goal : start;
    const double direction = (parameters_.distance > 0.0) != back ? 1.0 : -1.0;
    const ReferencePoint point = move(local);
    return {from + direction * point.position, direction * point.velocity, direction * point.acceleration};
  }

 private:
  double ramp_time(double velocity) const {
    const double a = parameters_.acceleration, jerk = parameters_.jerk;
    if (std::isinf(jerk)) return velocity / a;
    return velocity >= a * a / jerk ? velocity / a + a / jerk : 2.0 * std::sqrt(velocity / jerk);
  }

  ReferencePoint move(double t) const {
    const double length = std::abs(parameters_.distance);
    if (t > 0.5 * move_) {  // the second half mirrors the first
      const ReferencePoint mirrored = first_half(move_ - t);
      return {length - mirrored.position, mirrored.velocity, -mirrored.acceleration};
    }
    return first_half(t);
  }

  ReferencePoint first_half(double t) const {
    const double a = acceleration_peak_, tj = jerk_time_;
    const double jerk = tj > 0.0 ? a / tj : 0.0;
    if (t < tj) return {jerk * t * t * t / 6.0, 0.5 * jerk * t * t, jerk * t};
    const double v_after_jerk = 0.5 * a * tj;
    if (t < ramp_ - tj) {
      const double s = t - tj;
      return {a * tj * tj / 6.0 + v_after_jerk * s + 0.5 * a * s * s, v_after_jerk + a * s, a};
    }
    if (t < ramp_) {  // the ramp is point-symmetric: distance v/2 T at its end
      const double s = ramp_ - t;
      return {0.5 * velocity_peak_ * ramp_ - velocity_peak_ * s + jerk * s * s * s / 6.0,
              velocity_peak_ - 0.5 * jerk * s * s, jerk * s};
    }
    return {0.5 * velocity_peak_ * ramp_ + velocity_peak_ * (t - ramp_), velocity_peak_, 0.0};
  }

  PointToPointParameters parameters_;
  double velocity_peak_ = 0.0, acceleration_peak_ = 0.0, jerk_time_ = 0.0, ramp_ = 0.0, move_ = 0.0;
};

}  // namespace cogging
