#pragma once
// How long a step of Runge and Kutta may be, and what a plant says of itself for that.

#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// How quickly a law changes along the travel and in time, beside what follows from its slope: a step must not skip it.
/// `force` (V) and `gain` (relative, of what the amplifier puts out) are its size, `wavenumber` in rad/m, `rate` in
/// rad/s; of a law without a period, the inverse of the distance or time on which it changes. What fades in time, from
/// t = 0, does so with `decay` (1/s). `stiffness` (V/m) is the largest slope along the travel of a law that is not a
/// wave; `velocity` (m/s) the speed within which a law changes about rest: 0 for a kink. Of a law that is `rough`
/// nothing is known: it may have a kink or a jump anywhere, and no step may go further than its `path` (m), `change` of
/// velocity (m/s) or `duration` (s).
struct Variation {
  double force = 0.0, gain = 0.0;
  double wavenumber = 0.0, rate = 0.0;
  double decay = 0.0;
  double stiffness = 0.0;
  double velocity = infinity;
  bool rough = false;
  double path = infinity, change = infinity, duration = infinity;
};

/// What one Runge-Kutta step of fourth order errs by, as a share of the largest speed so far.
///
/// From its own stages: with z = h times the fastest rate of the law, the step errs in velocity by z^5 / 120 of the
/// transient that it follows, and |a3 - a2| is z / 2 of |a2 - a1|: together h |a3 - a2|^3 / (7.5 |a2 - a1|^2). What
/// the stages cannot see, forces that go with position or time as waves, is Simpson's error of the wave: z^4 / 2880 of
/// its impulse; and a vibration in the wells of such a wave errs by turns in position and in velocity. About rest
/// friction may change within less than the step: there the second difference itself is asked.
template <class Scalar>
class StepAccuracy {
 public:
  StepAccuracy() = default;

  /// A law joins; `mass` in V/(m/s^2).
  void add(const Variation& law, double mass) {
    // A law of no size does nothing, however quickly.
    const auto sized = [](double size, double change) { return size > 0.0 ? size * change : 0.0; };
    const auto fourth = [](double number) { return (number * number) * (number * number); };
    const double along = fourth(law.wavenumber) / mass, in_time = fourth(law.rate) / mass;
    stiffness_ += (sized(law.force, law.wavenumber) + law.stiffness) / mass;
    gain_stiffness_ += sized(law.gain, law.wavenumber) / mass;
    along_ += sized(law.force, along), gain_along_ += sized(law.gain, along);
    if (law.decay > 0.0 && (law.force > 0.0 || law.gain > 0.0))
      fading_.push_back({sized(law.force, in_time), sized(law.gain, in_time), law.decay});
    else
      in_time_ += sized(law.force, in_time), gain_in_time_ += sized(law.gain, in_time);
    add_turning(law.velocity);
    quickest_ = std::max(quickest_, law.force > 0.0 || law.gain > 0.0 ? law.rate : 0.0);
    rough_ = rough_ || law.rough;
    path_ = std::min(path_, law.path), change_ = std::min(change_, law.change);
    duration_ = std::min(duration_, law.duration);
    if (std::isfinite(law.duration)) quickest_ = std::max(quickest_, 1.0 / law.duration);
    varies_ = varies_ || along_ + in_time_ + gain_along_ + gain_in_time_ + stiffness_ > 0.0 || !fading_.empty();
  }

  /// A law joins that changes within this speed about rest, m/s; infinite: it does not.
  void add_turning(const Scalar& velocity) { turning_ = smaller(turning_, velocity * velocity); }

  /// Steps will be at most so long, s, and rounding: the speeds at which waves make none of them err.
  void expect_steps(double longest) {
    const double h = 1.001 * longest, impulse = h * h * h * h * h / (1400.0 * share);
    double in_time = in_time_;
    bool amplified = gain_stiffness_ + gain_along_ + gain_in_time_ > 0.0;
    for (const Fading& law : fading_) in_time += law.force, amplified = amplified || law.gain > 0.0;
    slowest_ = impulse * in_time;
    fastest_ = 0.8 / std::cbrt(impulse * along_);
    const bool bounded = controls_ && !has_kinks() && !amplified && h * h * stiffness_ < 0.99 * ringing_max;
    longest_ = bounded ? h : 0.0;
  }

