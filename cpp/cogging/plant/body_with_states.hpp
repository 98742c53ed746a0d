#pragma once
// An axis whose friction has a bristle, or whose load is a second mass. Motor force, friction, cogging and all
// other forces act on the motor; the load feels the coupling alone.

#include "cogging/plant/bristle.hpp"
#include "cogging/plant/coupling.hpp"
#include "cogging/plant/integration.hpp"
#include "cogging/plant/sticking.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// Runge-Kutta of fourth order in position, velocity and deflection of the load, in as many substeps as the
/// fastest of its vibrations needs, and more where they would not be accurate; a stiff bristle follows the path of each
/// stage exactly.
///
/// `Axis` gives balance(position, velocity, direction, drive, held, time): all forces but friction, and its level; and
/// accuracy(): what a step errs by.
template <class Axis>
class BodyWithStates {
 public:
  BodyWithStates(const Axis& axis, const Bristle& bristle, const Coupling& coupling)
      : axis_(axis), bristle_(bristle), coupling_(coupling) {}

  void advance(AxisState<double>& state, const Drive<double>& drive, double time, double h, bool sticks) const {
    const int pieces = substeps(h);
    for (int piece = 0; piece < pieces; ++piece) {
      const double from = h * piece / pieces, until = h * (piece + 1) / pieces;
      if (sticks)
        StickSlip(*this, drive, time, from, until).advance(state);
      else
        move(state, drive, time, from, until);
    }
  }

  bool slide(AxisState<double>& state, const Drive<double>& drive, double time, double offset, double length,
             double direction) const {
    return step(state, drive, time, offset, length, Mode::slides, direction);
  }

  bool rest(AxisState<double>& state, const Drive<double>& drive, double time, double offset, double length) const {
    return step(state, drive, time, offset, length, Mode::rests, 0.0);
  }

  double quickest() const { return axis_.accuracy().quickest(); }

  double breakaway(const AxisState<double>& state, const Drive<double>& drive, double time, double offset) const {
    const double coupling = coupling_force(state);
    for (double direction : {-1.0, 1.0}) {
      const auto [push, level] =
          axis_.balance(state.position, 0.0, direction, drive.at(offset) + drive.force, drive.force, time + offset);
      if (!((push + coupling - level * direction) * direction <= 0.0)) return direction;  // nor is NaN a rest
    }
    return 0.0;
  }

 private:
  enum class Mode { moves, slides, rests };  // friction as it is, exact friction in one direction, exact at rest

  using Four = std::array<double, 4>;  // of the stages of a step

  struct Rates {
    double acceleration, relative, level;  // m/s^2, of motor and deflection; V, friction level
  };

  // A sixth of a radian a substep: the vibration then keeps its frequency within 1e-5. That of a bristle, which nothing
  // may damp, within 1e-6.
  int substeps(double h) const {
    double rate = coupling_.exists() ? 6.0 * coupling_.rate() : 0.0;
    if (bristle_.exists()) {
      const double mass = coupling_.motor_mass();
      rate = std::max(rate, 10.0 * std::sqrt(bristle_.stiffness / mass) + 6.0 * bristle_.damping / mass);
    }
    const double needed = std::ceil(rate * h);
    require(needed <= 1e5, "stiffness, frequency", "must need at most 1e5 substeps a step", needed);
    return std::max(1, whole_part(needed));
  }

  void move(AxisState<double>& state, const Drive<double>& drive, double time, double from, double until) const {
    advance_in_pieces(state, time, from, until, until - from, [&](AxisState<double>& at, double offset, double length) {
      return step(at, drive, time, offset, length, Mode::moves, 0.0);
    });
  }

  double coupling_force(const AxisState<double>& state) const {
    return coupling_.exists() ? coupling_.force(state.deflection, state.deflection_rate) : 0.0;
  }

  Rates rates(const AxisState<double>& state, double drive, double held, double time, Mode mode,
              double direction) const {
    const double coupling = coupling_force(state);
    const double load = coupling_.exists() ? -coupling / coupling_.load_mass() : 0.0;
    if (mode == Mode::rests) return {0.0, load, 0.0};
    if (mode == Mode::moves)
      direction =
          bristle_.exists() ? sign(state.velocity) : smooth_sign(state.velocity, axis_.parameters().coulomb_width);
    const auto [push, level] = axis_.balance(state.position, state.velocity, direction, drive, held, time);
    const double friction =
        bristle_.exists() ? bristle_.force(state.bristle, state.velocity, level) : level * direction;
    const double acceleration = (push + coupling - friction) / coupling_.motor_mass();
    return {acceleration, coupling_.exists() ? load - acceleration : 0.0, level};
  }

  struct Slope {
    double velocity, acceleration, deflection_rate, relative, bristle_rate, level;
  };

