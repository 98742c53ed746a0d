#pragma once
// The cogging model: harmonics of the magnet pitch whose amplitudes are B-splines (Lu et al. 2008, eq. 3 to
// 7).

#include <algorithm>
#include <array>
#include <numbers>
#include <vector>

#include "cogging/basis/b_spline.hpp"

namespace cogging {

/// The regressor S_r(x) of eq. 7: which force shapes the cogging is made of, without their amplitudes.
///
/// Term i is a sine and a cosine of 2 pi harmonic_i x / pitch, or of 2 pi x / period_i. The coefficients A_r
/// are stored as in the paper: one row a control point, in it sine and cosine of each term in turn.
class SplineHarmonics {
 public:
  static constexpr int terms_max = 32;

  /// The k active control points and the 2n harmonic values at a position: S_r without its zeros.
  template <class Scalar>
  struct Active {
    BSpline::Active<Scalar> spline;
    std::array<Scalar, 2 * terms_max> harmonic;
  };

  SplineHarmonics() = default;

  static SplineHarmonics of_harmonics(double pitch, std::vector<int> harmonics, BSpline spline) {
    require_positive("pitch", pitch);
    SplineHarmonics basis;
    for (int harmonic : harmonics) require(harmonic >= 1, "harmonics", "each must be at least 1", harmonic);
    basis.check_terms(harmonics.size(), "harmonics");
    basis.require_distinct(harmonics, "harmonics");
    basis.spline_ = spline;
    basis.wavenumber_ = 2.0 * std::numbers::pi / pitch;
    basis.pitch_ = pitch;
    for (int harmonic : harmonics) basis.wavenumbers_.push_back(basis.wavenumber_ * harmonic);
    basis.harmonics_ = std::move(harmonics);
    basis.plan_powers();
    return basis;
  }

  static SplineHarmonics of_periods(std::vector<double> periods, BSpline spline) {
    SplineHarmonics basis;
    for (double period : periods) require_positive("periods", period);
    basis.check_terms(periods.size(), "periods");
    basis.require_distinct(periods, "periods");
    basis.spline_ = spline;
    for (double period : periods) basis.wavenumbers_.push_back(2.0 * std::numbers::pi / period);
    basis.periods_ = std::move(periods);
    return basis;
  }

  int terms() const { return static_cast<int>(wavenumbers_.size()); }
  int columns() const { return 2 * terms(); }
  int coefficients() const { return spline_.control_points() * columns(); }
  double pitch() const { return pitch_; }
  const BSpline& spline() const { return spline_; }
  const std::vector<int>& harmonics() const { return harmonics_; }
  const std::vector<double>& periods() const { return periods_; }
  const std::vector<double>& wavenumbers() const { return wavenumbers_; }
  bool empty() const { return wavenumbers_.empty(); }

  template <class Scalar>
  void evaluate(const Scalar& position, Active<Scalar>& active) const {
    spline_.evaluate(position, active.spline);
    evaluate_harmonics(position, active.harmonic);
  }

  /// A_r^T S_r(x), in the unit of the coefficients.
  template <class Scalar>
  Scalar value(const Active<Scalar>& active, const Scalar* coefficients) const {
    Scalar sum = 0.0;
    for (int j = 0; j < spline_.order(); ++j)
      sum += active.spline.weight[j] * row(active, coefficients, j, active.harmonic.data());
    return sum;
  }

  template <class Scalar>
  Scalar value(const Scalar& position, const Scalar* coefficients) const {
    Active<Scalar> active;
    evaluate(position, active);
    return value(active, coefficients);
  }

  /// d/dx of value.
  template <class Scalar>
  Scalar slope(const Scalar& position, const Scalar* coefficients) const {
    Active<Scalar> active;
    std::array<Scalar, BSpline::order_max> weight_slope;
    spline_.evaluate(position, active.spline, weight_slope);
    evaluate_harmonics(position, active.harmonic);
    std::array<Scalar, 2 * terms_max> harmonic_slope;
    for (int i = 0; i < terms(); ++i) {
      harmonic_slope[2 * i] = active.harmonic[2 * i + 1] * wavenumbers_[i];
      harmonic_slope[2 * i + 1] = active.harmonic[2 * i] * (-wavenumbers_[i]);
    }
    Scalar sum = 0.0;
    for (int j = 0; j < spline_.order(); ++j)
      sum += weight_slope[j] * row(active, coefficients, j, active.harmonic.data()) +
             active.spline.weight[j] * row(active, coefficients, j, harmonic_slope.data());
    return sum;
  }

 private:
  struct Product {
    int left, right, term;  // powers left + right; term >= 0 stores it
  };

  template <class Scalar>
  Scalar row(const Active<Scalar>& active, const Scalar* coefficients, int j, const Scalar* harmonic) const {
    Scalar sum = 0.0;
    const auto start = (active.spline.first + j) * columns();
    for (int q = 0; q < columns(); ++q) sum += gather(coefficients + q, start) * harmonic[q];
    return sum;
  }

