#pragma once
// Adaptive robust control with the B-spline cogging model: ARC and DCARC (Lu et al. 2008, eq. 11 to 30).

#include "cogging/basis/spline_harmonics.hpp"
#include "cogging/control/controller.hpp"
#include "cogging/control/projection.hpp"
#include "cogging/control/sample_guard.hpp"
#include "cogging/parameters.hpp"
#include "cogging/require.hpp"

namespace cogging {

/// What both laws are built from. Bounds and rates are belief: nothing here is read from a plant.
template <class Scalar = double>
struct AdaptiveRobustParameters {
  static constexpr std::string_view name = "adaptive_robust";
  static constexpr std::string_view description =
      "Gains, bounds and initial estimates of Arc and Dcarc (Lu et al. 2008, eq. 11 to 30).";
  using Bounds = std::array<double, 2>;

  double sample_rate = 5000.0;  // Hz
  Scalar error_gain = 200.0;    // 1/s
  Scalar feedback_gain = 48.0;  // V/(m/s)
  Scalar mass = 0.12;           // V/(m/s^2)
  Bounds mass_bounds = {0.1, 0.2};
  double mass_adaptation = 0.0;
  Scalar viscous = 0.0;  // V/(m/s)
  Bounds viscous_bounds = {0.0, 1.0};
  double viscous_adaptation = 0.0;
  Scalar coulomb = 0.0;  // V
  Bounds coulomb_bounds = {0.0, 1.0};
  double coulomb_adaptation = 0.0;
  Scalar coulomb_width = 1.0 / 900.0;  // m/s
  Scalar disturbance = 0.0;            // V
  Bounds disturbance_bounds = {-1.0, 1.0};
  double disturbance_adaptation = 0.0;
  double cogging_pitch = 0.05;  // m
  std::vector<int> cogging_harmonics{};
  int cogging_order = 3;
  double cogging_origin = 0.0;  // m
  int cogging_control_points = 1;
  Bounds cogging_bounds = {-0.1, 0.1};
  double cogging_adaptation = 0.0;
  std::vector<double> cogging_estimates{};
  double epsilon = 0.0;            // V m/s
  double disturbance_bound = 0.0;  // V
  double command_limit = 0.0;      // V
  bool error_difference = false;

