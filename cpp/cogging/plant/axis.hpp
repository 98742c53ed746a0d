#pragma once
// The axis: M x'' = u - B x' - Fc S(x') - F_cogging(x) + effects (Lu et al. 2008, eq. 1, 2, 8 to 10).

#include "cogging/basis/spline_harmonics.hpp"
#include "cogging/plant/body_with_states.hpp"
#include "cogging/plant/effects/list.hpp"
#include "cogging/plant/integration.hpp"
#include "cogging/plant/state.hpp"
#include "cogging/plant/step_control.hpp"
#include "cogging/plant/sticking.hpp"

namespace cogging {

template <class Scalar = double>
struct AxisParameters {
  Scalar mass = 1.0;                     // V/(m/s^2)
  Scalar viscous = 0.0;                  // V/(m/s)
  Scalar coulomb = 0.0;                  // V
  Scalar coulomb_width = 0.0;            // m/s
  Range travel = {-infinity, infinity};  // m

  static constexpr auto fields() {
    using P = AxisParameters;
    return std::tuple{Field{"mass", &P::mass, "V/(m/s^2)", "M", Rule::positive},
                      Field{"viscous", &P::viscous, "V/(m/s)", "B", Rule::not_negative},
                      Field{"coulomb", &P::coulomb, "V", "Fc (A_f in Lu et al. 2008)", Rule::not_negative},
                      Field{"coulomb_width", &P::coulomb_width, "m/s",
                            "S(v) = (2/pi) atan(v / coulomb_width); 0 = sgn with sticking", Rule::not_negative},
                      Field{"travel", &P::travel, "m", "lower and upper end of the motion", Rule::any}};
  }

  void validate() const { require_travel(travel); }
};

/// What the effects of a plant may ask of it.
template <class Scalar>
PlantContext context_of(const AxisParameters<Scalar>& axis, const CoggingModel<Scalar>& cogging) {
  return {axis.travel, !cogging.basis().empty(), cogging.basis().spline()};
}

template <class Scalar = double>
class Axis {
 public:
  Axis() = default;

  /// Raises std::invalid_argument for a parameter that breaks its rule, for effects that lack what they need of the
  /// plant or that exclude each other.
  Axis(const AxisParameters<Scalar>& parameters, CoggingModel<Scalar> cogging,
       const std::vector<Effect<Scalar>>& effects = {});

  const AxisParameters<Scalar>& parameters() const { return parameters_; }

  /// Whether a force law jumps at times.
  bool has_events() const { return !events_.empty(); }

  /// The next time after `time` at which a force law jumps; infinite if there is none.
  double next_event(double time) const {
    double next = infinity;
    for_each_law(events_, [&](const HasEvents auto& law) { next = std::min(next, law.next_event(time)); });
    return next;
  }

  struct Balance {
    Scalar push, friction_level;  // V
  };

  /// All forces but friction, V, and its level, V. `drive` is what the amplifier puts out plus `held`, a force that
  /// no force constant multiplies; `direction` is that of Motion.
  Balance balance(const Scalar& position, const Scalar& velocity, const Scalar& direction, const Scalar& drive,
                  const Scalar& held, double time) const {
    return balance(cogging_.force(position), position, velocity, direction, drive, held, time);
  }

  /// Force balance over mass, m/s^2, with the smooth sign S(v); motor and load as one.
  Scalar acceleration(const Scalar& position, const Scalar& velocity, const Scalar& drive, double time,
                      const Scalar& held = 0.0) const {
    return sliding(cogging_.force(position), position, velocity, direction_of_(velocity), drive, held, time);
  }

  /// What the effects add to the gain 1 of the command.
  Scalar command_gain(const Scalar& position, double time) const {
    Scalar gain = 0.0;
    for_each_law(gains_, [&](const HasCommandGain<Scalar> auto& law) { gain += law.command_gain(position, time); });
    return gain;
  }

  /// Moves the state on by h from `time` with the drive held: one classical Runge-Kutta step of fourth order where
  /// that is accurate (StepAccuracy), else as many as it takes. With coulomb_width = 0 the step is cut where the
  /// axis stops or breaks away, so that it sticks and slips exactly.
  COGGING_INLINE void advance(AxisState<double>& state, const Drive<double>& drive, double time, double h) const
    requires std::same_as<Scalar, double>
  {
    if (has_states_ || sticks_) {
      advance_other(state, drive, time, h);
    } else {
      const double position = state.position, velocity = state.velocity;
      if (!(move(state, drive, time, 0.0, h) <= 0.0)) [[unlikely]] {
        state.position = position, state.velocity = velocity;
        advance_in_parts(state, drive, time, h);
      }
    }
    state.speed_max = larger(state.speed_max, abs(state.velocity));
  }

