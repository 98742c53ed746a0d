#pragma once
// What the benchmark measures with: a clock, a histogram of fixed size, a count of allocations, the processor's own
// word on denormal numbers, and a painted stack.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#if defined(__x86_64__)
#include <immintrin.h>
#else
#include <cfenv>
#endif

namespace real_time {

/// Calls that gave or took back memory, of the whole program (real_time_allocations.cpp).
extern long allocations;

/// Bytes that were asked for.
extern std::size_t bytes_asked;

/// How much of a stack (bytes) a function touches; 0 where it cannot be seen.
std::size_t stack_touched(const std::function<void()>& function);

/// Ticks of the processor's counter where there is one, else nanoseconds. What stands between begin and end neither
/// starts before the one nor ends after the other.
class Clock {
 public:
#if defined(__x86_64__)
  static std::uint64_t begin() noexcept {
    _mm_lfence();
    const std::uint64_t ticks = __rdtsc();
    _mm_lfence();
    return ticks;
  }
  static std::uint64_t end() noexcept {
    unsigned processor;
    const std::uint64_t ticks = __rdtscp(&processor);
    _mm_lfence();
    return ticks;
  }
#else
  static std::uint64_t begin() noexcept { return nanoseconds(); }
  static std::uint64_t end() noexcept { return nanoseconds(); }
#endif

  static double ticks_in_a_nanosecond() {
    const std::uint64_t from = nanoseconds(), ticks = begin();
    while (nanoseconds() - from < 50'000'000) {
    }
    const std::uint64_t passed = end() - ticks;
    return static_cast<double>(passed) / static_cast<double>(nanoseconds() - from);
  }

 private:
  static std::uint64_t nanoseconds() noexcept {
    return static_cast<std::uint64_t>(
        std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count());
  }
};

/// Durations (ticks), each in a bin of its own up to some 40 us.
class Histogram {
 public:
  void add(std::uint64_t ticks) noexcept {
    ++count_;
    largest_ = std::max(largest_, ticks);
    ++bins_[std::min<std::size_t>(ticks, bins_.size() - 1)];
  }

  long count() const { return count_; }
  std::uint64_t largest() const { return largest_; }

  /// The smallest duration that is not exceeded by this share of the calls.
  std::uint64_t quantile(double share) const {
    const double wanted = share * static_cast<double>(count_);
    long below = 0;
    for (std::size_t ticks = 0; ticks + 1 < bins_.size(); ++ticks)
      if (static_cast<double>(below += bins_[ticks]) >= wanted) return ticks;
    return largest_;
  }

  /// Of the shortest, this share of the calls: finer than the counter's own steps, for the calls begin anywhere in one.
  double mean(double share) const {
    const std::uint64_t longest = quantile(share);
    double sum = 0.0, calls = 0.0;
    for (std::size_t ticks = 0; ticks < bins_.size() && ticks <= longest; ++ticks) {
      sum += static_cast<double>(ticks) * static_cast<double>(bins_[ticks]);
      calls += static_cast<double>(bins_[ticks]);
    }
    return sum / calls;
  }

  /// How many took longer; `ticks` below the last bin.
  long longer_than(double ticks) const {
    long found = 0;
    for (std::size_t bin = static_cast<std::size_t>(ticks) + 1; bin < bins_.size(); ++bin) found += bins_[bin];
    return found;
  }

 private:
  std::vector<long> bins_ = std::vector<long>(std::size_t{1} << 17);
  std::uint64_t largest_ = 0;
  long count_ = 0;
};

/// Whether arithmetic met a denormal number since `forget`: as an operand (x86 alone tells) or as a rounded result.
class Denormals {
 public:
#if defined(__x86_64__)
  static void forget() noexcept { _mm_setcsr(_mm_getcsr() & ~flags); }
  static bool met() noexcept { return (_mm_getcsr() & flags) != 0; }
  /// From here on they are taken as 0, and put out as 0; gives whether this can be.
  static bool flush(bool wanted) noexcept {
    _mm_setcsr(wanted ? _mm_getcsr() | to_zero : _mm_getcsr() & ~to_zero);
    return true;
  }

 private:
  static constexpr unsigned flags = 0x02 | 0x10, to_zero = 0x40 | 0x8000;  // DE, UE; DAZ, FTZ of MXCSR
#else
  static bool flush(bool) noexcept { return false; }
  static void forget() noexcept { std::feclearexcept(FE_UNDERFLOW); }
  static bool met() noexcept { return std::fetestexcept(FE_UNDERFLOW) != 0; }
#endif
};

}  // namespace real_time
