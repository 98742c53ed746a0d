#pragma once
// Observer-based cancellation of cogging: positions only, any spatial periods (Malaize and Levine 2009, eq. 1 to 8).

#include <array>
#include <numbers>

#include "cogging/control/controller.hpp"
#include "cogging/control/sample_guard.hpp"
#include "cogging/delay_line.hpp"
#include "cogging/parameters.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// Forces are accelerations in the paper; `mass` carries them over to the command unit.
template <class Scalar = double>
struct ObserverBasedParameters {
  static constexpr std::string_view description =
      "Periods and gains of an ObserverBased (Malaize and Levine 2009, eq. 2, 6, 8).";

  double sample_rate = 10000.0;                                     // Hz
  std::vector<double> periods = {0.024};                            // m
  std::vector<double> observer_gain = {300.0, 3e4, 1e6, 0.0, 0.0};  // 1/s, 1/s^2, 1/s^3, ...
  std::vector<double> observer_gain_slope{};                        // per m/s
  double position_gain = 14400.0;                                   // 1/s^2
  double velocity_gain = 239.0;                                     // 1/s
  double mass = 1.0;                                                // V/(m/s^2)
  double viscous = 0.0;                                             // 1/s
  double velocity_min = 0.0;                                        // m/s
  double delay = 0.0;                                               // s
  std::string rotation = "reference";
  double command_limit = 0.0;  // V

  static constexpr int periods_max = 16;
  static constexpr int delay_max = 64;  // samples

  static constexpr auto fields() {
    using P = ObserverBasedParameters;
    return std::tuple{
        Field{"sample_rate", &P::sample_rate, "Hz", "samples a second", Rule::positive},
        Field{"periods", &P::periods, "m", "spatial periods P_n that are cancelled (eq. 2)", Rule::period},
        Field{"observer_gain", &P::observer_gain, "",
              "K (eq. 6): of x (1/s), nu (1/s^2), lambda_0 and each period's sine and cosine (1/s^3)"},
        Field{"observer_gain_slope", &P::observer_gain_slope, "",
              "K grows by |nu*| (m/s) times this; empty = constant"},
        Field{"position_gain", &P::position_gain, "1/s^2", "L_x = omega^2 (section IV.C)", Rule::positive},
        Field{"velocity_gain", &P::velocity_gain, "1/s", "L_nu = 2 xi omega - mu"},
        Field{"mass", &P::mass, "V/(m/s^2)", "by which accelerations become commands", Rule::positive},
        Field{"viscous", &P::viscous, "1/s", "mu (eq. 1)", Rule::not_negative},
        Field{"velocity_min", &P::velocity_min, "m/s", "below this |nu*| the harmonics are frozen", Rule::not_negative},
        Field{"delay", &P::delay, "s", "from reading to acting command; feedforward looks ahead by it", Rule::any},
        Field{"rotation", &P::rotation, "",
              "harmonics turn with the \"reference\" (the paper) or the \"measured\" position"},
        Field{"command_limit", &P::command_limit, "V", "largest command; 0 = none", Rule::not_negative}};
  }

  void validate() const {
    require(!periods.empty() && periods.size() <= periods_max, "periods", "must list 1 to 16", periods.size());
    const std::size_t size = 3 + 2 * periods.size();
    const std::string of_size = "hold 3 + 2 periods = " + format(size) + " values";
    require(observer_gain.size() == size, "observer_gain", "must " + of_size, observer_gain.size());
    require(observer_gain_slope.empty() || observer_gain_slope.size() == size, "observer_gain_slope",
            "must be empty or " + of_size, observer_gain_slope.size());
    require(delay >= 0.0 && delay * sample_rate < delay_max - 2, "delay", "must be 0 to 61 samples", delay);
    if (rotation != "reference" && rotation != "measured")
      refuse("rotation", "must be \"reference\" or \"measured\"", rotation);
  }
};