  /// One step of the integrator where nothing sticks or has a state; by how much it errs more than it may, m/s: at most
  /// 0 where `advance` would do the same.
  Scalar try_step(AxisState<Scalar>& state, const Drive<Scalar>& drive, double time, double h) const {
    return move(state, drive, time, 0.0, h);
  }

  /// Takes steps as they are given, whatever they err by.
  void leave_steps() { accuracy_.leave_steps(); }

  /// Steps will be at most so long, s: what such a step errs by at most is found once.
  void expect_steps(double longest) { accuracy_.expect_steps(longest); }

  /// What a step of a body on this axis errs by.
  const StepAccuracy<Scalar>& accuracy() const { return accuracy_; }

 private:
  /// How fast the laws vary, by which the steps are chosen.
  void learn_variation(const std::vector<Effect<Scalar>>& bound, bool effects_rub) {
    for_each_law(bound, [&](const HasKinks auto& law) { accuracy_.add_kinks(law.kinks(), {}); });
    for_each_law(bound, [&](const HasVelocityKinks auto& law) { accuracy_.add_kinks({}, law.velocity_kinks()); });
    for_each_law(bound,
                 [&](const HasVariation auto& law) { accuracy_.add(law.variation(), smallest(parameters_.mass)); });
    if (has_friction_ && !sticks_)  // a bristle has a kink where it turns
      accuracy_.add_turning(bristle_.exists() ? Scalar(0.0) : smooth_width(effects_rub));
    accuracy_.add_kinks(cogging_.kinks(), {});
    for (const auto& [amplitude, wavenumber] : cogging_.waves())
      accuracy_.add({.force = amplitude, .wavenumber = wavenumber}, smallest(parameters_.mass));
  }

  friend class StickSlip<Axis>;

  // Where the cogging force is known already.
  COGGING_INLINE Balance balance(const Scalar& cogging, const Scalar& position, const Scalar& velocity,
                                 const Scalar& direction, const Scalar& drive, const Scalar& held, double time) const {
    const Scalar force = -parameters_.viscous * velocity - cogging;
    if (is_bare_) return {drive + force, parameters_.coulomb};
    return balance_of_laws(force, position, velocity, direction, drive, held, time);
  }

  // Acceleration of an axis that slides in `direction`.
  COGGING_INLINE Scalar sliding(const Scalar& cogging, const Scalar& position, const Scalar& velocity,
                                const Scalar& direction, const Scalar& drive, const Scalar& held, double time) const {
    const auto [push, friction_level] = balance(cogging, position, velocity, direction, drive, held, time);
    return (push - friction_level * direction) * inverse_mass_;
  }

  // Out of line and by value: where there are no laws, position and velocity then stay apart in registers.
  COGGING_NOINLINE Balance balance_of_laws(Scalar force, Scalar position, Scalar velocity, Scalar direction,
                                           Scalar drive, Scalar held, double time) const {
    const Motion<Scalar> motion{position, velocity, direction, time};
    Scalar friction_level = parameters_.coulomb;
    for_each_law(laws_, [&]<HasMotionLaw<Scalar> E>(const E& law) {  // in one pass: two take a tenth longer
      if constexpr (HasForce<E, Scalar>) force += law.force(motion);
      if constexpr (HasFrictionLevel<E, Scalar>) friction_level += law.friction_level(motion);
    });
    friction_level = select(friction_level < 0.0, Scalar(0.0), friction_level);  // friction never pushes
    // The force constant's effects multiply what the amplifier puts out.
    const Scalar amplified = gains_.empty() ? drive : drive + command_gain(position, time) * (drive - held);
    return {amplified + force, friction_level};
  }

  template <class State>
  void add_state(std::string_view name, State& state, const State& added, bool already) {
    require(!already, name, "may not join another of its kind (backlash, flexible_mode; presliding_friction), count",
            2);
    require(std::is_same_v<Scalar, double>, name, "runs on single machines alone, lanes", 2);
    state = added;
  }

  // The coulomb_width, m/s, of each lane with friction, which must be smooth in all of them; infinite without friction.
  Scalar smooth_width(bool effects_rub) const {
    Scalar widths = parameters_.coulomb_width;
    for (std::size_t i = 0; i < lanes_of<Scalar>; ++i)
      if (!effects_rub && lane(parameters_.coulomb, i) == 0.0)
        set_lane(widths, i, infinity);
      else
        require(lane(widths, i) > 0.0, "coulomb_width",
                "must be above 0 in every lane with friction: what sticks runs on single machines alone",
                lane(widths, i));
    return widths;
  }