  template <class Scalar>
  void evaluate_harmonics(const Scalar& position, std::array<Scalar, 2 * terms_max>& harmonic) const {
    if (!periods_.empty()) {
      for (int i = 0; i < terms(); ++i) sin_cos(position * wavenumbers_[i], harmonic[2 * i], harmonic[2 * i + 1]);
      return;
    }
    if (harmonics_.empty()) return;
    // One sine and cosine; the other harmonics are products of lower powers of exp(i angle).
    std::array<Scalar, 4 * terms_max> sine, cosine;
    sin_cos(position * wavenumber_, sine[0], cosine[0]);
    if (first_term_ >= 0) {
      harmonic[2 * first_term_] = sine[0];
      harmonic[2 * first_term_ + 1] = cosine[0];
    }
    int power = 0;
    for (const Product& product : products_) {
      ++power;
      const int a = product.left, b = product.right;
      sine[power] = sine[a] * cosine[b] + cosine[a] * sine[b];
      cosine[power] = cosine[a] * cosine[b] - sine[a] * sine[b];
      if (product.term >= 0) {
        harmonic[2 * product.term] = sine[power];
        harmonic[2 * product.term + 1] = cosine[power];
      }
    }
  }

  void check_terms(std::size_t count, std::string_view name) const {
    require(count >= 1 && count <= terms_max, name, "must list 1 to 32 terms", static_cast<double>(count));
  }

  template <class Value>
  void require_distinct(std::vector<Value> values, std::string_view name) const {
    std::sort(values.begin(), values.end());
    const auto twice = std::adjacent_find(values.begin(), values.end());
    if (twice != values.end()) require(false, name, "each may stand once", static_cast<double>(*twice));
  }

  // A short addition chain over the harmonics: each power is the sum of two that are already there.
  void plan_powers() {
    std::vector<int> powers{1};
    const auto index_of = [&](int power) {
      const auto found = std::find(powers.begin(), powers.end(), power);
      return found == powers.end() ? -1 : static_cast<int>(found - powers.begin());
    };
    const auto add = [&](auto&& self, int power) -> void {
      if (index_of(power) >= 0) return;
      int left = -1;
      for (int candidate : powers)
        if (index_of(power - candidate) >= 0) left = candidate;
      if (left < 0) {
        left = power / 2;
        self(self, left);
        self(self, power - left);
      }
      products_.push_back({index_of(left), index_of(power - left), -1});
      powers.push_back(power);
    };
    std::vector<int> ascending = harmonics_;
    std::sort(ascending.begin(), ascending.end());
    for (int harmonic : ascending) add(add, harmonic);
    require(powers.size() <= 4 * terms_max, "harmonics", "need too many products of powers",
            static_cast<double>(powers.size()));
    for (std::size_t i = 0; i < harmonics_.size(); ++i) {
      const int power = index_of(harmonics_[i]);
      if (power == 0)
        first_term_ = static_cast<int>(i);
      else
        products_[power - 1].term = static_cast<int>(i);
    }
  }

  BSpline spline_;
  double pitch_ = 0.0;
  double wavenumber_ = 0.0;
  std::vector<int> harmonics_;
  std::vector<double> periods_;
  std::vector<double> wavenumbers_;
  std::vector<Product> products_;
  int first_term_ = -1;
};

/// A basis with its amplitudes: a cogging force F_cogging(x) that opposes the command.
template <class Scalar = double>
class CoggingModel {
 public:
  CoggingModel() = default;

  /// coefficients: one row a control point, in it sine and cosine of each term in turn (eq. 7).
  CoggingModel(SplineHarmonics basis, std::vector<Scalar> coefficients)
      : basis_(std::move(basis)), coefficients_(std::move(coefficients)) {
    require(static_cast<int>(coefficients_.size()) == basis_.coefficients(), "coefficients",
            "must hold control points times 2 terms = " + format(basis_.coefficients()) + " values",
            static_cast<double>(coefficients_.size()));
    for (const Scalar& value : coefficients_)
      if (!all_finite(value)) refuse("coefficients", "must be finite numbers", "a NaN or an infinity");
  }

  const SplineHarmonics& basis() const { return basis_; }
  const std::vector<Scalar>& coefficients() const { return coefficients_; }

  Scalar force(const Scalar& position) const {
    return basis_.empty() ? Scalar(0.0) : basis_.value(position, coefficients_.data());
  }
  Scalar slope(const Scalar& position) const {
    return basis_.empty() ? Scalar(0.0) : basis_.slope(position, coefficients_.data());
  }

 private:
  SplineHarmonics basis_;
  std::vector<Scalar> coefficients_;
};

}  // namespace cogging