  /// Whether a step needs no more to be accurate, in all lanes: then both kinds of excess are at most 0. At the speed
  /// of start and end, which are nearly the same, waves do no harm, and friction does not turn.
  COGGING_INLINE bool is_easy(double h, const Scalar& a1, const Scalar& a2, const Scalar& a3, const Scalar& v1,
                              const Scalar& v_end) const {
    const Scalar speed = abs(v1), first = a2 - a1, second = abs(a3 - a2);
    return h <= longest_ && all(speed >= slowest_) && all(speed <= fastest_) && all(6.0 * abs(v_end - v1) <= speed) &&
           all(h * (second * second * second) <= share * speed * (7.5 * (first * first) + second * second));
  }

  /// By how much one step of length h errs more than it may, m/s: at most 0 where it is accurate. Of the accelerations
  /// of the stages, the velocity at start and end, and the largest speed before.
  COGGING_INLINE Scalar excess(double h, const Scalar& a1, const Scalar& a2, const Scalar& a3, const Scalar& a4,
                               const Scalar& v1, const Scalar& v_end, const Scalar& speed_max) const {
    if (!controls_) return Scalar(-1.0);
    const Scalar tolerance = share * larger(larger(speed_max, abs(v1)), 0.01 * h * abs(a1));
    const Scalar first = a2 - a1, second = abs(a3 - a2);
    // A velocity that is no number must not pass: 0 times it is none either.
    const Scalar stiff = h * (second * second * second) + 0.0 * v_end;
    const Scalar unseen = stiff - tolerance * (7.5 * (first * first) + second * second);
    // Within `turning_` of rest the bend of friction is seen by the stages, to the second power of how much.
    const Scalar change = v_end - v1, square = change * change;
    const Scalar nearest = select(v1 * v_end < 0.0, Scalar(0.0), smaller(abs(v1), abs(v_end)));
    const Scalar bend = bend_of(h, a1, a2, a3, a4) * square - tolerance * (square + turning_);
    return larger(unseen, select(nearest < 4.0 * abs(change), bend, Scalar(-1.0)));
  }

  /// The same of a step in which a law has a kink.
  Scalar excess_at_kink(double h, const Scalar& a1, const Scalar& a2, const Scalar& a3, const Scalar& a4,
                        const Scalar& speed_max) const {
    return bend_of(h, a1, a2, a3, a4) - share * speed_max;
  }

  /// The same of waves, of a step from `time`; `drive` is what the amplifier puts out, V, `settling` the fourth
  /// derivative of it over the mass.
  COGGING_INLINE Scalar excess_of_waves(double time, double h, const Scalar& v1, const Scalar& v_end,
                                        const Scalar& drive, const Scalar& settling, const Scalar& speed_max) const {
    const Scalar tolerance = share * larger(larger(speed_max, abs(v1)), abs(v_end));
    const Scalar speed = larger(v1 * v1, v_end * v_end);
    const Scalar amplified = abs(drive);
    Scalar wave = (along_ + gain_along_ * amplified) * (speed * speed) + in_time_ + gain_in_time_ * amplified;
    for (const Fading& law : fading_) wave += exp(-law.decay * time) * (law.force + law.gain * amplified);
    const Scalar ringing = h * h * (stiffness_ + gain_stiffness_ * amplified) - ringing_max;
    return larger(h * h * h * h * h * (wave + settling) - 2880.0 * tolerance, ringing);
  }

  /// Positions (m) and velocities (m/s) at which a law has a kink or a jump join those that are known.
  void add_kinks(const std::vector<double>& positions, const std::vector<double>& velocities) {
    join(positions_, positions), join(velocities_, velocities);
  }
  bool has_kinks() const { return rough_ || !positions_.empty() || !velocities_.empty(); }

