#pragma once
// What a load of its own adds to the innovations, to first order along the prediction of the plant that is one mass.
//
// With mu = load / total, z the deflection of the load and K the force by which it pulls the motor,
//   z'' = -f / m1 - K (1 / m1 + 1 / m2),  x = X - mu z,  M X'' = f
// where X is the centre of mass, f the net force along the prediction and what it changes by as the motor shakes:
// M (a_x x + a_v v). The part of a_v that is steady, the viscous friction, damps z in the exact solution; the rest is
// taken as steady over each interval.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <tuple>
#include <vector>

#include "cogging/elementary.hpp"
#include "cogging/estimation/observer_loop.hpp"
#include "cogging/plant/axis.hpp"
#include "cogging/plant/coupling.hpp"
#include "cogging/plant/integration.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

struct Deflection {
  double value = 0.0, rate = 0.0;  // m, m/s
};

/// z'' = push - damping z' - stiffness z, advanced by its exact solution with the push held.
class Oscillator {
 public:
  Oscillator(double stiffness, double damping) : stiffness_(stiffness), damping_(damping) {}

  void prepare(double h) {
    if (std::abs(h - length_) <= 1e-6 * length_) return;  // steps that differ by the rounding of the times are one
    length_ = h;
    const double half = 0.5 * damping_, inner = stiffness_ - half * half;
    const double root = std::sqrt(std::abs(inner));
    double cosine, sine;  // of root h, times the decay; the sine over root
    if (root * h < 1e-6) {
      cosine = exp(-half * h);
      sine = cosine * h;
    } else if (inner > 0.0) {
      const double decay = exp(-half * h);
      sin_cos(root * h, sine, cosine);
      cosine *= decay;
      sine = decay * sine / root;
    } else {
      const double slow = exp((root - half) * h), fast = exp(-(root + half) * h);
      cosine = 0.5 * (slow + fast);
      sine = 0.5 * (slow - fast) / root;
    }
    value_of_value_ = cosine + half * sine;
    rate_of_rate_ = cosine - half * sine;
    rate_of_push_ = sine;
    value_of_push_ =
        stiffness_ * h * h < 1e-6 ? h * h * (0.5 - damping_ * h / 6.0) : (1.0 - value_of_value_) / stiffness_;
  }

  /// What a push of 1 m/s^2 adds.
  Deflection pushed() const { return {value_of_push_, rate_of_push_}; }

  Deflection advance(const Deflection& z, double push) const {
    return {value_of_value_ * z.value + rate_of_push_ * z.rate + value_of_push_ * push,
            -stiffness_ * rate_of_push_ * z.value + rate_of_rate_ * z.rate + rate_of_push_ * push};
  }

 private:
  double stiffness_, damping_, length_ = -1.0;
  double value_of_value_ = 1.0, rate_of_rate_ = 1.0, rate_of_push_ = 0.0, value_of_push_ = 0.0;
};

/// A load that is held without play, free with the motor, or by a motor at rest.
class SpringLoad {
 public:
  SpringLoad(const CouplingParameters& coupling, double viscous_rate)
      : SpringLoad(coupling, viscous_rate, rate(coupling)) {}

  void prepare(double h, bool rests) { (rests ? resting_ : moving_).prepare(h); }
  Deflection pushed(double) const { return moving_.pushed(); }
  Deflection advance(const Deflection& z, double push, double, bool rests) const {
    return (rests ? resting_ : moving_).advance(z, push);
  }

 private:
  static double rate(const CouplingParameters& coupling) { return 2.0 * std::numbers::pi * coupling.frequency; }

  SpringLoad(const CouplingParameters& coupling, double viscous_rate, double w)
      : moving_(w * w, 2.0 * coupling.damping_ratio * w + viscous_rate),
        resting_(w * w * (1.0 - coupling.mass_ratio), 2.0 * coupling.damping_ratio * w * (1.0 - coupling.mass_ratio)) {}

  Oscillator moving_, resting_;
};

/// A load with play: the exact solution while it stays in one piece of the contact's law, Runge-Kutta of fourth order
/// over a row in which it passes from one to another, in substeps as in BodyWithStates.
class LooseLoad {
 public:
  LooseLoad(const CouplingParameters& coupling, double mass, double viscous_rate)
      : coupling_(coupling, mass), viscous_rate_(viscous_rate) {}

  void prepare(double h, bool rests) {
    half_ = 0.5 * h;
    damping_ = rests ? 0.0 : viscous_rate_;
    inverse_ = 1.0 / coupling_.load_mass() + (rests ? 0.0 : 1.0 / coupling_.motor_mass());
  }
  Deflection pushed(double h) const { return {0.5 * h * h, h}; }  // while it is free

