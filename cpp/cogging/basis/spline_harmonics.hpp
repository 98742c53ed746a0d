#pragma once
// The cogging model: harmonics of the magnet pitch whose amplitudes are B-splines (Lu et al. 2008, eq. 3 to
// 7).

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numbers>
#include <utility>
#include <vector>

#include "cogging/basis/b_spline.hpp"
#include "cogging/register_types.hpp"

namespace cogging {

/// The regressor S_r(x) of eq. 7: which force shapes the cogging is made of, without their amplitudes.
///
/// Term i is a sine and a cosine of 2 pi harmonic_i x / pitch, or of 2 pi x / period_i. The coefficients A_r
/// are stored as in the paper: one row a control point, in it sine and cosine of each term in turn.
class SplineHarmonics {
 public:
  static constexpr int terms_max = 32, powers_max = 128, terms_unrolled = 6;
  static constexpr double coefficients_max = 1e7;  // 80 MB of them, and far below what an index can count

  /// The k active control points and the 2n harmonic values at a position: S_r without its zeros. Behind the
  /// harmonics stand the powers that are none but a step on the way to one.
  template <class Scalar>
  struct Active {
    BSpline::Active<Scalar> spline;
    std::array<Scalar, 2 * powers_max> harmonic;
  };

  /// A position and the sine and cosine of 2 pi x / pitch there, of which all harmonics are made.
  template <class Scalar>
  struct Wave {
    Scalar position = 0.0, sine = 0.0, cosine = 0.0;
  };

  SplineHarmonics() = default;

  static SplineHarmonics of_harmonics(double pitch, std::vector<int> harmonics, BSpline spline) {
    require_period("pitch", pitch);
    for (int harmonic : harmonics) {
      require(harmonic >= 1, "harmonics", "each must be at least 1", harmonic);
      require(pitch / harmonic >= 1e-9, "harmonics", "each must leave a period of at least 1e-9", harmonic);
    }
    SplineHarmonics basis(spline, harmonics, "harmonics");
    basis.wavenumber_ = 2.0 * std::numbers::pi / pitch;
    basis.pitch_ = pitch;
    for (int harmonic : harmonics) basis.wavenumbers_.push_back(basis.wavenumber_ * harmonic);
    basis.harmonics_ = std::move(harmonics);
    basis.plan_powers();
    return basis;
  }

  static SplineHarmonics of_periods(std::vector<double> periods, BSpline spline) {
    for (double period : periods) require_period("periods", period);
    SplineHarmonics basis(spline, periods, "periods");
    for (double period : periods) basis.wavenumbers_.push_back(2.0 * std::numbers::pi / period);
    basis.periods_ = std::move(periods);
    return basis;
  }

  /// Refuses more coefficients, control points times sine and cosine of each term, than a model may have.
  static void require_coefficients(std::string_view name, int control_points, std::size_t terms) {
    const double columns = 2.0 * static_cast<double>(terms);
    require(columns * control_points <= coefficients_max, name,
            "must be at most " + format(coefficients_max) +
                " / twice the terms = " + format(std::floor(coefficients_max / columns)),
            control_points);
  }

  int terms() const { return columns_ / 2; }
  int columns() const { return columns_; }  // twice the terms
  int coefficients() const { return spline_.control_points() * columns(); }
  double pitch() const { return pitch_; }
  const BSpline& spline() const { return spline_; }
  const std::vector<int>& harmonics() const { return harmonics_; }
  const std::vector<double>& periods() const { return periods_; }
  const std::vector<double>& wavenumbers() const { return wavenumbers_; }
  bool empty() const { return columns_ == 0; }

  template <class Scalar>
  COGGING_INLINE void evaluate(const Scalar& position, Active<Scalar>& active) const {
    spline_.evaluate(position, active.spline);
    evaluate_harmonics(wave_at(position), active.harmonic);
  }

  template <class Scalar>
  COGGING_INLINE Wave<Scalar> wave_at(const Scalar& position) const {
    Wave<Scalar> wave{position};
    if (!harmonics_.empty()) sin_cos(position * wavenumber_, wave.sine, wave.cosine);
    return wave;
  }

