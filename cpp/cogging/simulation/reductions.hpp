#pragma once
// What a run may be asked for beside the papers' indexes, made on the way without keeping its rows.

#include <array>
#include <bit>
#include <variant>

#include "cogging/require.hpp"
#include "cogging/scalar.hpp"
#include "cogging/simulation/performance.hpp"

namespace cogging {

/// One number of a run.
struct Reduction {
  std::string quantity = "error";  // "error" (m, reading minus reference), "command" (V), "true_error" (m)
  std::string kind = "rms";        // "max" (of the size), "rms", "quantile" (of the size), "final", "tone", "wave"
  double at = 0.0;                 // quantile: 0 to 1; tone: frequency, Hz; wave: period along the reading, m

  void validate() const {
    if (quantity != "error" && quantity != "command" && quantity != "true_error")
      refuse("quantity", "must be error, command or true_error", quantity);
    if (kind == "max" || kind == "rms" || kind == "final") return;
    if (kind == "quantile")
      require(at >= 0.0 && at <= 1.0, "quantile", "must be from 0 to 1", at);
    else if (kind == "tone")
      require_positive("frequency", at);
    else if (kind == "wave")
      require_positive("period", at);
    else
      refuse("kind", "must be max, rms, quantile, final, tone or wave", kind);
  }
};

/// A row as reductions see it.
template <class Scalar>
struct ReducedRow {
  double time;             // s
  const Scalar& position;  // m, reading
  const Scalar& value;     // of the quantity
};

/// The largest size of the values, the root of their mean square, or the last of them.
template <class Scalar>
class PlainReduction {
 public:
  PlainReduction(const std::string& kind, std::size_t rows) : kind_(kind), rows_(rows) {}

  void row(const ReducedRow<Scalar>& row) {
    largest_ = larger(largest_, abs(row.value));
    squares_ += row.value * row.value;
    last_ = row.value;
  }
  double of_lane(std::size_t i) const {
    if (kind_ == "rms") return std::sqrt(lane(squares_, i) / static_cast<double>(rows_));
    return lane(kind_ == "max" ? largest_ : last_, i);
  }

 private:
  std::string kind_;
  std::size_t rows_;
  Scalar largest_ = 0.0, squares_ = 0.0, last_ = 0.0;
};

/// The quantile of |value|, linear between the two values beside it. Up to 2^16 rows it is exact: their sizes are kept
/// while the run lasts (half a MB). Of longer runs a histogram is kept whose cells are 1/1024 of an octave wide, from
/// 2^-60 to 2^20, so that the quantile is within 0.07 % (sizes below 1e-18 count as 0).
template <class Scalar>
class SizeQuantile {
 public:
  static constexpr std::size_t exact_most = std::size_t{1} << 16;

  SizeQuantile(double fraction, std::size_t rows) : fraction_(fraction), rows_(rows) {
    if (rows <= exact_most)
      sizes_.reserve(rows);
    else
      cells_.resize(lanes_of<Scalar> * cells_each);
  }

  void row(const ReducedRow<Scalar>& row) {
    if (cells_.empty()) {
      sizes_.push_back(abs(row.value));
      return;
    }
    for (std::size_t i = 0; i < lanes_of<Scalar>; ++i) ++cells_[i * cells_each + cell_of(std::abs(lane(row.value, i)))];
  }

  double of_lane(std::size_t i) const {
    const double place = fraction_ * static_cast<double>(rows_ - 1);
    const auto below = whole_part<std::size_t>(place);
    const double low = of_rank(i, below);
    const double high = below + 1 < rows_ ? of_rank(i, below + 1) : low;
    return low + (place - static_cast<double>(below)) * (high - low);
  }

 private:
  static constexpr int parts = 10;  // bits of the mantissa that tell cells apart
  static constexpr std::uint64_t lowest_octave = 1023 - 60, octaves = 80;
  static constexpr std::size_t cells_each = std::size_t{octaves << parts} + 1;