  Deflection advance(const Deflection& z, double push, double h, bool rests) {
    const Coupling::Piece piece = coupling_.piece(z.value, z.rate);
    Oscillator& solution = solution_of(piece, rests);
    solution.prepare(half_);
    Deflection next{z.value - piece.origin, z.rate};
    for (int half = 0; half < 2; ++half) {
      next = solution.advance(next, push);
      if (coupling_.piece(next.value + piece.origin, next.rate) != piece) return in_steps(z, push, h);
    }
    return {next.value + piece.origin, next.rate};
  }

 private:
  struct Solution {
    double stiffness;
    bool rests = false;
    Oscillator oscillator;
  };

  /// Of a piece of the law; there are few, each known by its stiffness.
  Oscillator& solution_of(const Coupling::Piece& piece, bool rests) {
    for (Solution& one : solutions_)
      if (one.stiffness == piece.stiffness && one.rests == rests) return one.oscillator;
    solutions_.push_back(
        {piece.stiffness, rests, Oscillator(piece.stiffness * inverse_, piece.damping * inverse_ + damping_)});
    return solutions_.back().oscillator;
  }

  Deflection in_steps(Deflection z, double push, double h) const {
    // The slope of a Deflection has its two parts: the rate, and the rate of that.
    const auto slope_at = [&](const Deflection& at, double held) {
      return Deflection{at.rate, held - damping_ * at.rate - coupling_.force(at.value, at.rate) * inverse_};
    };
    const double needed = std::ceil(4.0 * coupling_.rate() * h);
    require(needed <= 1e5, "frequency", "must need at most 1e5 substeps a step", needed);
    const int pieces = std::max(1, whole_part(needed));
    const double step = h / pieces;
    for (int piece = 0; piece < pieces; ++piece) {
      const auto moved = [&z](const Deflection& slope, double length) {
        return Deflection{z.value + length * slope.value, z.rate + length * slope.rate};
      };
      const Stages<Deflection> slopes = runge_kutta(slope_at(z, push), step, push, push, moved, slope_at);
      z.value += step / 6.0 * slopes.sum(&Deflection::value);
      z.rate += step / 6.0 * slopes.sum(&Deflection::rate);
    }
    return z;
  }

  Coupling coupling_;
  double viscous_rate_, half_ = 0.0, damping_ = 0.0, inverse_ = 0.0;
  std::vector<Solution> solutions_;
};

/// Of the gap that is meant: what a load with play does is the mean over them (see expected_prediction).
inline constexpr std::array play_shares{1.0, 0.7, 0.85, 1.15, 1.3};

/// Decay, 1/s, of the vibration of a load without play: the damper's, and that of friction on the motor.
inline double decay_rate(const CouplingParameters& coupling, const AxisParameters<double>& axis) {
  const double mu = coupling.mass_ratio;
  return 2.0 * std::numbers::pi * coupling.frequency * coupling.damping_ratio +
         0.5 * axis.viscous / axis.mass * mu / (1.0 - mu);
}

/// How far the motor and its load are from the prediction, by the way and the speed of their centre of mass.
struct LoadedMotion {
  double x = 0.0, v = 0.0;  // m, m/s
  Deflection z;
};

/// Over an interval in which the motor rests and the load swings.
template <class Load>
void advance_at_rest(LoadedMotion& at, Load& load, double mass_ratio, double h) {
  const double motor = at.x - mass_ratio * at.z.value;
  load.prepare(h, true);
  at.z = load.advance(at.z, 0.0, h, true);
  at.x = motor + mass_ratio * at.z.value;
  at.v = mass_ratio * at.z.rate;
}

/// What acts over an interval: net force along the prediction, V, d acceleration / d position and d velocity, 1/s^2,
/// 1/s.
struct LoadedInterval {
  double length, force, slope_position, slope_velocity;
};

/// Over an interval in which both move.
template <class Load>
void advance_moving(LoadedMotion& at, Load& load, double mass_ratio, const AxisParameters<double>& axis,
                    const LoadedInterval& interval) {
  const double h = interval.length, inverse_motor = 1.0 / (1.0 - mass_ratio), steady = -axis.viscous / axis.mass;
  const double pulled = interval.slope_position * (at.x - mass_ratio * at.z.value);
  const double push = -(interval.force / axis.mass + steady * at.v + pulled) * inverse_motor;
  load.prepare(h, false);
  Deflection next = load.advance(at.z, push, h, false);
  double v_next = at.v + steady * (h * at.v - mass_ratio * (next.value - at.z.value)) + h * pulled;
  // The rest of the friction's slope: half-way, and towards the end of the interval where it is steep.
  const double slope = interval.slope_velocity - steady, steep = -slope * h * inverse_motor;
  const double late = steep < 2.0 ? 0.5 : 1.0 - 1.0 / steep;
  const double answer = h + mass_ratio * inverse_motor * load.pushed(h).rate;
  const double braked = slope *
                        ((1.0 - late) * (at.v - mass_ratio * at.z.rate) + late * (v_next - mass_ratio * next.rate)) /
                        (1.0 - slope * late * answer);
  next = load.advance(at.z, push - braked * inverse_motor, h, false);
  v_next += h * braked;
  at.x += 0.5 * h * (at.v + v_next);
  at.v = v_next;
  at.z = next;
}

