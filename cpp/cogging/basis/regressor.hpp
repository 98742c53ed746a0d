#pragma once
// The rows of a linear fit of amplitudes: what each coefficient of a spline, or of a cogging model, counts at a
// position.

#include <span>

#include "cogging/basis/b_spline.hpp"
#include "cogging/basis/spline_harmonics.hpp"
#include "cogging/require.hpp"

namespace cogging {

namespace detail {

/// Writes a matrix row by row: write(position, row) puts what is not 0 into a row of zeros.
template <class Write>
void write_rows(std::span<const double> positions, int columns, std::span<double> matrix, const Write& write) {
  const auto width = static_cast<std::size_t>(columns);
  require(matrix.size() == positions.size() * width, "matrix",
          "must have a row for each position and " + format(columns) + " columns", matrix.size());
  std::fill(matrix.begin(), matrix.end(), 0.0);
  for (std::size_t i = 0; i < positions.size(); ++i) write(positions[i], matrix.subspan(i * width, width));
}

}  // namespace detail

/// Calls entry(column, value) for each coefficient that acts at a position (m), in the order of the columns.
template <class Entry>
void for_each_active(const SplineHarmonics& basis, double position, const Entry& entry) {
  SplineHarmonics::Active<double> active;
  basis.evaluate(position, active);
  for (int j = 0; j < basis.spline().order(); ++j)
    for (int c = 0; c < basis.columns(); ++c)
      entry((active.spline.first + j) * basis.columns() + c, active.spline.weight[j] * active.harmonic[c]);
}

/// N_{c,k}(x) (Lu et al. 2008, eq. 6) at positions, m: (positions, control points), row by row; all of it is written.
inline void write_design_matrix(const BSpline& spline, std::span<const double> positions, std::span<double> matrix) {
  detail::write_rows(positions, spline.control_points(), matrix, [&](double position, std::span<double> row) {
    BSpline::Active<double> active;
    spline.evaluate(position, active);
    for (int j = 0; j < spline.order(); ++j) row[active.first + j] = active.weight[j];
  });
}

/// S_r(x) (Lu et al. 2008, eq. 7) at positions, m: (positions, coefficients), row by row; all of it is written.
inline void write_regressor(const SplineHarmonics& basis, std::span<const double> positions, std::span<double> matrix) {
  detail::write_rows(positions, basis.coefficients(), matrix, [&](double position, std::span<double> row) {
    for_each_active(basis, position, [&](int column, double value) { row[column] = value; });
  });
}

/// Index of the first coefficient that acts at a position (m), and the values of those that do, which stand together.
inline std::pair<int, std::vector<double>> active_regressor(const SplineHarmonics& basis, double position) {
  std::pair<int, std::vector<double>> result{-1, {}};
  for_each_active(basis, position, [&](int column, double value) {
    if (result.second.empty()) result.first = column;
    result.second.push_back(value);
  });
  return result;
}

}  // namespace cogging