  COGGING_NOINLINE void advance_other(AxisState<double>& state, const Drive<double>& drive, double time, double h) const
    requires std::same_as<Scalar, double>;

  // Where one step errs more than it may.
  COGGING_NOINLINE void advance_in_parts(AxisState<double>& state, const Drive<double>& drive, double time,
                                         double h) const
    requires std::same_as<Scalar, double>
  {
    advance_in_pieces(state, time, 0.0, h, 0.5 * h, [&](AxisState<double>& at, double offset, double length) {
      return move(at, drive, time, offset, length) <= 0.0;
    });
  }

  // One step with the smooth sign; by how much it errs more than it may. Out of line: what it calls is put into it.
  COGGING_NOINLINE Scalar move(AxisState<Scalar>& state, const Drive<Scalar>& drive, double time, double offset,
                               double h) const;

  // One step of an axis that slides in direction_at(velocity), at first in `direction`; by how much it errs more than
  // it may.
  template <class DirectionAt>
  COGGING_INLINE Scalar step(AxisState<Scalar>& state, const Drive<Scalar>& drive, double time, double offset, double h,
                             const Scalar& direction, const DirectionAt& direction_at) const {
    struct Slope {
      Scalar velocity, acceleration;
    };
    struct Point {
      Scalar cogging, position, velocity;
    };
    struct Input {
      Scalar command;
      double time;
    };
    const double half = 0.5 * h, sixth = h / 6.0, start = time + offset;
    const Scalar u_start = drive.at(offset) + drive.force;
    const Scalar u_middle = drive.lagging ? drive.at(offset + half) + drive.force : u_start;
    const Scalar u_end = drive.lagging ? drive.at(offset + h) + drive.force : u_start;
    const Scalar x = state.position, v1 = state.velocity;
    const SplineHarmonics::Wave<Scalar> wave = cogging_.basis().wave_at(x);
    // A law that jumps at the end of the step must not be felt in it: look just before.
    const double just_before = events_.empty() ? start + h : start + h * (1.0 - 1e-9);
    const auto [k1, k2, k3, k4] = runge_kutta(
        Slope{v1, sliding(cogging_.force(wave), x, v1, direction, u_start, drive.force, start)}, h,
        Input{u_middle, start + half}, Input{u_end, just_before},
        [&](const Slope& slope, double length) COGGING_INLINE_LAMBDA {
          const Scalar position = x + length * slope.velocity, velocity = v1 + length * slope.acceleration;
          return Point{cogging_.force(cogging_.basis().wave_at(position, wave)), position, velocity};
        },
        [&](const Point& at, const Input& input) COGGING_INLINE_LAMBDA {
          return Slope{at.velocity, sliding(at.cogging, at.position, at.velocity, direction_at(at.velocity),
                                            input.command, drive.force, input.time)};
        },
        [&](const Slope& first, const Slope& second, const Slope& third, const Point& last) COGGING_INLINE_LAMBDA {
          // Stored now, so that the next reading need not wait for the last slope.
          state.position = x + sixth * (first.velocity + 2.0 * (second.velocity + third.velocity) + last.velocity);
        });
    const Scalar a1 = k1.acceleration, a2 = k2.acceleration, a3 = k3.acceleration, a4 = k4.acceleration;
    state.velocity = v1 + sixth * (a1 + 2.0 * (a2 + a3) + a4);
    if (!drive.lagging && accuracy_.is_easy(h, a1, a2, a3, v1, state.velocity)) return -1.0;
    Scalar excess = accuracy_.excess(h, a1, a2, a3, a4, v1, state.velocity, state.speed_max);
    if (accuracy_.has_kinks()) excess = larger(excess, excess_at_kinks(x, v1, state, h, a1, a2, a3, a4));
    if (!accuracy_.varies() && !(drive.lagging && accuracy_.controls())) return excess;
    return larger(excess, accuracy_.excess_of_waves(start, h, v1, state.velocity, u_start - drive.force,
                                                    drive.settling(offset) * inverse_mass_, state.speed_max));
  }

  COGGING_NOINLINE Scalar excess_at_kinks(const Scalar& x1, const Scalar& v1, const AxisState<Scalar>& end, double h,
                                          const Scalar& a1, const Scalar& a2, const Scalar& a3,
                                          const Scalar& a4) const {
    Scalar excess = accuracy_.excess_at_kink(h, a1, a2, a3, a4, larger(end.speed_max, abs(end.velocity)));
    for (std::size_t i = 0; i < lanes_of<Scalar>; ++i)
      if (accuracy_.oversteps(h, lane(x1, i), lane(end.position, i), lane(v1, i), lane(end.velocity, i)))
        set_lane(excess, i, 1.0);
      else if (!accuracy_.crosses_kink(lane(x1, i), lane(end.position, i), lane(v1, i), lane(end.velocity, i)))
        set_lane(excess, i, -1.0);
    return excess;
  }