/// Over the interval from row k to the next: what the load adds to the innovation there, m.
template <class Load>
double pass_interval(LoadedMotion& at, Load& load, double mass_ratio, const AxisParameters<double>& axis,
                     const ObserverLoop::Interval& interval, double force, double slope_velocity) {
  if (interval.kind == ObserverLoop::Kind::starts_anew) {
    at = {};
    return 0.0;
  }
  if (interval.kind == ObserverLoop::Kind::rests)
    advance_at_rest(at, load, mass_ratio, interval.length);
  else
    advance_moving(at, load, mass_ratio, axis, {interval.length, force, interval.slope_position, slope_velocity});
  const double seen = mass_ratio * at.z.value - at.x;
  at.x += interval.position_gain * seen;
  at.v += interval.velocity_gain * seen;
  return seen;
}

/// A load of its own along a prediction, and where it is.
template <class Load>
struct PassedLoad {
  Load load;
  double mass_ratio;
  LoadedMotion at = {};
};

/// What loads add to the innovations, side by side: one waits for the other's arithmetic. write(k, what each adds in
/// row k, m); nothing is added in the first row.
///
/// `force`: net force along the prediction, V, of the plant as one mass.
template <class Load, std::size_t count, class Write>
void pass_loads(std::array<PassedLoad<Load>, count> loads, const AxisParameters<double>& axis, const ObserverLoop& loop,
                std::span<const double> slope_velocity, std::span<const double> force, const Write& write) {
  std::array<double, count> seen{};
  write(std::size_t{0}, seen);
  StopCheck stop(loop.stop());
  for (std::size_t k = 0; k + 1 < loop.rows(); ++k) {
    stop.row();
    const ObserverLoop::Interval& interval = loop.intervals()[k];
    for (std::size_t i = 0; i < count; ++i)
      seen[i] =
          pass_interval(loads[i].at, loads[i].load, loads[i].mass_ratio, axis, interval, force[k], slope_velocity[k]);
    write(k + 1, seen);
  }
}

/// Friction acts on the motor alone, and so damps the vibration: d acceleration / d velocity by it, 1/s, without sign.
inline double viscous_rate(const CouplingParameters& coupling, const AxisParameters<double>& axis) {
  return axis.viscous / axis.mass * coupling.mass_ratio / (1.0 - coupling.mass_ratio);
}

inline bool has_play(const CouplingParameters& coupling) {
  return coupling.gap != 0.0 || coupling.pushes_only;
}

/// What loads without play add to the innovations (m, one entry a row; each written to its own).
template <std::size_t count>
void pass_springs(const std::array<CouplingParameters, count>& couplings, const AxisParameters<double>& axis,
                  const ObserverLoop& loop, std::span<const double> slope_velocity, std::span<const double> force,
                  const std::array<double*, count>& innovation) {
  const auto loads = std::apply(
      [&](const auto&... one) {
        return std::array{PassedLoad<SpringLoad>{SpringLoad(one, viscous_rate(one, axis)), one.mass_ratio}...};
      },
      couplings);
  pass_loads(loads, axis, loop, slope_velocity, force, [&](std::size_t row, const std::array<double, count>& seen) {
    for (std::size_t i = 0; i < count; ++i) innovation[i][row] = seen[i];
  });
}

/// What a load with play adds to the innovations (m, one entry a row; written): the mean over play_shares.
inline void pass_loose(const CouplingParameters& coupling, const AxisParameters<double>& axis, const ObserverLoop& loop,
                       std::span<const double> slope_velocity, std::span<const double> force, double* innovation) {
  const auto with_share = [&](double share) {
    CouplingParameters other = coupling;
    other.gap *= share;
    return PassedLoad<LooseLoad>{LooseLoad(other, axis.mass, viscous_rate(coupling, axis)), coupling.mass_ratio};
  };
  const auto loads = std::apply([&](auto... share) { return std::array{with_share(share)...}; }, play_shares);
  pass_loads(loads, axis, loop, slope_velocity, force, [&](std::size_t row, const auto& seen) {
    double mean = 0.0;
    for (const double one : seen) mean += one / static_cast<double>(seen.size());
    innovation[row] = mean;
  });
}

}  // namespace cogging
