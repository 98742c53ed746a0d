#pragma once
// The indexes by which the papers judge a run.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "cogging/require.hpp"

namespace cogging {

struct Performance {
  double error_max;           // m, max |e|            (e_inf, e_M)
  double error_rms;           // m, sqrt(mean e^2)     (e_2, e_rms)
  double error_final_max;     // m, max |e| in the last `final_window` seconds (e_F)
  double command_rms;         // V                     (u_rms)
  double command_change_rms;  // V, rms of u_k - u_(k-1), divided by the number of changes (du_rms)
  double command_chatter;     // command_change_rms / command_rms (c_u)
};

/// Indexes over the rows with start <= time < stop (Xu and Yao 2001, section 4.2; Lu et al. 2008, Table 1).
inline Performance performance(std::span<const double> time, std::span<const double> error,
                               std::span<const double> command, double start, double stop, double final_window) {
  require(error.size() == time.size(), "error", "must be as long as time", static_cast<double>(error.size()));
  require(command.size() == time.size(), "command", "must be as long as time", static_cast<double>(command.size()));
  require(start < stop, "start", "must be below stop = " + format(stop), start);
  require(final_window > 0.0, "final_window", "must be above 0", final_window);
  const auto first = std::lower_bound(time.begin(), time.end(), start) - time.begin();
  const auto last = std::lower_bound(time.begin(), time.end(), stop) - time.begin();
  require(last - first >= 2, "start, stop", "must hold at least 2 rows", static_cast<double>(last - first));
  Performance result{};
  const double final_start = std::max(start, time[last - 1] - final_window);
  double error_squares = 0.0, command_squares = 0.0, change_squares = 0.0;
  for (auto k = first; k < last; ++k) {
    require_finite("error", error[k]);
    require_finite("command", command[k]);
    const double size = std::abs(error[k]);
    result.error_max = std::max(result.error_max, size);
    if (time[k] >= final_start) result.error_final_max = std::max(result.error_final_max, size);
    error_squares += size * size;
    command_squares += command[k] * command[k];
    if (k > first) change_squares += (command[k] - command[k - 1]) * (command[k] - command[k - 1]);
  }
  const double rows = static_cast<double>(last - first);
  result.error_rms = std::sqrt(error_squares / rows);
  result.command_rms = std::sqrt(command_squares / rows);
  result.command_change_rms = std::sqrt(change_squares / (rows - 1.0));
  result.command_chatter = result.command_rms > 0.0 ? result.command_change_rms / result.command_rms : 0.0;
  return result;
}

}  // namespace cogging
