#pragma once
// The state of an axis, and what drives it during one integration step.

#include "cogging/scalar.hpp"

namespace cogging {

/// Where the axis is. The first two are those of the motor, to which the encoder belongs; the others stay 0
/// where no effect has such a state, so that {position, velocity} is an axis at ease.
template <class Scalar>
struct AxisState {
  Scalar position = 0.0;         // m
  Scalar velocity = 0.0;         // m/s
  Scalar bristle = 0.0;          // m, deflection of the friction contact (presliding_friction)
  Scalar deflection = 0.0;       // m, load position less motor position (backlash, flexible_mode)
  Scalar deflection_rate = 0.0;  // m/s
  Scalar speed_max = 0.0;        // m/s, the largest so far: against it the error of a step is small or not
};

/// The amplifier's output as it settles, and a held force.
template <class Scalar>
struct Drive {
  Scalar target = 0.0;     // V, command that acts
  Scalar deviation = 0.0;  // V, amplifier's output less target at the start of the step
  Scalar rate = 0.0;       // 1/s, at which the deviation decays
  Scalar force = 0.0;      // V, disturbance held over the sample
  bool lagging = false;

  Scalar at(const Scalar& offset) const { return lagging ? target + deviation * exp(-rate * offset) : target; }

  /// Fourth derivative of what the amplifier puts out, V/s^4.
  Scalar settling(const Scalar& offset) const {
    return lagging ? abs(deviation) * exp(-rate * offset) * (rate * rate * rate * rate) : Scalar(0.0);
  }
};

}  // namespace cogging
