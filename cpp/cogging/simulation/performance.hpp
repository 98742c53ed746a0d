#pragma once
// The indexes by which the papers judge a run.

#include <span>

#include "cogging/parameters.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

struct Performance {
  double error_max;           // (e_inf, e_M)
  double error_rms;           // (e_2, e_rms)
  double error_final_max;     // in the last `final_window` seconds (e_F)
  double command_rms;         // (u_rms)
  double command_change_rms;  // over the number of changes (du_rms)
  double command_chatter;     // (c_u)

  static constexpr auto fields() {
    using P = Performance;
    return std::tuple{Field{"error_max", &P::error_max, "m", "max |e|"},
                      Field{"error_rms", &P::error_rms, "m", "sqrt(mean e^2)"},
                      Field{"error_final_max", &P::error_final_max, "m", "max |e| in the final window"},
                      Field{"command_rms", &P::command_rms, "V", "sqrt(mean u^2)"},
                      Field{"command_change_rms", &P::command_change_rms, "V", "rms of u_k - u_(k-1)"},
                      Field{"command_chatter", &P::command_chatter, "", "command_change_rms / command_rms"}};
  }
};

/// Over which rows of a run it is judged: those with start <= time < stop.
struct TimeWindow {
  double start = -infinity;   // s
  double stop = infinity;     // s
  double final_window = 2.0;  // s, of error_final_max
};

/// The same as numbers of rows.
struct RowsOfWindow {
  std::size_t first = 0, end = 0;  // first <= k < end
  std::size_t final_first = 0;

  bool holds(std::size_t k) const { return k >= first && k < end; }
  std::size_t size() const { return end - first; }
};

/// time_of(k) is the time of row k, rising. Raises std::invalid_argument where fewer than two rows lie in the window.
template <class TimeOf>
RowsOfWindow rows_of(const TimeWindow& window, std::size_t rows, const TimeOf& time_of) {
  require(window.start < window.stop, "start", "must be below stop = " + format(window.stop), window.start);
  require(window.final_window > 0.0, "final_window", "must be above 0", window.final_window);
  const auto first_from = [&](double time) {
    std::size_t low = 0, high = rows;
    while (low < high) {
      const std::size_t middle = low + (high - low) / 2;
      if (time_of(middle) < time)
        low = middle + 1;
      else
        high = middle;
    }
    return low;
  };
  RowsOfWindow found{first_from(window.start), first_from(window.stop), 0};
  require(found.end >= found.first + 2, "start, stop", "must hold at least 2 rows",
          found.end > found.first ? static_cast<double>(found.size()) : 0.0);
  found.final_first = first_from(std::max(window.start, time_of(found.end - 1) - window.final_window));
  return found;
}

/// The sums from which the indexes of a run are made, or of as many runs as the scalar has lanes.
template <class Scalar>
class PerformanceSums {
 public:
  PerformanceSums() = default;
  explicit PerformanceSums(const RowsOfWindow& rows) : rows_(rows) {}

  /// Each row of the window once, in order.
  void row(std::size_t k, const Scalar& error, const Scalar& command) {
    const Scalar size = abs(error);
    error_max_ = larger(error_max_, size);
    if (k >= rows_.final_first) error_final_max_ = larger(error_final_max_, size);
    error_squares_ += size * size;
    command_squares_ += command * command;
    if (k > rows_.first) change_squares_ += (command - command_before_) * (command - command_before_);
    command_before_ = command;
  }

  Performance of_lane(std::size_t i) const {
    const double rows = static_cast<double>(rows_.size());
    Performance result{};
    result.error_max = lane(error_max_, i);
    result.error_final_max = lane(error_final_max_, i);
    result.error_rms = std::sqrt(lane(error_squares_, i) / rows);
    result.command_rms = std::sqrt(lane(command_squares_, i) / rows);
    result.command_change_rms = std::sqrt(lane(change_squares_, i) / (rows - 1.0));
    result.command_chatter = result.command_rms > 0.0 ? result.command_change_rms / result.command_rms : 0.0;
    return result;
  }

 private:
  RowsOfWindow rows_;
  Scalar error_max_ = 0.0, error_final_max_ = 0.0, error_squares_ = 0.0;
  Scalar command_squares_ = 0.0, change_squares_ = 0.0, command_before_ = 0.0;
};

/// Indexes over the rows with start <= time < stop (Xu and Yao 2001, section 4.2; Lu et al. 2008, Table 1).
inline Performance performance(std::span<const double> time, std::span<const double> error,
                               std::span<const double> command, const TimeWindow& window) {
  require(error.size() == time.size(), "error", "must be as long as time", error.size());
  require(command.size() == time.size(), "command", "must be as long as time", command.size());
  const RowsOfWindow rows = rows_of(window, time.size(), [&](std::size_t k) { return time[k]; });
  PerformanceSums<double> sums(rows);
  for (std::size_t k = rows.first; k < rows.end; ++k) {
    require_finite("error", error[k]);
    require_finite("command", command[k]);
    sums.row(k, error[k], command[k]);
  }
  return sums.of_lane(0);
}

}  // namespace cogging