  // Whether it is accurate.
  bool step(AxisState<double>& state, const Drive<double>& drive, double time, double offset, double h, Mode mode,
            double direction) const {
    const AxisState<double> start = state;
    const auto slope_at = [&](const AxisState<double>& here, double at) {
      const Rates r = rates(here, drive.at(at) + drive.force, drive.force, time + at, mode, direction);
      const double bends =
          bristle_.exists() && r.level > 0.0 ? bristle_.rate(here.bristle, here.velocity, r.level) : 0.0;
      return Slope{here.velocity, r.acceleration, here.deflection_rate, r.relative, bends, r.level};
    };
    const Slope first = slope_at(start, offset);
    const bool by_path = follows_path(start.velocity, first.acceleration, first.level, h);
    const auto bent = [&](AxisState<double> here, double level) {
      here.bristle = bristle_.moved(start.bristle, here.position - start.position, first.level, level);
      return here;
    };
    const auto stage = [&](const AxisState<double>& here, double at) {
      const Slope slope = slope_at(here, at);
      return by_path ? slope_at(bent(here, slope.level), at) : slope;
    };
    const auto moved = [&](const Slope& slope, double length) { return moved_along(start, slope, length); };
    // A law that jumps at the end of the step must not be felt in it: look just before.
    const Stages<Slope> slopes =
        runge_kutta(first, h, offset + 0.5 * h, offset + h * (1.0 - 1e-9), moved, stage, [](const auto&...) {});
    const auto mean = [&](double Slope::* part) { return slopes.sum(part) / 6.0; };
    state = moved({mean(&Slope::velocity), mean(&Slope::acceleration), mean(&Slope::deflection_rate),
                   mean(&Slope::relative), mean(&Slope::bristle_rate), 0.0},
                  h);
    if (by_path) state = bent(state, slopes.fourth.level);
    if (!axis_.accuracy().controls()) return true;
    return (mode == Mode::rests || bends_accurately(start, state, h, slopes.each(&Slope::level), by_path)) &&
           loads_accurately(start, state, h, slopes.each(&Slope::relative)) &&
           (mode == Mode::rests || moves_accurately(start, state, drive, time + offset, offset, h,
                                                    slopes.each(&Slope::acceleration), mode == Mode::slides));
  }

  static AxisState<double> moved_along(AxisState<double> from, const Slope& slope, double length) {
    from.position += length * slope.velocity;
    from.velocity += length * slope.acceleration;
    from.deflection += length * slope.deflection_rate;
    from.deflection_rate += length * slope.relative;
    from.bristle += length * slope.bristle_rate;
    return from;
  }

  bool bends_accurately(const AxisState<double>& start, const AxisState<double>& end, double h, const Four& levels,
                        bool by_path) const {
    if (!bristle_.exists()) return true;
    // A path that turns hides its way there and back.
    if (by_path && (start.velocity * end.velocity < 0.0 || !keeps_level(start, h, levels))) return false;
    return relaxes_accurately(start, end, h, levels[0]);
  }

  bool moves_accurately(const AxisState<double>& start, const AxisState<double>& end, const Drive<double>& drive,
                        double time, double offset, double h, const Four& a, bool one_way) const {
    const StepAccuracy<double>& accuracy = axis_.accuracy();
    const double turned = one_way ? start.velocity : end.velocity;  // friction has one direction, whatever the end
    const double settling = drive.settling(offset) / coupling_.motor_mass();
    if (accuracy.oversteps(h, start.position, end.position, start.velocity, end.velocity)) return false;
    return accuracy.excess(h, a[0], a[1], a[2], a[3], start.velocity, turned, start.speed_max) <= 0.0 &&
           accuracy.excess_of_waves(time, h, start.velocity, end.velocity, drive.at(offset), settling,
                                    start.speed_max) <= 0.0 &&
           (!accuracy.crosses_kink(start.position, end.position, start.velocity, end.velocity) ||
            accuracy.excess_at_kink(h, a[0], a[1], a[2], a[3], start.speed_max) <= 0.0);
  }

  // A bristle that a step bends through more than it can is followed by the path, which is exact at a constant level;
  // one that it bends less is a state like the others.
  bool follows_path(double velocity, double acceleration, double level, double h) const {
    if (!bristle_.exists()) return false;
    return !(bristle_.stiffness * (std::abs(velocity) + h * std::abs(acceleration)) * h < level);
  }

  bool keeps_level(const AxisState<double>& start, double h, const Four& levels) const {
    const auto [least, most] = std::minmax_element(levels.begin(), levels.end());
    const double change = *most - *least;
    return h * change * change / (coupling_.motor_mass() * std::max(*most, 1e-300)) <=
           StepAccuracy<double>::share * std::max(start.speed_max, std::abs(start.velocity));
  }

  // What of the bristle has yet to relax goes with exp(-stiffness path / level): Simpson's error of that, and a margin
  // for errors of one sign.
  bool relaxes_accurately(const AxisState<double>& start, const AxisState<double>& end, double h, double level) const {
    if (!(level > 0.0)) return true;
    const double speed = std::max(std::abs(start.velocity), std::abs(end.velocity));
    const double left = std::abs(bristle_.stiffness * start.bristle - level * sign(start.velocity));
    const double bent = bristle_.stiffness * speed * h / level;
    return left * h / coupling_.motor_mass() * std::min(1.0, bent * bent * bent * bent / 500.0) <=
           StepAccuracy<double>::share * std::max(start.speed_max, std::abs(start.velocity));
  }

  bool loads_accurately(const AxisState<double>& start, const AxisState<double>& end, double h, const Four& a) const {
    if (!coupling_.exists()) return true;
    const StepAccuracy<double>& accuracy = axis_.accuracy();
    const double speed = std::max({start.speed_max, std::abs(start.velocity), std::abs(end.deflection_rate)});
    if (coupling_.piece(start.deflection, start.deflection_rate) ==
        coupling_.piece(end.deflection, end.deflection_rate))
      return accuracy.excess(h, a[0], a[1], a[2], a[3], 0.0, 0.0, speed) <= 0.0;
    return accuracy.excess_at_kink(h, a[0], a[1], a[2], a[3], speed) <= 0.0;
  }

  const Axis& axis_;
  const Bristle& bristle_;
  const Coupling& coupling_;
};

}  // namespace cogging