  /// The same from the wave of another position, which costs less where they are near.
  template <class Scalar>
  COGGING_INLINE Wave<Scalar> wave_at(const Scalar& position, const Wave<Scalar>& other) const {
    Wave<Scalar> wave{position, other.sine, other.cosine};
    const Scalar turn = (position - other.position) * wavenumber_;
    const auto near = abs(turn) <= elementary::small_turn;
    elementary::turn_a_little(turn, wave.sine, wave.cosine);
    if (all(near)) [[likely]]
      return wave;
    const Wave<Scalar> own = wave_at(position);
    return {position, select(near, wave.sine, own.sine), select(near, wave.cosine, own.cosine)};
  }

  /// A_r^T S_r(x), in the unit of the coefficients.
  template <class Scalar>
  COGGING_INLINE Scalar value(const Active<Scalar>& active, const Scalar* coefficients) const {
    return spline_.with_order([&](auto order) COGGING_INLINE_LAMBDA { return value(order, active, coefficients); });
  }

  /// In one go, the harmonics first: the weights of the control points then stay in registers.
  template <class Scalar>
  COGGING_INLINE Scalar value(const Wave<Scalar>& wave, const Scalar* coefficients) const {
    return spline_.with_order([&](auto order) COGGING_INLINE_LAMBDA {
      Active<Scalar> active;
      evaluate_harmonics(wave, active.harmonic);
      spline_.evaluate(order, wave.position, active.spline);
      return value(order, active, coefficients);
    });
  }

  /// Adds `step` times S_r(x) to the coefficients, each kept within the bounds.
  template <class Scalar>
  void move(Scalar* coefficients, const Active<Scalar>& active, const Scalar& step, double minimum,
            double maximum) const {
    spline_.with_order([&](auto order) COGGING_INLINE_LAMBDA {
      std::array<Scalar, BSpline::order_max> steps;
      for (int j = 0; j < order; ++j) steps[j] = step * active.spline.weight[j];
      const int columns = this->columns();
#if defined(__GNUC__)
      if constexpr (std::is_same_v<Scalar, double>) {
        const Pair lower{minimum, minimum}, upper{maximum, maximum};
        double* row = coefficients + active.spline.first * columns;
        for (int q = 0; q < columns; q += 2) {
          const Pair harmonic = pair_at(active.harmonic.data() + q);
          for (int j = 0; j < order; ++j) {
            const Pair moved = pair_at(row + j * columns + q) + steps[j] * harmonic;
            const Pair raised = lower > moved ? lower : moved;
            const Pair kept = upper < raised ? upper : raised;
            std::memcpy(row + j * columns + q, &kept, sizeof(kept));
          }
        }
        return;
      }
#endif
      with_index(active.spline.first * columns, [&](const auto& start) COGGING_INLINE_LAMBDA {
        for (int j = 0; j < order; ++j)
          for (int q = 0; q < columns; ++q) {
            Scalar* place = coefficients + j * columns + q;
            const Scalar moved = gather(place, start) + steps[j] * active.harmonic[q];
            scatter(place, start, clamp(moved, Scalar(minimum), Scalar(maximum)));
          }
      });
    });
  }

  /// d/dx of value.
  template <class Scalar>
  Scalar slope(const Scalar& position, const Scalar* coefficients) const {
    Active<Scalar> active;
    std::array<Scalar, BSpline::order_max> weight_slope;
    spline_.evaluate(position, active.spline, weight_slope);
    evaluate_harmonics(wave_at(position), active.harmonic);
    std::array<Scalar, 2 * terms_max> harmonic_slope;
    for (int i = 0; i < terms(); ++i) {
      harmonic_slope[2 * i] = active.harmonic[2 * i + 1] * wavenumbers_[i];
      harmonic_slope[2 * i + 1] = active.harmonic[2 * i] * (-wavenumbers_[i]);
    }
    return spline_.with_order([&](auto order) COGGING_INLINE_LAMBDA {
      return combine(order, active.spline.first, weight_slope.data(), active.harmonic.data(), coefficients) +
             combine(order, active.spline.first, active.spline.weight.data(), harmonic_slope.data(), coefficients);
    });
  }

 private:
  struct Product {
    std::ptrdiff_t factor, place;  // columns: the power at `place` is the last one plus the one at `factor`
  };

  template <class Order, class Scalar>
  COGGING_INLINE Scalar value(Order order, const Active<Scalar>& active, const Scalar* coefficients) const {
    return combine(order, active.spline.first, active.spline.weight.data(), active.harmonic.data(), coefficients);
  }

#if defined(__GNUC__)
  using Pair = RegisterTypes<2>::Numbers;
  COGGING_INLINE static Pair pair_at(const double* place) {
    Pair pair;
    std::memcpy(&pair, place, sizeof(pair));
    return pair;
  }
#endif

