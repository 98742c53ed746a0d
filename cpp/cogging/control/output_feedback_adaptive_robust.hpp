#pragma once
// Output-feedback adaptive robust control: positions only (Xu and Yao 2001, eq. 5 to 53).

#include <array>

#include "cogging/control/controller.hpp"
#include "cogging/control/projection.hpp"
#include "cogging/control/sample_guard.hpp"
#include "cogging/parameters.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// theta = [1/M, B/M, d_n/M]. Each robust term has its own switch; with all of them off the gains are g_1 and g_2
/// alone.
template <class Scalar = double>
struct OutputFeedbackArcParameters {
  static constexpr std::string_view description =
      "Observer, gains, bounds and robust terms of an OutputFeedbackArc (Xu and Yao 2001, eq. 8 to 50).";

  using Triple = std::array<double, 3>;

  double sample_rate = 2500.0;           // Hz
  double observer_gain_1 = 400.0;        // 1/s
  double observer_gain_2 = 4e4;          // 1/s^2
  Triple theta = {30.0, 10.0, 0.0};      // m/(V s^2), 1/s, m/s^2
  Triple theta_min = {8.3, 2.4, -50.0};  // same
  Triple theta_max = {50.0, 17.5, 50.0};
  Triple adaptation = {5e5, 3e5, 2e6};
  double weight_1 = 1.0;
  double weight_2 = 0.1;
  double gain_1 = 600.0;  // 1/s
  double gain_2 = 850.0;  // 1/s
  double epsilon_11 = 5e-5, epsilon_12 = 5e-5, epsilon_21 = 1e-3, epsilon_22 = 1.0;
  Triple c_phi_1 = {5e-5, 5e-6, 1e-4};
  Triple c_phi_2 = {5e-5, 5e-6, 1e-4};
  Triple c_theta_2 = {1e5, 1e5, 1e5};
  bool use_alpha_1s2 = false, use_alpha_1s3 = false, use_c_phi_1 = false;
  bool use_c_theta_2 = false, use_c_phi_2 = false, use_u_s2 = false, use_u_s3 = false;
  double robust_factor = 1.0;
  double coulomb = 0.0;        // V
  double coulomb_width = 0.0;  // m/s
  std::string filter_steps = "exact";
  double command_limit = 0.0;  // V

  static constexpr auto fields() {
    using P = OutputFeedbackArcParameters;
    return std::tuple{
        Field{"sample_rate", &P::sample_rate, "Hz", "samples a second", Rule::positive},
        Field{"observer_gain_1", &P::observer_gain_1, "1/s", "k_1 of A_0 (eq. 10)", Rule::any},
        Field{"observer_gain_2", &P::observer_gain_2, "1/s^2", "k_2 of A_0 (eq. 10)", Rule::any},
        Field{"theta", &P::theta, "", "initial estimates of 1/M, B/M, d_n/M"},
        Field{"theta_min", &P::theta_min, "", "lower bounds (eq. 8)"},
        Field{"theta_max", &P::theta_max, "", "upper bounds (eq. 8)"},
        Field{"adaptation", &P::adaptation, "", "diagonal of Gamma (eq. 19); 0 = no adaptation", Rule::not_negative},
        Field{"weight_1", &P::weight_1, "1", "w_1 (eq. 30)", Rule::positive},
        Field{"weight_2", &P::weight_2, "1", "w_2 (eq. 41)", Rule::positive},
        Field{"gain_1", &P::gain_1, "1/s", "g_1 (eq. 28)", Rule::positive},
        Field{"gain_2", &P::gain_2, "1/s", "g_2 (eq. 43)", Rule::positive},
        Field{"epsilon_11", &P::epsilon_11, "", "of alpha_1s2 (eq. 33)", Rule::positive},
        Field{"epsilon_12", &P::epsilon_12, "", "of alpha_1s3 (eq. 35)", Rule::positive},
        Field{"epsilon_21", &P::epsilon_21, "", "of u_s2 (eq. 46)", Rule::positive},
        Field{"epsilon_22", &P::epsilon_22, "", "of u_s3 (eq. 46)", Rule::positive},
        Field{"c_phi_1", &P::c_phi_1, "", "diagonal of C_phi1 (eq. 28)", Rule::not_negative},
        Field{"c_phi_2", &P::c_phi_2, "", "diagonal of C_phi2 (eq. 43)", Rule::not_negative},
        Field{"c_theta_2", &P::c_theta_2, "", "diagonal of C_theta2 (eq. 43)", Rule::not_negative},
        Field{"use_alpha_1s2", &P::use_alpha_1s2, "", "robust term against parameters, step 1 (eq. 37)"},
        Field{"use_alpha_1s3", &P::use_alpha_1s3, "", "robust term against estimation errors, step 1 (eq. 38)"},
        Field{"use_c_phi_1", &P::use_c_phi_1, "", "state-dependent part of k_1s (eq. 28)"},
        Field{"use_c_theta_2", &P::use_c_theta_2, "", "part of k_2s with d alpha_1 / d theta_hat (eq. 43)"},
        Field{"use_c_phi_2", &P::use_c_phi_2, "", "part of k_2s with phi_2 (eq. 43)"},
        Field{"use_u_s2", &P::use_u_s2, "", "robust term against parameters, step 2 (eq. 47)"},
        Field{"use_u_s3", &P::use_u_s3, "", "robust term against estimation errors, step 2 (eq. 47)"},
        Field{"robust_factor", &P::robust_factor, "1", "common factor on the terms that are switched on",
              Rule::not_negative},
        Field{"coulomb", &P::coulomb, "V", "level of the friction compensation at reference velocity (eq. 5)",
              Rule::not_negative},
        Field{"coulomb_width", &P::coulomb_width, "m/s", "of its S(v); 0 = sgn", Rule::not_negative},
        Field{"filter_steps", &P::filter_steps, "", "\"exact\" for held inputs, or \"euler\""},
        Field{"command_limit", &P::command_limit, "V", "largest command; 0 = none", Rule::not_negative}};
  }

