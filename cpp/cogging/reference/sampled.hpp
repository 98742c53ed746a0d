#pragma once
// A motion given by its samples.

#include "cogging/reference/reference.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// The motion of `description`: second-order differences; cubic Hermite in the position and its derivative.
class Sampled final : public Reference {
 public:
  static constexpr std::string_view name = "sampled";
  static constexpr std::string_view description = R"(A motion given by its samples.

time (s), position (m) and, where known, velocity (m/s) and acceleration (m/s^2), all (n,). A missing derivative is
differentiated from the one before it. Between samples cubic, the acceleration linear; outside at rest.

Raises:
    ValueError: fewer than three samples, time not strictly increasing, lengths that differ, a NaN.)";

  Sampled(std::vector<double> time, std::vector<double> position, std::vector<double> velocity,
          std::vector<double> acceleration)
      : time_(std::move(time)),
        position_(std::move(position)),
        velocity_(std::move(velocity)),
        acceleration_(std::move(acceleration)) {
    require(time_.size() >= 3, "time", "must hold at least 3 samples", time_.size());
    require_finite("time", time_);
    for (std::size_t i = 1; i < time_.size(); ++i)
      require(time_[i] > time_[i - 1], "time", "must be strictly increasing", time_[i]);
    check(position_, "position");
    if (velocity_.empty()) velocity_ = differentiate(position_);
    check(velocity_, "velocity");
    if (acceleration_.empty()) acceleration_ = differentiate(velocity_);
    check(acceleration_, "acceleration");
  }

  double end() const override { return time_.back(); }

  const std::vector<double>& times() const { return time_; }
  const std::vector<double>& positions() const { return position_; }
  const std::vector<double>& velocities() const { return velocity_; }
  const std::vector<double>& accelerations() const { return acceleration_; }
  /// The i-th sample, to the bit, with its derivatives.
  ReferencePoint sample(std::size_t i) const { return {position_[i], velocity_[i], acceleration_[i]}; }

  ReferencePoint at(double time) const override {
    if (time < time_.front()) return {position_.front(), 0.0, 0.0};
    if (time > time_.back()) return {position_.back(), 0.0, 0.0};
    const std::size_t i = interval(time);
    if (time == time_[i]) return sample(i);
    const double h = time_[i + 1] - time_[i], s = (time - time_[i]) / h;
    const double rise = (position_[i + 1] - position_[i]) / h;
    const double curve = velocity_[i] + velocity_[i + 1] - 2.0 * rise;
    const double bend = 3.0 * rise - 2.0 * velocity_[i] - velocity_[i + 1];
    return {position_[i] + h * s * (velocity_[i] + s * (bend + s * curve)),
            velocity_[i] + s * (2.0 * bend + 3.0 * s * curve),
            acceleration_[i] + s * (acceleration_[i + 1] - acceleration_[i])};
  }

 private:
  // The last sample at or before a time within the motion, but for the last of all: looked for first where it would be
  // among samples at even times.
  std::size_t interval(double time) const {
    const std::size_t last = time_.size() - 2;
    const double even = (time - time_.front()) / (time_.back() - time_.front()) * static_cast<double>(last + 1);
    std::size_t i = std::min(whole_part<std::size_t>(even), last);
    if (i < last && time >= time_[i + 1]) ++i;
    if (time >= time_[i] && (i == last || time < time_[i + 1])) return i;
    const auto above = std::upper_bound(time_.begin(), time_.end(), time);
    return std::min(static_cast<std::size_t>(above - time_.begin()), last + 1) - 1;
  }

  void check(const std::vector<double>& column, std::string_view label) const {
    require(column.size() == time_.size(), label, "must be as long as time (" + format(time_.size()) + ")",
            column.size());
    require_finite(label, column);
  }

  std::vector<double> differentiate(const std::vector<double>& values) const {
    const std::size_t n = values.size();
    std::vector<double> slope(n);
    const auto three_points = [&](std::size_t i, std::size_t at) {  // the parabola through i-1, i, i+1
      const double h0 = time_[i] - time_[i - 1], h1 = time_[i + 1] - time_[i];
      const double d0 = (values[i] - values[i - 1]) / h0, d1 = (values[i + 1] - values[i]) / h1;
      const double second = (d1 - d0) / (h0 + h1);
      return d0 + second * (2.0 * time_[at] - time_[i] - time_[i - 1]);
    };
    for (std::size_t i = 0; i < n; ++i) slope[i] = three_points(std::clamp<std::size_t>(i, 1, n - 2), i);
    return slope;
  }

  std::vector<double> time_, position_, velocity_, acceleration_;
};

}  // namespace cogging