/// Extended observer (6) and law (8): u = mass (-L_x (y - x*) - L_nu (nu_hat - nu*) - C_N zeta_hat + a* + mu nu*).
///
/// Between samples zeta turns exactly, by 2 pi dx* / P_n, and (x, nu) follow by Taylor's formula to third order with
/// the command that acted; at the sample Ts K (y - x_hat) corrects them. K is that of nu* > 0: for nu* < 0 the signs of
/// the cosines' gains turn, since (3) does. Below velocity_min the harmonics are frozen, because zeta is not observable
/// at rest. Feedforward and zeta are looked up `delay` ahead; the feedback cannot be.
///
/// lambda_0 holds the dry friction, which turns with the motion and is gone at rest. Of its reset the paper only says
/// that it needs care (section III.A). Here each direction keeps the last estimate at the steadiest motion of its last
/// stroke: where |a*| was least, to 1 % of the largest, above velocity_min if the stroke has come so far. lambda_0
/// begins with it wherever a motion in that direction begins. Where a rest begins (|nu*| up to a thousandth of
/// velocity_min) it is set to the mean of both, from which a friction that is odd in the velocity falls out. As long as
/// one direction is unknown it is taken as the other's opposite. What is learned at rest ends with it.
///
/// In a sample that is refused (see SampleGuard) the estimates stay, while the commands that acted are still kept. The
/// next prediction is one step over all samples that have passed; behind more than 16 missed ones x_hat and nu_hat
/// start anew from the readings at both ends, and the forces, turned by the way that was made, stay.
template <class Scalar = double>
class ObserverBased : public GuardedController<ObserverBasedParameters<Scalar>, Scalar> {
  using Base = GuardedController<ObserverBasedParameters<Scalar>, Scalar>;
  using Base::guard_, Base::parameters_;