  void validate() const {
    // A_0 = [[-k_1, 1], [-k_2, 0]] is stable exactly when both are above 0.
    require(std::isfinite(observer_gain_1) && observer_gain_1 > 0.0, "observer_gain_1",
            "must be above 0, or A_0 is not stable", observer_gain_1);
    require(std::isfinite(observer_gain_2) && observer_gain_2 > 0.0, "observer_gain_2",
            "must be above 0, or A_0 is not stable", observer_gain_2);
    require_positive("theta_min", theta_min[0]);
    for (int i = 0; i < 3; ++i) {
      require_ordered("theta_min, theta_max", theta_min[i], theta_max[i]);
      require(theta[i] >= theta_min[i] && theta[i] <= theta_max[i], "theta", "must lie within theta_min and theta_max",
              theta[i]);
    }
    if (filter_steps != "exact" && filter_steps != "euler")
      refuse("filter_steps", "must be \"exact\" or \"euler\"", filter_steps);
    const double step = 1.0 / sample_rate;
    require(std::isfinite((observer_gain_1 + observer_gain_2 * step) * step), "sample_rate",
            "must be high enough for observer_gain_1 and observer_gain_2 a sample to be numbers", sample_rate);
    if (filter_steps == "euler") {
      // |1 + s T| < 1 at both roots s of s^2 + k_1 s + k_2 (Jury): k_2 T^2 < k_1 T and k_2 T^2 - 2 k_1 T + 4 > 0.
      const double a = observer_gain_1 * step, b = observer_gain_2 * step * step;
      require(b < a && b - 2.0 * a + 4.0 > 0.0, "sample_rate", "is too low for Euler steps of the observer's filters",
              sample_rate);
    }
  }
};

/// Backstepping in two steps on a Kreisselmeier observer. u = u* + coulomb S(reference velocity) (eq. 5).
///
/// Filters (18): eta' = A_0 eta + e_2 y, lambda' = A_0 lambda + e_2 u*, psi' = A_0 psi + e_2 (12), from rest (Remark
/// 4); xi_1, xi_2 follow by (17). With z_1 = y - q_d and z_2 = lambda_2 - alpha_1 the law is (25), (27), (39), (43),
/// the adaptation (50) with projection (19), (20), one Euler step a sample.
///
/// In a sample that is refused (see SampleGuard) theta_hat and eta stay; lambda and psi, which the applied command
/// drives and nothing, go on. Behind it eta makes up for the samples that were missed, y on a straight line; behind
/// more than 16 of them it is where that line would have led it in the end.
template <class Scalar = double>
class OutputFeedbackArc : public GuardedController<OutputFeedbackArcParameters<Scalar>, Scalar> {
  using Base = GuardedController<OutputFeedbackArcParameters<Scalar>, Scalar>;
  using Base::guard_, Base::parameters_;