  // By one store where they are read by one load: a load waits for two stores until both have left the processor.
  template <class Scalar>
  COGGING_INLINE static void put(Scalar* place, const Scalar& sine, const Scalar& cosine) {
#if defined(__GNUC__)
    if constexpr (std::is_same_v<Scalar, double>) {
      const Pair pair{sine, cosine};
      std::memcpy(place, &pair, sizeof(pair));
      return;
    }
#endif
    place[0] = sine;
    place[1] = cosine;
  }

  // sum_q (sum_j weight_j A_jq) harmonic_q over the active control points j and the columns q.
  template <class Order, class Scalar, class Index>
  COGGING_INLINE Scalar combine(Order order, const Index& first, const Scalar* weight, const Scalar* harmonic,
                                const Scalar* coefficients) const {
#if defined(__GNUC__)
    if constexpr (std::is_same_v<Scalar, double>) {  // sine and cosine of a term side by side, in the same order
      const std::ptrdiff_t columns = this->columns();
      const double *row_end = coefficients + (first + 1) * columns, *harmonic_end = harmonic + columns;
      Pair total{};
      const auto add = [&](std::ptrdiff_t q) COGGING_INLINE_LAMBDA {
        Pair sum = weight[0] * pair_at(row_end + q);
        for (int j = 1; j < order; ++j) sum += weight[j] * pair_at(row_end + j * columns + q);
        total += sum * pair_at(harmonic_end + q);
      };
      std::ptrdiff_t q = -columns;
      for (; q < -2 * terms_unrolled; q += 2) add(q);
      [&]<int... i>(std::integer_sequence<int, i...>) COGGING_INLINE_LAMBDA {  // the last at places that do not change
        ((q <= 2 * (i - terms_unrolled) ? add(2 * (i - terms_unrolled)) : void()), ...);
      }(std::make_integer_sequence<int, terms_unrolled>());
      return total[0] + total[1];
    }
#endif
    const int columns = this->columns();
    return with_index(first * columns, [&](const auto& start) COGGING_INLINE_LAMBDA {
      const auto amplitude = [&](int q) COGGING_INLINE_LAMBDA {
        Scalar sum = weight[0] * gather(coefficients + q, start);
        for (int j = 1; j < order; ++j) sum += weight[j] * gather(coefficients + j * columns + q, start);
        return sum;
      };
      Scalar sines = 0.0, cosines = 0.0;
      for (int q = 0; q < columns; q += 2) {
        sines += amplitude(q) * harmonic[q];
        cosines += amplitude(q + 1) * harmonic[q + 1];
      }
      return sines + cosines;
    });
  }

  template <class Scalar>
  COGGING_INLINE void evaluate_harmonics(const Wave<Scalar>& wave, std::array<Scalar, 2 * powers_max>& harmonic) const {
    if (harmonics_.empty()) {
      for (int i = 0; i < terms(); ++i) sin_cos(wave.position * wavenumbers_[i], harmonic[2 * i], harmonic[2 * i + 1]);
      return;
    }
    // One sine and cosine; the other harmonics are products of lower powers of exp(i angle). The last power
    // stays at hand: through memory it would come back too late for the next.
    Scalar sine = wave.sine, cosine = wave.cosine;
    std::ptrdiff_t last = first_power_;
    put(harmonic.data() + last, sine, cosine);
    for (const auto& [factor, place] : products_) {
      const Scalar s = sine, c = cosine;
      if (factor == last) {
        sine = 2.0 * s * c;
        cosine = c * c - s * s;
      } else {
        sine = s * harmonic[factor + 1] + c * harmonic[factor];
        cosine = c * harmonic[factor + 1] - s * harmonic[factor];
      }
      last = place;
      put(harmonic.data() + last, sine, cosine);
    }
  }

  // Without its wave numbers; `terms` are its harmonics or periods.
  template <class Term>
  SplineHarmonics(const BSpline& spline, std::vector<Term> terms, std::string_view name)
      : spline_(spline), columns_(2 * static_cast<int>(terms.size())) {
    require(!terms.empty() && terms.size() <= terms_max, name, "must list 1 to 32 terms", terms.size());
    std::sort(terms.begin(), terms.end());
    const auto twice = std::adjacent_find(terms.begin(), terms.end());
    if (twice != terms.end()) require(false, name, "each may stand once", *twice);
    require_coefficients("control_points", spline.control_points(), terms.size());
  }

