#pragma once
// A sine that starts from rest through a second-order generator (Xu and Yao 2001, eq. 58).

#include <numbers>

#include "cogging/elementary.hpp"
#include "cogging/parameters.hpp"
#include "cogging/reference/reference.hpp"

namespace cogging {

struct FilteredSineParameters {
  static constexpr std::string_view description = "Sine and generator of a FilteredSine (Xu and Yao 2001, eq. 58).";

  double center = 0.0;                                // m
  double amplitude = 0.05;                            // m
  double frequency = 4.0 / (2.0 * std::numbers::pi);  // Hz
  double beta_1 = 100.0;                              // 1/s
  double beta_2 = 2500.0;                             // 1/s^2

  static constexpr auto fields() {
    using P = FilteredSineParameters;
    return std::tuple{Field{"center", &P::center, "m", "where the motion starts, at rest"},
                      Field{"amplitude", &P::amplitude, "m", "of the sine that it approaches", Rule::not_negative},
                      Field{"frequency", &P::frequency, "Hz", "of that sine", Rule::positive},
                      Field{"beta_1", &P::beta_1, "1/s", "damping of the generator", Rule::positive},
                      Field{"beta_2", &P::beta_2, "1/s^2", "stiffness of the generator", Rule::positive}};
  }
};

/// The generator of `description` is linear, so its difference w = q_d - q_r solves w'' + beta_1 w' + beta_2 w = 0 from
/// w(0) = 0, w'(0) = -amplitude omega, and is known exactly at every time: no step, no drift.
class FilteredSine final : public Reference {
 public:
  using Parameters = FilteredSineParameters;
  static constexpr std::string_view name = "filtered_sine";
  static constexpr std::string_view description = R"(A sine that starts from rest (Xu and Yao 2001, eq. 58).

q_d'' + beta_1 q_d' + beta_2 q_d = q_r'' + beta_1 q_r' + beta_2 q_r, q_r = center + amplitude sin(omega t), from rest at
the centre. Solved exactly at every time; the acceleration starts at beta_1 amplitude omega.)";

  explicit FilteredSine(const FilteredSineParameters& parameters) : parameters_(validated(parameters)) {}
  const FilteredSineParameters& parameters() const { return parameters_; }

  double period() const override { return 1.0 / parameters_.frequency; }

  ReferencePoint at(double time) const override {
    const FilteredSineParameters& q = parameters_;
    const double omega = 2.0 * std::numbers::pi * q.frequency;
    double sine, cosine;
    sin_cos(omega * time, sine, cosine);
    // w = -amplitude omega exp(-a t) s(t), where s'' = (a^2 - beta_2) s, s(0) = 0, s'(0) = 1.
    const double a = 0.5 * q.beta_1, square = a * a - q.beta_2;
    double shape, slope;
    if (square * time * time > 1e-8) {
      const double rate = std::sqrt(square);
      // With the decay inside, so that neither factor overflows.
      const double slow = exp((rate - a) * time), fast = exp((-rate - a) * time);
      shape = (slow - fast) / (2.0 * rate);
      slope = 0.5 * (slow + fast);
    } else {
      const double decay = exp(-a * time), rate = std::sqrt(std::abs(square));
      double s, c;
      sin_cos(rate * time, s, c);
      const bool series = std::abs(square) * time * time <= 1e-8;
      shape = decay * (series ? time * (1.0 + square * time * time / 6.0) : s / rate);
      slope = decay * (series ? 1.0 + square * time * time / 2.0 : c);
    }
    const double scale = -q.amplitude * omega;
    const double w = scale * shape, w_rate = scale * (slope - a * shape);
    const double w_rate_2 = -q.beta_1 * w_rate - q.beta_2 * w;
    return {q.center + q.amplitude * sine + w, q.amplitude * omega * cosine + w_rate,
            -q.amplitude * omega * omega * sine + w_rate_2};
  }

 private:
  FilteredSineParameters parameters_;
};

}  // namespace cogging
