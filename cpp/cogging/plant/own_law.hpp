#pragma once
// A law that is no part of the list of effects: a function of somebody's own.

#include <cstddef>
#include <span>

namespace cogging {

/// Where an axis was: one entry a moment, m, m/s and s.
struct Course {
  std::span<const double> position, velocity, time;
};

/// A function of position (m), velocity (m/s) and time (s, from the first row), its parameters inside it.
///
/// It is pure: the same numbers give the same bits, from any thread. It may throw.
class OwnLaw {
 public:
  virtual ~OwnLaw() = default;

  virtual double at(double position, double velocity, double time) const = 0;

  /// The same along a course; `values` is as long as it.
  virtual void along(const Course& course, std::span<double> values) const {
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = at(course.position[k], course.velocity[k], course.time[k]);
  }

  /// Whether one thread at a time can be in it (an interpreter's lock): more threads then gain nothing.
  virtual bool serial() const { return false; }
};

}  // namespace cogging