  static constexpr auto fields() {
    using P = AdaptiveRobustParameters;
    return std::tuple{
        Field{"sample_rate", &P::sample_rate, "Hz", "samples a second", Rule::positive},
        Field{"error_gain", &P::error_gain, "1/s", "k_1 of p = e' + k_1 e (eq. 15)", Rule::positive},
        Field{"feedback_gain", &P::feedback_gain, "V/(m/s)", "k_s1 of u_s1 = -k_s1 p (eq. 19, 27)", Rule::positive},
        Field{"mass", &P::mass, "V/(m/s^2)", "initial estimate of theta_1 = M", Rule::any},
        Field{"mass_bounds", &P::mass_bounds, "V/(m/s^2)", "theta_1 min and max (eq. 11)"},
        Field{"mass_adaptation", &P::mass_adaptation, "V/(m/s^2)/(V m/s) m/s", "Gamma of theta_1", Rule::not_negative},
        Field{"viscous", &P::viscous, "V/(m/s)", "initial estimate of theta_2 = B", Rule::any},
        Field{"viscous_bounds", &P::viscous_bounds, "V/(m/s)", "theta_2 min and max"},
        Field{"viscous_adaptation", &P::viscous_adaptation, "V s/m^2", "Gamma of theta_2", Rule::not_negative},
        Field{"coulomb", &P::coulomb, "V", "initial estimate of theta_3 = A_f", Rule::any},
        Field{"coulomb_bounds", &P::coulomb_bounds, "V", "theta_3 min and max"},
        Field{"coulomb_adaptation", &P::coulomb_adaptation, "V/m", "Gamma of theta_3", Rule::not_negative},
        Field{"coulomb_width", &P::coulomb_width, "m/s", "of S_f(v) = (2/pi) atan(v / width) (eq. 2)",
              Rule::not_negative},
        Field{"disturbance", &P::disturbance, "V", "initial estimate of d_n = -theta_5", Rule::any},
        Field{"disturbance_bounds", &P::disturbance_bounds, "V", "d_n min and max"},
        Field{"disturbance_adaptation", &P::disturbance_adaptation, "V/m", "Gamma of theta_5", Rule::not_negative},
        Field{"cogging_pitch", &P::cogging_pitch, "m", "P of the harmonics and of the knots", Rule::period},
        Field{"cogging_harmonics", &P::cogging_harmonics, "1", "those compensated; empty = no cogging compensation"},
        Field{"cogging_order", &P::cogging_order, "1", "k of the B-splines (eq. 6)"},
        Field{"cogging_origin", &P::cogging_origin, "m", "first knot inside the travel"},
        Field{"cogging_control_points", &P::cogging_control_points, "1",
              "m of the B-splines; 1 = periodic, amplitudes constant along the travel"},
        Field{"cogging_bounds", &P::cogging_bounds, "V", "min and max of every entry of theta_4b = A_r"},
        Field{"cogging_adaptation", &P::cogging_adaptation, "V/m", "Gamma of every entry of A_r", Rule::not_negative},
        Field{"cogging_estimates", &P::cogging_estimates, "V",
              "initial A_r, one control point after the other; empty = zeros"},
        Field{"epsilon", &P::epsilon, "V m/s", "of the robust term u_s2 (eq. 20, 30); 0 = no such term",
              Rule::not_negative},
        Field{"disturbance_bound", &P::disturbance_bound, "V", "delta_d of eq. 12, for u_s2", Rule::not_negative},
        Field{"command_limit", &P::command_limit, "V", "largest command; 0 = none", Rule::not_negative},
        Field{"error_difference", &P::error_difference, "",
              "e' of p is the difference of e; false = that of the reading, minus the reference's velocity"}};
  }

  SplineHarmonics cogging_basis() const {
    if (cogging_harmonics.empty()) return {};
    return SplineHarmonics::of_harmonics(cogging_pitch, cogging_harmonics,
                                         BSpline(cogging_order, cogging_origin, cogging_pitch, cogging_control_points));
  }

  void validate() const {
    check_estimate("mass", mass, mass_bounds);
    require_positive("mass_bounds", mass_bounds[0]);
    check_estimate("viscous", viscous, viscous_bounds);
    check_estimate("coulomb", coulomb, coulomb_bounds);
    check_estimate("disturbance", disturbance, disturbance_bounds);
    for (int harmonic : cogging_harmonics)
      require(harmonic >= 1, "cogging_harmonics", "each must be at least 1", harmonic);
    require(cogging_order >= 1 && cogging_order <= BSpline::order_max, "cogging_order", "must be from 1 to 16",
            cogging_order);
    require(cogging_control_points == 1 || cogging_control_points >= std::max(cogging_order, 1),
            "cogging_control_points", "must be 1 or at least the order " + format(cogging_order),
            cogging_control_points);
    SplineHarmonics::require_coefficients("cogging_control_points", cogging_control_points, cogging_harmonics.size());
    const SplineHarmonics basis = cogging_basis();
    require_ordered("cogging_bounds", cogging_bounds[0], cogging_bounds[1]);
    if (!cogging_estimates.empty())
      require(std::ssize(cogging_estimates) == basis.coefficients(), "cogging_estimates",
              "must hold control points times twice the harmonics = " + format(basis.coefficients()) + " values",
              cogging_estimates.size());
    for (double value : cogging_estimates)
      require(value >= cogging_bounds[0] && value <= cogging_bounds[1], "cogging_estimates",
              "must lie within cogging_bounds", value);
  }