  // What advance_sticking asks of a body.
  bool slide(AxisState<double>& state, const Drive<double>& drive, double time, double offset, double length,
             double direction) const {
    return step(state, drive, time, offset, length, direction, [&](double) { return direction; }) <= 0.0;
  }

  bool rest(AxisState<double>&, const Drive<double>&, double, double, double) const { return true; }

  double quickest() const { return accuracy_.quickest(); }

  double breakaway(const AxisState<double>& state, const Drive<double>& drive, double time, double offset) const {
    const double u = drive.at(offset) + drive.force, cogging = cogging_.force(state.position);
    for (double direction : {-1.0, 1.0})
      if (const double a = sliding(cogging, state.position, 0.0, direction, u, drive.force, time + offset);
          !(a * direction <= 0.0))
        return direction;  // a force that is no number is no rest either
    return 0.0;
  }

  AxisParameters<Scalar> parameters_;
  CoggingModel<Scalar> cogging_;
  Scalar inverse_mass_ = 1.0;
  SmoothSign<Scalar> direction_of_;
  bool has_friction_ = false, sticks_ = false, has_states_ = false;
  bool is_bare_ = true;                                // no effect acts on it
  std::vector<Effect<Scalar>> laws_, gains_, events_;  // by what they answer to
  StepAccuracy<Scalar> accuracy_;
  Bristle bristle_;
  Coupling coupling_;
};

// These stand outside of the class, so that files which find them compiled (instantiated.hpp) need not compile them.

template <class Scalar>
Axis<Scalar>::Axis(const AxisParameters<Scalar>& parameters, CoggingModel<Scalar> cogging,
                   const std::vector<Effect<Scalar>>& effects)
    : parameters_(validated(parameters)),
      cogging_(std::move(cogging)),
      inverse_mass_(Scalar(1.0) / parameters.mass),
      direction_of_(parameters.coulomb_width),
      has_friction_(!all(parameters.coulomb == 0.0)) {
  const std::vector<Effect<Scalar>> bound = bind_effects(effects, context_of(parameters_, cogging_));
  for_each_law(bound, [&](const HasMotionLaw<Scalar> auto& law) {
    if (uses(law, Hook::force) || uses(law, Hook::friction_level)) laws_.push_back(law);
  });
  bool effects_rub = false;
  for_each_law(bound, [&](const HasFrictionLevel<Scalar> auto& law) {
    effects_rub = effects_rub || uses(law, Hook::friction_level);
  });
  has_friction_ = has_friction_ || effects_rub;
  for_each_law(bound, [&](const HasCommandGain<Scalar> auto& law) {
    if (uses(law, Hook::command_gain)) gains_.push_back(law);
  });
  is_bare_ = laws_.empty() && gains_.empty();
  for_each_law(bound, [&](const HasEvents auto& law) { events_.push_back(law); });
  for_each_law(bound, [&](const HasBristle auto& law) {
    if (law.bristle().exists()) add_state(law.name, bristle_, law.bristle(), bristle_.exists());
  });
  CouplingParameters coupling;
  for_each_law(bound, [&](const HasCoupling auto& law) {
    if (!law.coupling().rigid()) add_state(law.name, coupling, law.coupling(), !coupling.rigid());
  });
  if constexpr (std::is_same_v<Scalar, double>) {
    coupling_ = Coupling(coupling, parameters_.mass);
    sticks_ = parameters_.coulomb_width == 0.0 && has_friction_ && !bristle_.exists();
  }
  has_states_ = bristle_.exists() || coupling_.exists();
  learn_variation(bound, effects_rub);
}

template <class Scalar>
void Axis<Scalar>::advance_other(AxisState<double>& state, const Drive<double>& drive, double time, double h) const
  requires std::same_as<Scalar, double>
{
  if (has_states_)
    BodyWithStates(*this, bristle_, coupling_).advance(state, drive, time, h, sticks_);
  else
    StickSlip(*this, drive, time, 0.0, h).advance(state);
}

template <class Scalar>
Scalar Axis<Scalar>::move(AxisState<Scalar>& state, const Drive<Scalar>& drive, double time, double offset,
                          double h) const {
  const auto known = direction_of_.known(state.velocity);
  return step(state, drive, time, offset, h, known.sign,
              [&](const Scalar& velocity) COGGING_INLINE_LAMBDA { return direction_of_(velocity, known); });
}

}  // namespace cogging
