#pragma once
// Seeded randomness: the same numbers from the same seed, on every platform.

#include <numbers>
#include <random>

#include "cogging/elementary.hpp"
#include "cogging/parameters.hpp"

namespace cogging {

struct NoiseParameters {
  double force = 0.0;       // V rms
  double bandwidth = 50.0;  // Hz

  static constexpr auto fields() {
    using P = NoiseParameters;
    return std::tuple{Field{"force", &P::force, "V", "rms of the force noise", Rule::not_negative},
                      Field{"bandwidth", &P::bandwidth, "Hz", "corner of its first-order spectrum", Rule::positive}};
  }
};

/// Standard normal numbers by the polar method (the standard library's normal_distribution differs by
/// vendor).
class NormalNumbers {
 public:
  explicit NormalNumbers(std::uint64_t seed) : engine_(seed) {}

  double operator()() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double a, b, square;
    do {
      a = 2.0 * uniform() - 1.0;
      b = 2.0 * uniform() - 1.0;
      square = a * a + b * b;
    } while (square >= 1.0 || square == 0.0);
    const double factor = std::sqrt(-2.0 * log(square) / square);
    spare_ = b * factor;
    has_spare_ = true;
    return a * factor;
  }

 private:
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }

  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

/// Force noise of a first-order spectrum: an exactly sampled Ornstein-Uhlenbeck process, held between
/// samples.
class ForceNoise {
 public:
  ForceNoise(const NoiseParameters& parameters, double sample_time, std::uint64_t seed)
      : rms_(validated(parameters).force),
        decay_(exp(-2.0 * std::numbers::pi * parameters.bandwidth * sample_time)),
        kick_(std::sqrt(1.0 - decay_ * decay_)),
        normal_(seed) {
    if (rms_ > 0.0) value_ = normal_();
  }

  /// The force of this sample, V; each call moves on by one sample.
  double operator()() {
    if (rms_ == 0.0) return 0.0;
    const double force = rms_ * value_;
    value_ = decay_ * value_ + kick_ * normal_();
    return force;
  }

 private:
  double rms_, decay_, kick_, value_ = 0.0;
  NormalNumbers normal_;
};

}  // namespace cogging