  /// Whether one lies, or may lie, between two positions or two velocities.
  bool crosses_kink(double x1, double x2, double v1, double v2) const {
    return rough_ || crosses(positions_, x1, x2) || crosses(velocities_, v1, v2);
  }

  /// Whether a step goes further than a law without known kinks lets it.
  bool oversteps(double h, double x1, double x2, double v1, double v2) const {
    return h > duration_ || std::abs(x2 - x1) > path_ || std::abs(v2 - v1) > change_;
  }

  /// Steps are taken as they are given, whatever they err by.
  void leave_steps() {
    controls_ = varies_ = false;
    positions_.clear(), velocities_.clear();
    rough_ = false, path_ = change_ = duration_ = infinity;
  }
  bool controls() const { return controls_; }

  bool varies() const { return varies_; }
  double quickest() const { return quickest_; }  // rad/s, of what changes in time

  /// Of the largest speed so far: what a step may err by. Sums over a run stay below 1e-6 of its motion.
  static constexpr double share = 1e-9;

 private:
  static void join(std::vector<double>& known, const std::vector<double>& added) {
    known.insert(known.end(), added.begin(), added.end());
    std::sort(known.begin(), known.end());
  }

  static bool crosses(const std::vector<double>& places, double from, double to) {
    const auto next = std::upper_bound(places.begin(), places.end(), std::min(from, to));
    return next != places.end() && *next <= std::max(from, to);
  }

  // What a kink between the stages makes of the velocity at the end, m/s.
  static Scalar bend_of(double h, const Scalar& a1, const Scalar& a2, const Scalar& a3, const Scalar& a4) {
    return 0.2 * h * abs((a1 - a2) - (a3 - a4));
  }

  struct Fading {
    double force, gain, decay;  // m/s^2 times 1/s^4, at t = 0; the same for a drive of 1 V; 1/s
  };

  // (h w)^2 up to which a step errs by less than `share` of a vibration at w: (h w)^5 / 120.
  static constexpr double ringing_max = 1.6e-3;

  double stiffness_ = 0.0, gain_stiffness_ = 0.0;  // 1/s^2; the same for a drive of 1 V
  double along_ = 0.0, in_time_ = 0.0;             // m/s^2 times 1/m^4, 1/s^4
  double gain_along_ = 0.0, gain_in_time_ = 0.0;   // the same for a drive of 1 V
  double quickest_ = 0.0;
  double longest_ = 0.0, slowest_ = 0.0, fastest_ = 0.0;  // s, m/s, m/s: of steps whose waves are bounded
  Scalar turning_ = std::numeric_limits<double>::max();   // (m/s)^2, of the narrowest law about rest
  bool varies_ = false, controls_ = true, rough_ = false;
  double path_ = infinity, change_ = infinity, duration_ = infinity;
  std::vector<Fading> fading_;
  std::vector<double> positions_, velocities_;  // of kinks, increasing
};

/// The lengths of the pieces of one step, which begins at `time`, s: halved until a piece is accurate, doubled after.
/// The first try is as long as `first`.
class StepControl {
 public:
  StepControl(double time, double whole, double first) : time_(time), next_(first), shortest_(1e-12 * whole) {}

  /// The length of the next piece, at most `left`. `tried(length)` makes it and says whether it is accurate.
  /// Raises DivergedError where the pieces are too many: a run that diverges may get too fast before it is far away.
  template <class Try>
  double step(double left, const Try& tried) {
    double length = std::min(next_, left);
    while (!tried(length) && length > shortest_) {
      length *= 0.5;
      if (++refused_ > refused_max) break;
    }
    if (++pieces_ > pieces_max)
      throw DivergedError(
          "axis: must change slowly enough to be integrated in 1e5 steps a sample, got changes at some " +
              format(1.0 / length) + " 1/s at " + format(time_) + " s",
          time_);
    next_ = length < left ? 2.0 * length : std::max(next_, length);
    return length;
  }

 private:
  static constexpr int pieces_max = 100'000, refused_max = 1'000'000;
  double time_, next_, shortest_;
  int pieces_ = 0, refused_ = 0;
};

}  // namespace cogging
