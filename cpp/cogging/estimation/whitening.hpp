#pragma once
// An autoregressive filter that makes a correlated residual white.

#include <array>
#include <span>

#include "cogging/interruption.hpp"
#include "cogging/require.hpp"

/// A loop over rows, compiled for each width of the machine's registers; which is taken is found out when the program
/// starts. The bits are the same: no operation is contracted, and each row keeps the order of its sums.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define COGGING_EVERY_WIDTH __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define COGGING_EVERY_WIDTH
#endif

namespace cogging {

namespace detail {

/// sum_k r_k r_(k-i) for i from 0 to lags - 1.
inline std::vector<double> products_by_lag(const std::vector<double>& row, std::size_t lags, StopCheck& stop) {
  const std::size_t rows = row.size();
  std::vector<double> sums(lags);
  constexpr std::size_t together = 8;  // lags whose sums grow side by side: one waits for the other's additions
  for (std::size_t first = 0; first < lags; first += together) {
    stop.ask();
    std::array<double, together> sum{};
    const std::size_t last = first + together - 1;
    for (std::size_t k = first; k < std::min(last, rows); ++k)
      for (std::size_t i = 0; i <= k - first; ++i) sum[i] += row[k] * row[k - first - i];
    for (std::size_t k = last; k < rows; ++k)
      for (std::size_t i = 0; i < together; ++i) sum[i] += row[k] * row[k - first - i];
    std::copy_n(sum.begin(), std::min(together, lags - first), sums.begin() + static_cast<std::ptrdiff_t>(first));
  }
  return sums;
}

/// Levinson's recursion: the coefficients that Yule and Walker's equations give for covariances of lag 0 to their
/// number.
inline std::vector<double> levinson(const std::vector<double>& covariance, StopCheck& stop) {
  const int order = static_cast<int>(covariance.size()) - 1;
  std::vector<double> a(static_cast<std::size_t>(order), 0.0), previous;
  double power = covariance[0];
  for (int m = 0; m < order; ++m) {
    stop.row();
    double reflection = covariance[static_cast<std::size_t>(m) + 1];
    for (int i = 0; i < m; ++i) reflection -= a[i] * covariance[static_cast<std::size_t>(m - i)];
    reflection /= power;
    previous = a;
    for (int i = 0; i < m; ++i) a[i] = previous[i] - reflection * previous[m - 1 - i];
    a[m] = reflection;
    power *= 1.0 - reflection * reflection;
    if (power <= 0.0) break;
  }
  return a;
}

/// Takes the lags a[0] to a[3] of a row from `white`, rows of it from 0 to count - 1; row[k - 1] is that before row k.
COGGING_EVERY_WIDTH inline void take_four_lags(double* white, const double* row, const double* a,
                                               std::ptrdiff_t count) {
  const double a0 = a[0], a1 = a[1], a2 = a[2], a3 = a[3];
  for (std::ptrdiff_t k = 0; k < count; ++k)
    white[k] -= a0 * row[k - 1] + a1 * row[k - 2] + a2 * row[k - 3] + a3 * row[k - 4];
}

}  // namespace detail

/// Coefficients a of e_k = r_k - sum_i a_i r_(k-i) with the least rms of e (Yule and Walker's equations, solved by
/// Levinson's recursion). Only pairs of rows that both count (1, else 0) are looked at.
inline std::vector<double> autoregression(std::span<const double> residual, std::span<const double> counts, int order,
                                          StopRequest* request = nullptr) {
  const std::size_t rows = residual.size();
  require(order >= 1 && static_cast<std::size_t>(order) * 4 < rows, "order", "must be from 1 to a quarter of the rows",
          order);
  std::vector<double> counted(rows);
  double count = 0.0;
  for (std::size_t k = 0; k < rows; ++k) {
    counted[k] = counts[k] * residual[k];
    count += counts[k];
  }
  StopCheck stop(request);
  std::vector<double> covariance = detail::products_by_lag(counted, static_cast<std::size_t>(order) + 1, stop);
  require(count > 0.0 && covariance[0] > 0.0, "residual", "must have rows that count and differ from 0", count);
  // The biased estimate (all lags over the same count) keeps the filter stable; a trace of white noise keeps it finite.
  for (double& value : covariance) value /= count;
  covariance[0] *= 1.0 + 1e-9;
  return detail::levinson(covariance, stop);
}

/// e_k = r_k - sum_i a_i r_(k-i), written to `white`, which is as long as the row; before the first row, r is 0.
inline void whiten(std::span<const double> row, std::span<const double> a, double* white,
                   StopRequest* request = nullptr) {
  std::copy(row.begin(), row.end(), white);
  constexpr std::size_t cached = 1024;  // rows at a time, so that they stay close while every lag passes over them
  StopCheck stop(request);
  for (std::size_t first = 0; first < row.size(); first += cached) {
    stop.row();
    const std::size_t last = std::min(first + cached, row.size());
    std::size_t i = 0;
    for (; i + 4 <= a.size() && first >= i + 4; i += 4)  // four lags in one pass
      detail::take_four_lags(white + first, row.data() + first - i, a.data() + i,
                             static_cast<std::ptrdiff_t>(last - first));
    for (; i < a.size(); ++i)
      for (std::size_t k = std::max(first, i + 1); k < last; ++k) white[k] -= a[i] * row[k - i - 1];
  }
}

}  // namespace cogging