 private:
  static void check_estimate(const std::string& label, const Scalar& value, const Bounds& bounds) {
    require_ordered(label + "_bounds", bounds[0], bounds[1]);
    const std::string rule =
        "must lie within " + label + "_bounds [" + format(bounds[0]) + ", " + format(bounds[1]) + "]";
    require(value >= bounds[0], label, rule, value);
    require(value <= bounds[1], label, rule, value);
  }
};

/// u = u_a + u_s1 + u_s2 with p = e' + k_1 e, u_a = -phi^T theta_hat, u_s1 = -k_s1 p (eq. 15 to 19, 26, 27),
/// and theta_hat' = Proj(Gamma phi p) (eq. 21, 28), stepped once a sample.
///
/// The two laws differ in where the regressor phi is evaluated: ARC at the measured state (eq. 16), DCARC on
/// the reference (eq. 24 to 28). The velocity is the backward difference of the readings, 0 in the first
/// sample. It is half a sample old: where the reference accelerates by a, p is wrong by a T / 2 if e' is this velocity
/// minus the reference's. With error_difference e' is the difference of e itself, 0 in the first sample.
///
/// u_s2 = -h tanh(0.2785 h p / epsilon), h = theta_range^T |phi| + delta_d, is smooth and satisfies (20) and
/// (30): |s| - s tanh(0.2785 s / epsilon) <= epsilon for every s.
///
/// In a sample that is refused (see SampleGuard) nothing is learned. Behind it, the velocity is the mean over the
/// samples that have passed.
template <class Scalar, bool desired_compensation>
class AdaptiveRobust : public GuardedController<AdaptiveRobustParameters<Scalar>, Scalar> {
  using Base = GuardedController<AdaptiveRobustParameters<Scalar>, Scalar>;
  using Base::guard_, Base::parameters_;

 public:
  using typename Base::Parameters;
  static constexpr std::string_view name = desired_compensation ? "dcarc" : "arc";
  static constexpr std::string_view description =
      desired_compensation ? R"(Desired compensation adaptive robust control (Lu et al. 2008, eq. 24 to 30).

As Arc, with the regressor on the reference in place of the measured state. Estimates: mass, viscous, coulomb, d_n,
then A_r.)"
                           : R"(Adaptive robust control (Lu et al. 2008, eq. 15 to 23).

u = -phi^T theta_hat - k_s1 p + u_s2 with p = e' + k_1 e, the regressor phi at the measured state;
theta_hat' = Proj(Gamma phi p), one Euler step a sample. Estimates: mass, viscous, coulomb, d_n, then A_r.)";
  static constexpr int plain = 4;  // mass, viscous, coulomb, disturbance come before the cogging coefficients

  explicit AdaptiveRobust(const Parameters& parameters = {})
      : Base(parameters),
        basis_(parameters.cogging_basis()),
        sample_time_(1.0 / parameters.sample_rate),
        estimates_(plain + basis_.coefficients(), Scalar(0.0)) {
    estimates_[0] = parameters.mass;
    estimates_[1] = parameters.viscous;
    estimates_[2] = parameters.coulomb;
    estimates_[3] = parameters.disturbance;
    for (std::size_t i = 0; i < parameters.cogging_estimates.size(); ++i)
      estimates_[plain + i] = parameters.cogging_estimates[i];
  }

  /// mass, viscous, coulomb, d_n, then A_r one control point after the other.
  std::span<const Scalar> estimates() const { return estimates_; }
  /// What changes while it runs (see Pid::state).
  auto state() noexcept {
    return std::tie(guard_, estimates_, active_.spline.first, active_.spline.weight, active_.harmonic, regressor_,
                    reading_previous_, error_previous_, p_);
  }

  Scalar command(const ReferencePoint& reference, Scalar reading) noexcept {
    return guard_.command(guard_.usable(reference), reading,
                          [&](const auto& sample, const Scalar& y) { return law(sample, reference, y); });
  }

