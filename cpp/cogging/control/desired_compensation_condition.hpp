#pragma once
// When DCARC's gains are large enough: the matrix of Lu et al. 2008, eq. 29, over bounds and slopes.

#include <cmath>
#include <numbers>

#include "cogging/control/adaptive_robust.hpp"

namespace cogging {

/// A symmetric two-by-two matrix [[pp, pe], [pe, ee]] of the quadratic form in (p, e).
struct QuadraticForm {
  double pp, pe, ee;

  double smallest_eigenvalue() const {
    const double mean = 0.5 * (pp + ee);
    return mean - std::sqrt(0.25 * (pp - ee) * (pp - ee) + pe * pe);
  }
};

/// The matrix (29) at one point. friction_slope = g_f of (24), 1/(m/s); cogging_slope = theta_4b^T g_r of
/// (25), V/m.
inline QuadraticForm desired_compensation_matrix(double feedback_gain, double error_gain, double mass, double viscous,
                                                 double coulomb, double friction_slope, double cogging_slope) {
  const double friction = viscous + coulomb * friction_slope;
  return {feedback_gain - mass * error_gain + friction, -0.5 * (error_gain * friction - cogging_slope),
          0.5 * mass * error_gain * error_gain * error_gain};
}

struct DesiredCompensationCondition {
  double smallest_eigenvalue;  // of (29), the smallest over bounds and slopes
  double decay_rate;           // 1/s: V = M p^2 / 2 + M k_1^2 e^2 / 2 falls at least so fast above epsilon / decay_rate
};

/// The smallest eigenvalue of (29) over the parameter bounds, 0 <= g_f <= friction_slope and |g_r| <=
/// cogging_slope.
///
/// The matrix is affine in mass, viscous, coulomb g_f and the cogging slope, and the smallest eigenvalue of a
/// symmetric matrix is concave in it, so the smallest over the box stands at one of its 16 corners.
///
/// The decay rate follows from V' <= -z^T Q z + epsilon, where Q is (29) with M k_1^3 in the lower corner
/// (half of which (29) sets aside): the smallest eigenvalue of Q relative to diag(M / 2, M k_1^2 / 2).
template <class Scalar>
DesiredCompensationCondition desired_compensation_condition(const AdaptiveRobustParameters<Scalar>& q,
                                                            double friction_slope, double cogging_slope) {
  require_not_negative("friction_slope", friction_slope);
  require_not_negative("cogging_slope", cogging_slope);
  DesiredCompensationCondition worst{INFINITY, INFINITY};
  const std::array<double, 2> coulomb_slopes{0.0, q.coulomb_bounds[1] * friction_slope};
  for (double mass : q.mass_bounds)
    for (double viscous : q.viscous_bounds)
      for (double coulomb_slope : coulomb_slopes)
        for (double slope : {-cogging_slope, cogging_slope}) {
          const QuadraticForm form =
              desired_compensation_matrix(q.feedback_gain, q.error_gain, mass, viscous, coulomb_slope, 1.0, slope);
          worst.smallest_eigenvalue = std::min(worst.smallest_eigenvalue, form.smallest_eigenvalue());
          const double k = q.error_gain, scale = 0.5 * mass;
          const QuadraticForm relative{form.pp / scale, form.pe / (scale * k), 2.0 * form.ee / (scale * k * k)};
          worst.decay_rate = std::min(worst.decay_rate, relative.smallest_eigenvalue());
        }
  return worst;
}

/// The steepest slope of S_f(v) = (2/pi) atan(v / width), 1/(m/s): at rest.
inline double friction_slope_max(double coulomb_width) {
  return 2.0 / (std::numbers::pi * coulomb_width);
}

/// A bound on |d/dx A_r^T S_r(x)|, V/m, when every coefficient lies in [-amplitude, amplitude].
inline double cogging_slope_max(const SplineHarmonics& basis, double amplitude) {
  // One term: |S' s + S w c + C' c - C w s| <= sqrt(2) (amplitude' + w amplitude); a spline of order >= 2 on
  // knots one pitch apart changes by at most 2 amplitude a pitch.
  const double spline_slope = basis.spline().order() > 1 ? 2.0 * amplitude / basis.spline().pitch() : 0.0;
  double sum = 0.0;
  for (double wavenumber : basis.wavenumbers()) sum += std::numbers::sqrt2 * (spline_slope + wavenumber * amplitude);
  return sum;
}

}  // namespace cogging
