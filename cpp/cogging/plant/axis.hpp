#pragma once
// The axis: M x'' = u - B x' - Fc S(x') - F_cogging(x) + effects (Lu et al. 2008, eq. 1, 2, 8 to 10).

#include <algorithm>
#include <array>
#include <limits>
#include <tuple>
#include <type_traits>
#include <vector>

#include "cogging/basis/spline_harmonics.hpp"
#include "cogging/plant/effects/list.hpp"

namespace cogging {

using Range = std::array<double, 2>;

template <class Scalar = double>
struct AxisParameters {
  Scalar mass = 1.0;                                                                                   // V/(m/s^2)
  Scalar viscous = 0.0;                                                                                // V/(m/s)
  Scalar coulomb = 0.0;                                                                                // V
  Scalar coulomb_width = 0.0;                                                                          // m/s
  Range travel = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};  // m

  static constexpr auto fields() {
    using P = AxisParameters;
    return std::tuple{Field<P, Scalar>{"mass", &P::mass, "V/(m/s^2)", "M"},
                      Field<P, Scalar>{"viscous", &P::viscous, "V/(m/s)", "B"},
                      Field<P, Scalar>{"coulomb", &P::coulomb, "V", "Fc (A_f in Lu et al. 2008)"},
                      Field<P, Scalar>{"coulomb_width", &P::coulomb_width, "m/s",
                                       "S(v) = (2/pi) atan(v / coulomb_width); 0 = sgn with sticking"},
                      Field<P, Range>{"travel", &P::travel, "m", "lower and upper end of the motion"}};
  }

  void validate() const {
    require_positive("mass", mass);
    require_not_negative("viscous", viscous);
    require_not_negative("coulomb", coulomb);
    require_not_negative("coulomb_width", coulomb_width);
    if (!(travel[0] < travel[1]))
      refuse("travel", "needs lower end < upper end", "[" + format(travel[0]) + ", " + format(travel[1]) + "]");
  }
};

template <class Scalar>
struct AxisState {
  Scalar position = 0.0;  // m
  Scalar velocity = 0.0;  // m/s
};

/// What drives the axis during one integration step: the amplifier's output as it settles, and a held force.
template <class Scalar>
struct Drive {
  Scalar target = 0.0;     // V, command that acts
  Scalar deviation = 0.0;  // V, amplifier's output less target at the start of the step
  Scalar rate = 0.0;       // 1/s, at which the deviation decays
  Scalar force = 0.0;      // V, disturbance held over the sample
  bool lagging = false;

  Scalar at(const Scalar& offset) const { return lagging ? target + deviation * exp(-rate * offset) : target; }
};

template <class Scalar = double>
class Axis {
 public:
  Axis() = default;

  Axis(const AxisParameters<Scalar>& parameters, CoggingModel<Scalar> cogging,
       const std::vector<Effect<Scalar>>& effects = {})
      : parameters_(parameters),
        cogging_(std::move(cogging)),
        inverse_mass_(Scalar(1.0) / parameters.mass),
        has_friction_(!all(parameters.coulomb == 0.0)) {
    for (const Effect<Scalar>& effect : effects)
      std::visit(
          [&]<class E>(const E&) {
            if constexpr (HasForce<E, Scalar> || HasFrictionLevel<E, Scalar>) laws_.push_back(effect);
            if constexpr (HasFrictionLevel<E, Scalar>) has_friction_ = true;
            if constexpr (HasEvents<E>) events_.push_back(effect);
          },
          effect);
  }

  const AxisParameters<Scalar>& parameters() const { return parameters_; }
  const CoggingModel<Scalar>& cogging() const { return cogging_; }

  /// The next time after `time` at which a force law jumps; infinite if there is none.
  double next_event(double time) const {
    double next = std::numeric_limits<double>::infinity();
    for (const Effect<Scalar>& effect : events_)
      std::visit(
          [&]<class E>(const E& law) {
            if constexpr (HasEvents<E>) next = std::min(next, law.next_event(time));
          },
          effect);
    return next;
  }

  /// Force balance over mass, m/s^2, with the smooth sign S(v).
  Scalar acceleration(const Scalar& position, const Scalar& velocity, const Scalar& drive, double time) const {
    // Cogging first: in a Runge-Kutta step the position is known before the velocity.
    const Scalar cogging = cogging_.force(position);
    const Scalar direction = smooth_sign(velocity, parameters_.coulomb_width);
    const auto [force, friction_level] = forces(cogging, position, velocity, direction, time);
    return (drive + force - friction_level * direction) * inverse_mass_;
  }

  /// One step of length h from `time` with the drive held: classical Runge-Kutta of fourth order. With
  /// coulomb_width = 0 the step is cut where the axis stops or breaks away, so that it sticks and slips
  /// exactly.
  void advance(AxisState<Scalar>& state, const Drive<Scalar>& drive, double time, double h) const {
    if constexpr (std::is_same_v<Scalar, double>) {
      if (parameters_.coulomb_width == 0.0 && has_friction_) {
        advance_sticking(state, drive, time, h);
        return;
      }
    }
    runge_kutta(state, drive, time, 0.0, h, [this](const Scalar& x, const Scalar& v, const Scalar& u, double t) {
      return acceleration(x, v, u, t);
    });
  }

 private:
  struct Forces {
    Scalar without_friction, friction_level;  // V
  };

