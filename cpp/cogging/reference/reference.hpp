#pragma once
// What the axis is asked to do: position and its first two derivatives as functions of time.

#include "cogging/scalar.hpp"

namespace cogging {

struct ReferencePoint {
  double position = 0.0;      // m
  double velocity = 0.0;      // m/s
  double acceleration = 0.0;  // m/s^2
};

class Reference {
 public:
  virtual ~Reference() = default;
  virtual ReferencePoint at(double time) const = 0;
  /// The time at which the motion is over, s; infinite for a motion without an end of its own.
  virtual double end() const { return infinity; }
  /// After which time the motion repeats itself, s; infinite for one that does not.
  virtual double period() const { return infinity; }
};

}  // namespace cogging