 public:
  using typename Base::Parameters;
  static constexpr std::string_view name = "output_feedback_arc";
  static constexpr std::string_view description = R"(Output-feedback adaptive robust control (Xu and Yao 2001).

u = u* + coulomb S(reference velocity): filters (18), state estimate (13), two backstepping steps (25) to (47),
adaptation (50) with projection. theta = [1/M, B/M, d_n/M]. Positions count from the first reading. The
filters of the applied command go on through samples that are refused; that of the readings makes up for them behind.)";
  using Vector = std::array<Scalar, 3>;
  using State = std::array<Scalar, 2>;

  /// What alpha_1 depends on.
  struct Inputs {
    Scalar position, eta_1, eta_2, psi_2, reference, reference_velocity;
    Vector theta;
  };

  /// alpha_1 with its exact partial derivatives, also where k_1s depends on the state.
  struct VirtualControl {
    Scalar value;                                                         // alpha_1
    Scalar model;                                                         // alpha_1a
    Vector phi;                                                           // phi_1
    Scalar position, eta_1, eta_2, psi_2, reference, reference_velocity;  // d alpha_1 / d ...
    Vector theta;                                                         // d alpha_1 / d theta_hat
  };

  explicit OutputFeedbackArc(const Parameters& parameters = {})
      : Base(parameters), sample_time_(1.0 / parameters.sample_rate) {
    for (int i = 0; i < 3; ++i) {
      theta_[i] = parameters.theta[i];
      const double range = parameters.theta_max[i] - parameters.theta_min[i];
      theta_range_square_ += range * range;
    }
    discretise();
  }

  /// theta_hat.
  std::span<const Scalar> estimates() const { return theta_; }
  /// What changes while it runs (see Pid::state).
  auto state() noexcept {
    return std::tie(guard_, theta_, phi_1_, phi_2_, eta_, lambda_, psi_, z_1_, z_2_, origin_, position_, compensation_);
  }
  const Scalar& z_1() const { return z_1_; }
  const Scalar& z_2() const { return z_2_; }
  /// eta, lambda, psi.
  std::array<Scalar, 6> filters() const { return {eta_[0], eta_[1], lambda_[0], lambda_[1], psi_[0], psi_[1]}; }
  /// x_2 hat of eq. 13, with the estimates it has now.
  Scalar velocity_state(const Vector& theta) const {
    return xi_22(eta_[0], eta_[1]) - theta[1] * xi_12(eta_[0]) + theta[0] * lambda_[1] + theta[2] * psi_[1];
  }

  COGGING_INLINE VirtualControl virtual_control(const Inputs& in) const noexcept {
    const Parameters& q = parameters_;
    const double k1 = q.observer_gain_1, k2 = q.observer_gain_2;
    const Scalar inverse = Scalar(1.0) / in.theta[0], s = xi_12(in.eta_1) + in.position;
    VirtualControl out;
    out.model = -inverse *
                (xi_22(in.eta_1, in.eta_2) - in.theta[1] * s + in.theta[2] * in.psi_2 - in.reference_velocity);  // (25)
    out.phi = {out.model, -s, in.psi_2};

    // k_1s with the two terms of (27) that are proportional to z_1 as well: base + sum_i weight_i phi_i^2.
    Scalar gain = q.gain_1, weighted_phi[3];
    if (q.use_alpha_1s3) gain += q.robust_factor / (4.0 * q.epsilon_12);  // (38)
    for (int i = 0; i < 3; ++i) {
      double weight = 0.0;
      if (q.use_c_phi_1) weight += pow(q.c_phi_1[i] * q.adaptation[i], 2.0);      // (28)
      if (q.use_alpha_1s2) weight += theta_range_square_ / (4.0 * q.epsilon_11);  // (36), (37)
      weighted_phi[i] = q.robust_factor * weight * out.phi[i];
      gain += weighted_phi[i] * out.phi[i];
    }
    const Scalar error = in.position - in.reference;
    const double scale = 1.0 / q.theta_min[0];
    out.value = out.model - scale * gain * error;

    // d alpha_1 = d alpha_1a - scale (2 sum_i weighted_phi_i d phi_i) error - scale gain d error.
    const auto derivative = [&](const Scalar& model, const Scalar& s_part, const Scalar& psi_part,
                                const Scalar& error_part) {
      const Scalar gain_part = 2.0 * (weighted_phi[0] * model - weighted_phi[1] * s_part + weighted_phi[2] * psi_part);
      return model - scale * (gain_part * error + gain * error_part);
    };
    const Scalar zero = 0.0, one = 1.0;
    out.position = derivative(in.theta[1] * inverse, one, zero, one);
    out.eta_1 = derivative(-inverse * (in.theta[1] * k2 - k1 * k2), Scalar(-k2), zero, zero);
    out.eta_2 = derivative(-inverse * k2, zero, zero, zero);
    out.psi_2 = derivative(-inverse * in.theta[2], zero, one, zero);
    out.reference = derivative(zero, zero, zero, -one);
    out.reference_velocity = derivative(inverse, zero, zero, zero);
    out.theta = {derivative(-inverse * out.model, zero, zero, zero), derivative(inverse * s, zero, zero, zero),
                 derivative(-inverse * in.psi_2, zero, zero, zero)};
    return out;
  }

  Scalar command(const ReferencePoint& reference, Scalar reading) noexcept {
    return guard_.command(guard_.usable(reference), reading,
                          [&](const auto& sample, const Scalar& y) { return law(sample, reference, y); });
  }

  void update(Scalar applied) noexcept {
    const Parameters& q = parameters_;
    for (int i = 0; i < 3; ++i) {
      const Scalar tau = q.weight_1 * phi_1_[i] * z_1_ + q.weight_2 * phi_2_[i] * z_2_;  // (50)
      if (q.adaptation[i] > 0.0)
        theta_[i] = adapt(theta_[i], sample_time_ * q.adaptation[i] * guard_.if_taken(tau, Scalar(0.0)),
                          Scalar(q.theta_min[i]), Scalar(q.theta_max[i]));
    }
    const State eta = step(eta_, position_);
    for (int i = 0; i < 2; ++i) eta_[i] = guard_.if_taken(eta[i], eta_[i]);
    lambda_ = step(lambda_, guard_.acted(applied) - compensation_);
    psi_ = step(psi_, Scalar(1.0));
  }

 private:
  // Positions count from the first reading: Remark 4 with filters at rest needs y(0) = 0.
  template <class Sample>
  COGGING_INLINE void take_up(const Sample& sample, const Scalar& reading) noexcept {
    sample.begin(origin_, reading);
    for (State* filter : {&lambda_, &psi_})
      for (Scalar& state : *filter) sample.begin(state, Scalar(0.0));
    const Scalar position = reading - origin_, moved = position - position_;
    const double k1 = parameters_.observer_gain_1, k2 = parameters_.observer_gain_2;
    const Scalar speed = sample.per_sample(moved) * parameters_.sample_rate;
    sample.start(eta_[0], (position - speed * (k1 / k2)) / k2);  // where a straight line has led it
    sample.start(eta_[1], speed / k2 + k1 * eta_[0]);
    for (int missed = 1; missed <= sample.bridged; ++missed) {
      const State eta = step(eta_, position_ + moved * (double(missed) / sample.steps));
      for (int i = 0; i < 2; ++i) sample.bridge(missed, eta_[i], eta[i]);
    }
    sample.set(position_, position);
  }

  template <class Sample>
  COGGING_INLINE Scalar law(const Sample& sample, const ReferencePoint& reference, const Scalar& reading) noexcept {
    const Parameters& q = parameters_;
    const double k1 = q.observer_gain_1, k2 = q.observer_gain_2;
    take_up(sample, reading);
    const VirtualControl alpha = virtual_control(
        {position_, eta_[0], eta_[1], psi_[1], reference.position - origin_, Scalar(reference.velocity), theta_});
    const Scalar z_1 = reading - reference.position, z_2 = lambda_[1] - alpha.value;
    sample.set(z_1_, z_1);
    sample.set(z_2_, z_2);

    const Vector omega = {lambda_[1], alpha.phi[1], psi_[1]};
    const Scalar eta_rate_1 = -k1 * eta_[0] + eta_[1], eta_rate_2 = -k2 * eta_[0] + position_;
    const Scalar psi_rate_2 = -k2 * psi_[0] + 1.0;
    Scalar velocity = xi_22(eta_[0], eta_[1]);
    for (int i = 0; i < 3; ++i) velocity += theta_[i] * omega[i];
    const Scalar alpha_rate = alpha.position * velocity + alpha.eta_1 * eta_rate_1 + alpha.eta_2 * eta_rate_2 +
                              alpha.psi_2 * psi_rate_2 + alpha.reference * reference.velocity +
                              alpha.reference_velocity * reference.acceleration;  // (39)

    const double ratio = q.weight_1 / q.weight_2;
    Scalar gain = q.gain_2, phi_square = 0.0, robust = 0.0;
    for (int i = 0; i < 3; ++i) {
      const Scalar phi_2 = -alpha.position * omega[i] + (i == 0 ? ratio * z_1 : Scalar(0.0));  // (45)
      sample.set(phi_1_[i], alpha.phi[i]);
      sample.set(phi_2_[i], phi_2);
      phi_square += phi_2 * phi_2;
      const Scalar by_theta = alpha.theta[i] * q.c_theta_2[i];
      const Scalar by_phi = q.c_phi_2[i] * q.adaptation[i] * phi_2;
      if (q.use_c_theta_2) robust += by_theta * by_theta;  // (43)
      if (q.use_c_phi_2) robust += by_phi * by_phi;        // (43)
    }
    if (q.use_u_s2) robust += theta_range_square_ * phi_square / (4.0 * q.epsilon_21);  // (47), (48)
    if (q.use_u_s3) robust += alpha.position * alpha.position / (4.0 * q.epsilon_22);   // (47)
    gain += q.robust_factor * robust;
    const Scalar compensation = q.coulomb * smooth_sign(Scalar(reference.velocity), Scalar(q.coulomb_width));
    sample.set(compensation_, compensation);
    return -ratio * theta_[0] * z_1 + k2 * lambda_[0] + alpha_rate - gain * z_2 + compensation;
  }

  Scalar xi_12(const Scalar& eta_1) const { return -parameters_.observer_gain_2 * eta_1; }  // (A_0 eta)_2
  Scalar xi_22(const Scalar& eta_1, const Scalar& eta_2) const {                            // (-A_0^2 eta)_2
    return parameters_.observer_gain_2 * (eta_2 - parameters_.observer_gain_1 * eta_1);
  }

  COGGING_INLINE State step(const State& x, const Scalar& input) const {
    return {died_away(transition_[0] * x[0] + transition_[1] * x[1] + response_[0] * input),
            died_away(transition_[2] * x[0] + transition_[3] * x[1] + response_[1] * input)};
  }

  // x' = A_0 x + e_2 input with the input held: exp(A_0 T) and its integral, by their Taylor series with halving.
  void discretise() {
    const double k1 = parameters_.observer_gain_1, k2 = parameters_.observer_gain_2;
    using Square = std::array<double, 9>;  // [[A_0, e_2], [0, 0]]
    const auto multiply = [](const Square& a, const Square& b) {
      Square c{};
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          for (int k = 0; k < 3; ++k) c[3 * i + j] += a[3 * i + k] * b[3 * k + j];
      return c;
    };
    const double t = sample_time_;
    Square block{-k1 * t, t, 0.0, -k2 * t, 0.0, t, 0.0, 0.0, 0.0};
    Square sum{1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (parameters_.filter_steps == "euler") {
      for (int i = 0; i < 9; ++i) sum[i] += block[i];
    } else {
      const int halvings = 5 + std::ilogb(std::min(1.0 + (k1 + k2 * t) * t, 1e300));
      for (double& entry : block) entry = std::ldexp(entry, -halvings);
      Square term = sum;
      for (int n = 1; n <= 16; ++n) {
        term = multiply(term, block);
        for (int i = 0; i < 9; ++i) sum[i] += (term[i] /= n);
      }
      for (int i = 0; i < halvings; ++i) sum = multiply(sum, sum);
    }
    transition_ = {sum[0], sum[1], sum[3], sum[4]};
    response_ = {sum[2], sum[5]};
  }

  double sample_time_, theta_range_square_ = 0.0;
  std::array<double, 4> transition_{};
  std::array<double, 2> response_{};
  Vector theta_{}, phi_1_{}, phi_2_{};
  State eta_{Scalar(0.0), Scalar(0.0)}, lambda_{Scalar(0.0), Scalar(0.0)}, psi_{Scalar(0.0), Scalar(0.0)};
  Scalar z_1_ = 0.0, z_2_ = 0.0, origin_ = 0.0, position_ = 0.0, compensation_ = 0.0;
};

}  // namespace cogging