  Forces forces(const Scalar& cogging, const Scalar& position, const Scalar& velocity, const Scalar& direction,
                double time) const {
    const Forces sum{-parameters_.viscous * velocity - cogging, parameters_.coulomb};
    return laws_.empty() ? sum : add_laws(sum, position, velocity, direction, time);
  }

  // Out of line and by value: where there are no laws, position and velocity then stay apart in registers.
  COGGING_NOINLINE Forces add_laws(Forces sum, Scalar position, Scalar velocity, Scalar direction, double time) const {
    const Motion<Scalar> motion{position, velocity, direction, time};
    for (const Effect<Scalar>& effect : laws_)
      std::visit(
          [&]<class E>(const E& law) {
            if constexpr (HasForce<E, Scalar>) sum.without_friction += law.force(motion);
            if constexpr (HasFrictionLevel<E, Scalar>) sum.friction_level += law.friction_level(motion);
          },
          effect);
    sum.friction_level = select(sum.friction_level < 0.0, Scalar(0.0), sum.friction_level);  // friction never pushes
    return sum;
  }

  // f(position, velocity, command, time). The new position is stored before a4 is begun, so that the next
  // reading need not wait for it.
  template <class Acceleration>
  void runge_kutta(AxisState<Scalar>& state, const Drive<Scalar>& drive, double time, double offset, double h,
                   const Acceleration& f) const {
    const double half = 0.5 * h, sixth = h / 6.0;
    const Scalar u_start = drive.at(offset) + drive.force;
    const Scalar u_middle = drive.lagging ? drive.at(offset + half) + drive.force : u_start;
    const Scalar u_end = drive.lagging ? drive.at(offset + h) + drive.force : u_start;
    const Scalar x = state.position, v1 = state.velocity;
    const Scalar a1 = f(x, v1, u_start, time);
    const Scalar v2 = v1 + half * a1;
    const Scalar a2 = f(x + half * v1, v2, u_middle, time + half);
    const Scalar v3 = v1 + half * a2;
    const Scalar a3 = f(x + half * v2, v3, u_middle, time + half);
    const Scalar v4 = v1 + h * a3;
    state.position = x + sixth * (v1 + 2.0 * (v2 + v3) + v4);
    // A law that jumps at the end of the step must not be felt in it: look just before.
    const Scalar a4 = f(x + h * v3, v4, u_end, events_.empty() ? time + h : time + h * (1.0 - 1e-9));
    state.velocity = v1 + sixth * (a1 + 2.0 * (a2 + a3) + a4);
  }

  // Force balance of an axis that slides in `direction`.
  double sliding(double position, double velocity, double u, double time, double direction) const {
    const auto [force, friction_level] = forces(cogging_.force(position), position, velocity, direction, time);
    return (u + force - friction_level * direction) * inverse_mass_;
  }

  // -1 or +1: the direction in which an axis at rest breaks away; 0: it sticks.
  double breakaway(double position, double u, double time) const {
    for (double direction : {-1.0, 1.0})
      if (sliding(position, 0.0, u, time, direction) * direction > 0.0) return direction;
    return 0.0;
  }

  // Exact Coulomb friction. The step is a sequence of pieces, in each of which the axis either slides one way
  // or rests; each ends where the velocity comes to zero or where the force on the resting axis reaches its
  // level.
  void advance_sticking(AxisState<double>& state, const Drive<double>& drive, double time, double h) const {
    constexpr int pieces_max = 64;
    double done = 0.0;
    for (int piece = 0; piece < pieces_max && done < h; ++piece) {
      const double left = h - done;
      const auto force_at = [&](double offset) { return drive.at(offset) + drive.force; };
      double direction = sign(state.velocity);
      if (direction == 0.0) {
        direction = breakaway(state.position, force_at(done), time + done);
        if (direction == 0.0) {
          const auto rests_until = [&](double offset) {
            return breakaway(state.position, force_at(offset), time + offset) == 0.0;
          };
          // Look at quarters of what is left: a force that comes and goes within the step must not be missed.
          for (int quarter = 1; quarter <= 4 && direction == 0.0; ++quarter) {
            const double until = quarter == 4 ? h : done + 0.25 * quarter * left;
            if (!rests_until(until)) {
              done = bisect(done, until, rests_until);
              direction = 2.0;  // found: the next piece starts there
            }
          }
          if (direction == 0.0) return;
          continue;
        }
      }
      const auto slide = [&](double length) {
        AxisState<double> end = state;
        runge_kutta(end, drive, time + done, done, length,
                    [&](double x, double v, double u, double t) { return sliding(x, v, u, t, direction); });
        return end;
      };
      const AxisState<double> end = slide(left);
      if (end.velocity * direction >= 0.0) {
        state = end;
        return;
      }
      const double length = bisect(0.0, left, [&](double l) { return slide(l).velocity * direction >= 0.0; });
      state = {slide(length).position, 0.0};
      done += std::max(length, 1e-12 * h);
    }
    if (done < h) state.velocity = 0.0;  // endless reversals within one step: the axis is at rest
  }

  // The point between a and b up to which `holds`, to the last bit that a time can show.
  template <class Predicate>
  static double bisect(double a, double b, const Predicate& holds) {
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (a + b);
      if (middle <= a || middle >= b) break;
      (holds(middle) ? a : b) = middle;
    }
    return b;
  }

  AxisParameters<Scalar> parameters_;
  CoggingModel<Scalar> cogging_;
  Scalar inverse_mass_ = 1.0;
  bool has_friction_ = false;
  std::vector<Effect<Scalar>> laws_, events_;
};

}  // namespace cogging