  static std::size_t cell_of(double size) {
    const std::uint64_t cell = std::bit_cast<std::uint64_t>(size) >> (52 - parts);
    constexpr std::uint64_t zero = (lowest_octave << parts) - 1;  // all that is smaller
    return static_cast<std::size_t>(std::min(std::max(cell, zero) - zero, std::uint64_t{cells_each - 1}));
  }
  static double middle_of(std::size_t cell) {
    if (cell == 0) return 0.0;
    const std::uint64_t bits = ((lowest_octave << parts) - 1 + cell) << (52 - parts);
    return std::bit_cast<double>(bits | (std::uint64_t{1} << (51 - parts)));
  }

  double of_rank(std::size_t i, std::size_t rank) const {
    if (cells_.empty()) {
      std::vector<double> sizes;
      sizes.reserve(sizes_.size());
      for (const Scalar& size : sizes_) sizes.push_back(lane(size, i));
      std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(rank), sizes.end());
      return sizes[rank];
    }
    std::size_t cell = 0;
    for (std::size_t passed = cells_[i * cells_each]; passed <= rank; passed += cells_[i * cells_each + cell]) ++cell;
    return middle_of(cell);
  }

  double fraction_;
  std::size_t rows_;
  std::vector<Scalar> sizes_;
  std::vector<std::uint32_t> cells_;  // rows in each, lane by lane
};

/// The amplitude a of the best offset + a sin(phase + b), by least squares; the phase turns with time, or with the
/// reading along the travel. NaN where the rows do not tell the three apart: an axis that stands still, a period far
/// longer than the motion.
template <class Scalar>
class WaveAmplitude {
 public:
  WaveAmplitude(bool along_travel, double turns_per_unit) : along_travel_(along_travel), turns_(turns_per_unit) {}

  void row(const ReducedRow<Scalar>& row) {
    Scalar sine, cosine;
    sin_cos(two_pi * (turns_ * (along_travel_ ? row.position : Scalar(row.time))), sine, cosine);
    const std::array<Scalar, 3> basis{Scalar(1.0), sine, cosine};
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b <= a; ++b) products_[a][b] += basis[a] * basis[b];
      sums_[a] += basis[a] * row.value;
    }
  }

  double of_lane(std::size_t i) const {
    const auto product = [&](std::size_t a, std::size_t b) { return lane(products_[a][b], i); };
    const double rows = product(0, 0);
    const double s = product(1, 0) / rows, c = product(2, 0) / rows, mean = lane(sums_[0], i) / rows;
    const double ss = product(1, 1) / rows - s * s, cc = product(2, 2) / rows - c * c,
                 sc = product(2, 1) / rows - s * c;
    const double sx = lane(sums_[1], i) / rows - s * mean, cx = lane(sums_[2], i) / rows - c * mean;
    const double determinant = ss * cc - sc * sc;
    if (!(determinant > told_apart)) return std::numeric_limits<double>::quiet_NaN();
    const double sine = cc * sx - sc * cx, cosine = ss * cx - sc * sx;
    return std::sqrt(sine * sine + cosine * cosine) / determinant;
  }

 private:
  static constexpr double two_pi = 6.283185307179586476925;
  static constexpr double told_apart = 1e-9;  // 0.25 over whole turns; roundings are 1e-15
  bool along_travel_;
  double turns_;
  std::array<std::array<Scalar, 3>, 3> products_{};
  std::array<Scalar, 3> sums_{};
};

template <class Scalar>
using AnyReduction = std::variant<PlainReduction<Scalar>, SizeQuantile<Scalar>, WaveAmplitude<Scalar>>;

/// Ready for so many rows.
template <class Scalar>
AnyReduction<Scalar> make_reduction(const Reduction& asked, std::size_t rows) {
  asked.validate();
  if (asked.kind == "quantile") return SizeQuantile<Scalar>(asked.at, rows);
  if (asked.kind == "tone") return WaveAmplitude<Scalar>(false, asked.at);
  if (asked.kind == "wave") return WaveAmplitude<Scalar>(true, 1.0 / asked.at);
  return PlainReduction<Scalar>(asked.kind, rows);
}

}  // namespace cogging
