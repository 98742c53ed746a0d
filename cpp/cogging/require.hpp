#pragma once
// What breaks a rule is refused here: one line that names the field, the rule and the value.

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace cogging {

/// A run whose state left the travel, stopped being finite or got too fast to be integrated; says when and where.
class DivergedError : public std::runtime_error {
 public:
  DivergedError(const std::string& message, double at_time) : std::runtime_error(message), time(at_time) {}
  double time;  // s
};

/// The shortest of %g and %.17g that reads back as the same number.
inline std::string format(double value) {
  if (std::isnan(value)) return "nan";  // whose sign says nothing
  char text[40];
  std::snprintf(text, sizeof text, "%g", value);
  if (std::isfinite(value) && std::strtod(text, nullptr) != value) std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}
inline std::string format(std::integral auto count) {
  return format(static_cast<double>(count));
}

#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
[[noreturn]] inline void refused(const std::string& line) {
  throw std::invalid_argument(line);
}
#else
/// Where the compiler has no exceptions, as a drive's may have none, the program defines this itself: what becomes of a
/// constructor whose parameters break a rule. It must not return.
[[noreturn]] void refused(const std::string& line);
#endif

[[noreturn]] inline void refuse(std::string_view name, std::string_view rule, std::string_view value) {
  refused(std::string(name) + ": " + std::string(rule) + ", got " + std::string(value));
}

inline void require(bool holds, std::string_view name, std::string_view rule, double value) {
  if (!holds) refuse(name, rule, format(value));
}
inline void require(bool holds, std::string_view name, std::string_view rule, std::integral auto count) {
  require(holds, name, rule, static_cast<double>(count));
}

inline void require_finite(std::string_view name, double value) {
  require(std::isfinite(value), name, "must be a finite number", value);
}

inline void require_positive(std::string_view name, double value) {
  require(std::isfinite(value) && value > 0.0, name, "must be finite and above 0", value);
  require(value <= 1e30, name, "must be at most 1e+30 in size", value);  // its fourth power is still a number
}

/// A spatial period, m: a sine of a shorter one is noise of the last digits along any travel, of a longer one no wave.
inline void require_period(std::string_view name, double value) {
  require_positive(name, value);
  require(value >= 1e-9 && value <= 1e9, name, "must be from 1e-9 to 1e9", value);
}

inline void require_not_negative(std::string_view name, double value) {
  require(std::isfinite(value) && value >= 0.0, name, "must be finite and at least 0", value);
}

inline void require_finite(std::string_view name, const std::vector<double>& values) {
  for (double value : values) require_finite(name, value);
}

/// lower <= upper, both finite.
inline void require_ordered(std::string_view name, double lower, double upper) {
  if (!(std::isfinite(lower) && std::isfinite(upper) && lower <= upper))
    refuse(name, "needs minimum <= maximum, both finite", "[" + format(lower) + ", " + format(upper) + "]");
}

}  // namespace cogging