  void update(Scalar) noexcept {
    const Parameters& q = parameters_;
    const Scalar p = guard_.if_taken(p_, Scalar(0.0));
    adapt_plain(0, q.mass_adaptation, q.mass_bounds, p);
    adapt_plain(1, q.viscous_adaptation, q.viscous_bounds, p);
    adapt_plain(2, q.coulomb_adaptation, q.coulomb_bounds, p);
    adapt_plain(3, q.disturbance_adaptation, q.disturbance_bounds, p);
    if (basis_.empty() || q.cogging_adaptation == 0.0) return;
    const Scalar step = -q.cogging_adaptation * sample_time_ * p;
    basis_.move(estimates_.data() + plain, active_, step, q.cogging_bounds[0], q.cogging_bounds[1]);
  }

 private:
  template <class Sample>
  COGGING_INLINE Scalar law(const Sample& sample, const ReferencePoint& reference, const Scalar& reading) noexcept {
    const Scalar velocity = sample.per_sample(reading - reading_previous_) / sample_time_;
    sample.set(reading_previous_, reading);

    const Scalar error = reading - reference.position;
    const Scalar error_rate = parameters_.error_difference ? sample.per_sample(error - error_previous_) / sample_time_
                                                           : velocity - reference.velocity;
    sample.set(error_previous_, error);
    const Scalar p = error_rate + parameters_.error_gain * error;
    sample.set(p_, p);
    if constexpr (desired_compensation) {
      regress(Scalar(reference.position), Scalar(reference.velocity), Scalar(reference.acceleration));
    } else {  // x_2eq' = x_d'' - k_1 e'
      regress(reading, velocity, reference.acceleration - parameters_.error_gain * error_rate);
    }
    Scalar model = 0.0;  // u_a = -phi^T theta_hat
    for (int i = 0; i < plain; ++i) model -= regressor_[i] * estimates_[i];
    if (!basis_.empty()) model += basis_.value(active_, estimates_.data() + plain);
    return model - parameters_.feedback_gain * p + robust_term(p);
  }

  // phi = [-a, -v, -S_f(v), +1 on d_n, -S_r(x)]; d_n = -theta_5 turns the paper's -1 into +1.
  COGGING_INLINE void regress(const Scalar& position, const Scalar& velocity, const Scalar& acceleration) noexcept {
    regressor_[0] = -acceleration;
    regressor_[1] = -velocity;
    regressor_[2] = -smooth_sign(velocity, parameters_.coulomb_width);
    regressor_[3] = 1.0;
    if (!basis_.empty()) basis_.evaluate(position, active_);
  }

  void adapt_plain(int i, double gain, const std::array<double, 2>& bounds, const Scalar& p) noexcept {
    if (gain > 0.0)
      estimates_[i] =
          adapt(estimates_[i], gain * sample_time_ * regressor_[i] * p, Scalar(bounds[0]), Scalar(bounds[1]));
  }

  COGGING_INLINE Scalar robust_term(const Scalar& p) const noexcept {
    const Parameters& q = parameters_;
    if (q.epsilon == 0.0) return 0.0;
    const auto width = [](const std::array<double, 2>& bounds) { return bounds[1] - bounds[0]; };
    Scalar h = width(q.mass_bounds) * abs(regressor_[0]) + width(q.viscous_bounds) * abs(regressor_[1]) +
               width(q.coulomb_bounds) * abs(regressor_[2]) + width(q.disturbance_bounds) + q.disturbance_bound;
    if (!basis_.empty()) {
      Scalar harmonics = 0.0;  // the weights of the active control points sum to one
      for (int c = 0; c < basis_.columns(); ++c) harmonics += abs(active_.harmonic[c]);
      h += width(q.cogging_bounds) * harmonics;
    }
    return -h * tanh(0.2785 * h * p / q.epsilon);
  }

  SplineHarmonics basis_;
  double sample_time_;
  std::vector<Scalar> estimates_;
  SplineHarmonics::Active<Scalar> active_{};
  std::array<Scalar, plain> regressor_{};
  Scalar reading_previous_ = 0.0, error_previous_ = 0.0, p_ = 0.0;
};

template <class Scalar = double>
using Arc = AdaptiveRobust<Scalar, false>;
template <class Scalar = double>
using Dcarc = AdaptiveRobust<Scalar, true>;

}  // namespace cogging