 public:
  using typename Base::Parameters;
  static constexpr std::string_view name = "observer_based";
  static constexpr std::string_view description = R"(Observer-based cancellation (Malaize and Levine 2009).

Extended observer (6) of position, velocity, lambda_0 and each spatial period, and law (8); K from gains.design_observer.
Positions only. Estimates: x_hat, nu_hat, lambda_0, then sine and cosine of each period. Behind more than 16 samples that
were refused x_hat and nu_hat start anew from the readings at both ends.

lambda_0 holds the dry friction. Of its reset the paper only says that it needs care; here it begins each motion with
the last estimate of that direction in steady motion (of the other, turned, where that is the first), and each rest with
the mean of both, which is without friction. What is learned at rest ends with it.)";
  static constexpr int states_max = 3 + 2 * Parameters::periods_max;

  explicit ObserverBased(const Parameters& parameters = {})
      : Base(parameters),
        count_(static_cast<int>(parameters.periods.size())),
        sample_time_(1.0 / parameters.sample_rate),
        measured_rotation_(parameters.rotation == "measured") {
    const double samples = parameters.delay * parameters.sample_rate;
    whole_ = whole_part<std::size_t>(samples + 1e-9);
    fraction_ = std::max(0.0, samples - static_cast<double>(whole_));
    for (int n = 0; n < count_; ++n) wavenumber_[n] = 2.0 * std::numbers::pi / parameters.periods[n];
    state_.fill(Scalar(0.0));
    acted_ = DelayLine<Scalar>(whole_ + 1 + SampleGuard<Scalar>::gap_max);
    kept_.fill(Scalar(0.0));
    known_.fill(Scalar(0.0));
  }

  /// How far ahead (s) the second reference of `command` is: the delay, and half of the sample for which it is held.
  double preview() const { return parameters_.delay + 0.5 * sample_time_; }
  /// x_hat, nu_hat, lambda_0, then sine and cosine of each period: m, m/s, m/s^2.
  std::span<const Scalar> estimates() const { return {state_.data(), static_cast<std::size_t>(3 + 2 * count_)}; }

  /// What changes while it runs (see Pid::state).
  auto state() noexcept {
    return std::tie(guard_, state_, acted_, kept_, known_, direction_, motion_, fast_, hardest_, steadiest_,
                    reference_previous_, reading_previous_);
  }

  Scalar command(const ReferencePoint& reference, const ReferencePoint& ahead, Scalar reading) noexcept {
    return guard_.command(guard_.usable(reference) && guard_.usable(ahead), reading,
                          [&](const auto& sample, const Scalar& y) { return law(sample, reference, ahead, y); });
  }

  void update(Scalar applied) noexcept { acted_.push(guard_.acted(applied) / parameters_.mass); }

 private:
  template <class Sample>
  COGGING_INLINE Scalar law(const Sample& sample, const ReferencePoint& reference, const ReferencePoint& ahead,
                            const Scalar& reading) noexcept {
    const Parameters& q = parameters_;
    predict(sample, reference, reading);
    sample.start(state_[0], reading);
    sample.start(state_[1], sample.per_sample(reading - reading_previous_) * q.sample_rate);
    sample.begin(state_[1], Scalar(reference.velocity));
    sample.set(reference_previous_, Scalar(reference.position));
    sample.set(reading_previous_, reading);
    turn_direction(sample, reference.velocity);
    correct(sample, reading - state_[0], reference.velocity);
    keep(sample, reference);

    Scalar cogging = state_[2];
    for (int n = 0; n < count_; ++n) {
      Scalar s, c;
      sin_cos(Scalar(wavenumber_[n] * (ahead.position - reference.position)), s, c);
      cogging += c * state_[3 + 2 * n] + s * state_[4 + 2 * n];
    }
    return q.mass *
           (-q.position_gain * (reading - reference.position) - q.velocity_gain * (state_[1] - reference.velocity) -
            cogging + ahead.acceleration + q.viscous * ahead.velocity);
  }

  // From the last sample to this one. What acted is the command of `delay` before: a mean over the two that share it.
  template <class Sample>
  COGGING_INLINE void predict(const Sample& sample, const ReferencePoint& reference, const Scalar& reading) noexcept {
    const auto t = sample_time_ * sample.steps;
    const double mu = parameters_.viscous;
    Scalar sum = (1.0 - fraction_) * acted_.at(whole_) + fraction_ * acted_.at(whole_ + 1);
    for (int i = 1; i <= sample.bridged; ++i)
      sample.bridge(i, sum, sum + (1.0 - fraction_) * acted_.at(whole_ + i) + fraction_ * acted_.at(whole_ + 1 + i));
    const Scalar acted = sample.mean(sum);
    const Scalar moved =
        measured_rotation_ ? reading - reading_previous_ : Scalar(reference.position - reference_previous_);
    const Scalar speed = moved / t;
    Scalar force = state_[2], force_rate = 0.0, force_curve = 0.0;  // C_N zeta and its derivatives along the motion
    for (int n = 0; n < count_; ++n) {
      const double w = wavenumber_[n];
      const Scalar sine = state_[3 + 2 * n], cosine = state_[4 + 2 * n];
      force += sine;
      force_rate += speed * w * cosine;
      force_curve -= speed * speed * w * w * sine;
      Scalar s, c;
      sin_cos(moved * w, s, c);
      sample.set(state_[3 + 2 * n], c * sine + s * cosine);
      sample.set(state_[4 + 2 * n], c * cosine - s * sine);
    }
    const Scalar a = acted + force - mu * state_[1], jerk = force_rate - mu * a, snap = force_curve - mu * jerk;
    sample.set(state_[0], state_[0] + t * (state_[1] + t * (0.5 * a + t / 6.0 * jerk)));
    sample.set(state_[1], state_[1] + t * (a + t * (0.5 * jerk + t / 6.0 * snap)));
  }

  bool rests(double velocity) const { return std::abs(velocity) <= 1e-3 * parameters_.velocity_min; }

  // lambda_0 as it was last in a direction; as long as that is unknown dry friction turns its sign.
  COGGING_INLINE Scalar last_of(int direction) const {
    return select(known_[direction] > 0.0, kept_[direction], -kept_[1 - direction]);
  }

  template <class Sample>
  COGGING_INLINE void turn_direction(const Sample& sample, double velocity) noexcept {
    const bool at_rest = rests(velocity);
    const int to = velocity > 0.0 ? 1 : 0;
    const double motion = at_rest ? 0.0 : 2.0 * to - 1.0;
    if (all(motion_ == motion)) return;
    const Scalar last = at_rest ? 0.5 * (last_of(0) + last_of(1)) : last_of(to);
    const Scalar stays = select(motion_ == motion, Scalar(1.0), Scalar(0.0));
    const auto begins = (1.0 - stays) * (known_[0] + known_[1]) > 0.0;
    sample.set(state_[2], select(begins, last, state_[2]));
    sample.set(fast_, fast_ * stays);
    sample.set(hardest_, hardest_ * stays);
    sample.set(steadiest_, select(stays > 0.0, steadiest_, Scalar(SampleGuard<Scalar>::size_max)));
    sample.set(motion_, Scalar(motion));
    if (!at_rest) sample.set(direction_, Scalar(motion));
  }

  // Where it speeds up or slows down, a mass that is not as believed is in the estimate, with the other sign at the
  // other end of the stroke; where it is slow, a friction that is not yet, or no longer, that of motion.
  template <class Sample>
  COGGING_INLINE void keep(const Sample& sample, const ReferencePoint& reference) noexcept {
    if (rests(reference.velocity)) return;
    const bool slow = std::abs(reference.velocity) < parameters_.velocity_min;
    const int direction = reference.velocity > 0.0 ? 1 : 0;
    const Scalar acceleration = std::abs(reference.acceleration);
    if (!slow) {
      sample.set(hardest_, hardest_ * fast_);
      sample.set(steadiest_, select(fast_ > 0.0, steadiest_, acceleration));
      sample.set(fast_, Scalar(1.0));
    }
    const Scalar counts = slow ? 1.0 - fast_ : Scalar(1.0);
    sample.set(hardest_, larger(hardest_, counts * acceleration));
    sample.set(steadiest_, select(counts > 0.0, smaller(steadiest_, acceleration), steadiest_));
    const Scalar room = select(counts > 0.0, steadiest_ + 0.01 * hardest_ - acceleration, Scalar(-1.0));
    sample.set(kept_[direction], select(room >= 0.0, state_[2], kept_[direction]));
    sample.set(known_[direction], Scalar(1.0));
  }

  template <class Sample>
  COGGING_INLINE void correct(const Sample& sample, const Scalar& innovation, double velocity) noexcept {
    const Parameters& q = parameters_;
    const double speed = std::abs(velocity);
    const bool frozen = speed < q.velocity_min;
    const Scalar step = sample_time_ * innovation;
    for (int i = 0; i < 3 + 2 * count_; ++i) {
      if (i >= 3 && frozen) break;
      const double gain = q.observer_gain[i] + (q.observer_gain_slope.empty() ? 0.0 : speed * q.observer_gain_slope[i]);
      const bool mirrored = i >= 4 && i % 2 == 0;
      const Scalar signed_gain = mirrored ? select(direction_ < 0.0, Scalar(-gain), Scalar(gain)) : Scalar(gain);
      sample.set(state_[i], died_away(state_[i] + signed_gain * step));
    }
  }

  int count_;
  std::size_t whole_ = 0;
  double sample_time_, fraction_ = 0.0;
  bool measured_rotation_;
  std::array<double, Parameters::periods_max> wavenumber_{};
  std::array<Scalar, states_max> state_;
  DelayLine<Scalar> acted_{0};              // m/s^2
  std::array<Scalar, 2> kept_, known_;      // lambda_0 by direction, and whether it is known
  Scalar direction_ = 0.0;                  // -1 or 1: of the last motion; 0 before the first
  Scalar motion_ = 0.0, fast_ = 0.0;        // -1, 0 at rest, 1; whether it has reached velocity_min
  Scalar hardest_ = 0.0, steadiest_ = 0.0;  // largest and least |a*| of this stroke, m/s^2
  Scalar reference_previous_ = 0.0, reading_previous_ = 0.0;
};

}  // namespace cogging