  // A short addition chain over the harmonics: each power is the last one plus one that is already there.
  void plan_powers() {
    std::vector<int> powers{1}, places = harmonics_;
    const auto place_of = [&](int power) {
      const std::ptrdiff_t place = std::find(places.begin(), places.end(), power) - places.begin();
      if (place == std::ssize(places)) places.push_back(power);
      return 2 * place;
    };
    first_power_ = place_of(1);
    std::vector<int> ascending = harmonics_;
    std::sort(ascending.begin(), ascending.end());
    for (int harmonic : ascending)
      while (powers.back() < harmonic) {
        const int missing = harmonic - powers.back();
        const int factor = *std::prev(std::upper_bound(powers.begin(), powers.end(), missing));
        powers.push_back(powers.back() + factor);
        products_.push_back({place_of(factor), place_of(powers.back())});
      }
    require(places.size() <= powers_max, "harmonics", "need too many products of powers", places.size());
  }

  BSpline spline_;
  double pitch_ = 0.0;
  double wavenumber_ = 0.0;
  int columns_ = 0;
  std::vector<int> harmonics_;
  std::vector<double> periods_;
  std::vector<double> wavenumbers_;
  std::vector<Product> products_;
  std::ptrdiff_t first_power_ = 0;  // column of the sine of 2 pi x / pitch
};

/// A basis with its amplitudes: a cogging force F_cogging(x) that opposes the command.
template <class Scalar = double>
class CoggingModel {
 public:
  CoggingModel() = default;

  /// coefficients: one row a control point, in it sine and cosine of each term in turn (eq. 7).
  CoggingModel(SplineHarmonics basis, std::vector<Scalar> coefficients)
      : basis_(std::move(basis)), coefficients_(std::move(coefficients)) {
    require(std::ssize(coefficients_) == basis_.coefficients(), "coefficients",
            "must hold control points times 2 terms = " + format(basis_.coefficients()) + " values",
            coefficients_.size());
    for (const Scalar& value : coefficients_)
      if (!all_finite(value)) refuse("coefficients", "must be finite numbers", "a NaN or an infinity");
  }

  const SplineHarmonics& basis() const { return basis_; }
  const std::vector<Scalar>& coefficients() const { return coefficients_; }

  /// At a wave of its basis.
  COGGING_INLINE Scalar force(const SplineHarmonics::Wave<Scalar>& wave) const {
    return basis_.empty() ? Scalar(0.0) : basis_.value(wave, coefficients_.data());
  }
  COGGING_INLINE Scalar force(const Scalar& position) const { return force(basis_.wave_at(position)); }
  Scalar slope(const Scalar& position) const {
    return basis_.empty() ? Scalar(0.0) : basis_.slope(position, coefficients_.data());
  }

  /// Where its amplitudes have a kink or a jump, m: the knots of B-splines of order 1 and 2.
  std::vector<double> kinks() const {
    const BSpline& spline = basis_.spline();
    std::vector<double> places;
    if (basis_.empty() || spline.constant() || spline.order() > 2) return places;
    for (int i = 0; i <= spline.spans(); ++i) places.push_back(spline.origin() + i * spline.pitch());
    return places;
  }

  struct Wave {
    double amplitude, wavenumber;  // unit of the coefficients; rad/m
  };

  /// How large each term may become, and how quickly it changes along the travel: its own wave and that of the knots.
  std::vector<Wave> waves() const {
    std::vector<Wave> list;
    const double along_knots = basis_.spline().constant() ? 0.0 : 2.0 / basis_.spline().pitch();
    for (double wavenumber : basis_.wavenumbers()) list.push_back({0.0, wavenumber + along_knots});
    for (std::size_t i = 0; i < coefficients_.size(); ++i) {  // B-splines do not exceed their coefficients
      double& size = list[i % static_cast<std::size_t>(basis_.columns()) / 2].amplitude;
      size = std::max(size, 2.0 * largest(abs(coefficients_[i])));
    }
    return list;
  }

 private:
  SplineHarmonics basis_;
  std::vector<Scalar> coefficients_;
};

}  // namespace cogging
