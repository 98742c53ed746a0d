#pragma once
// What a loop remembers of itself: sums and a histogram of fixed size, so that no sample allocates.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>

/// Of durations, s.
class Durations {
 public:
  void add(double duration) noexcept {
    ++count_;
    sum_ += duration;
    squares_ += duration * duration;
    largest_ = std::max(largest_, duration);
    ++bins_[static_cast<std::size_t>(std::clamp(duration * 1e6, 0.0, double(bins_.size() - 1)))];
  }

  void print(const char* name) const {
    if (count_ == 0) return;
    const double n = static_cast<double>(count_), mean = sum_ / n;
    std::printf("%s: mean %.2f us, standard deviation %.2f us, 99 %% within %zu us, largest %.2f us\n", name,
                1e6 * mean, 1e6 * std::sqrt(std::max(0.0, squares_ / n - mean * mean)), within(0.99), 1e6 * largest_);
  }

 private:
  std::size_t within(double share) const {
    long below = 0;
    std::size_t bin = 0;
    while (bin < bins_.size() && static_cast<double>(below) < share * static_cast<double>(count_))
      below += bins_[bin++];
    return bin;
  }

  long count_ = 0;
  double sum_ = 0.0, squares_ = 0.0, largest_ = 0.0;
  std::array<long, 10000> bins_{};  // of 1 us; the last holds all that is longer
};

struct Statistics {
  Durations lateness, computing;
  long samples = 0, missed = 0;
  double error_squares = 0.0, error_max = 0.0;

  void add_error(double error) noexcept {
    ++samples;
    error_squares += error * error;
    error_max = std::max(error_max, std::abs(error));
  }

  void print() const {
    std::printf("samples: %ld taken, %ld missed\n", samples, missed);
    lateness.print("late by");
    computing.print("computing");
    std::printf("error: rms %.12g m, largest %.12g m\n", std::sqrt(error_squares / static_cast<double>(samples)),
                error_max);
  }
};
