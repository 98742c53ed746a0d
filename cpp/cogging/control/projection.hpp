#pragma once
// Discontinuous projection of an adaptation law (Lu et al. 2008, eq. 13, 14; Xu and Yao 2001, eq. 19, 20).

#include "cogging/scalar.hpp"

namespace cogging {

/// The adaptation rate, stopped where the estimate stands at a bound and would leave it (eq. 14).
template <class Scalar>
Scalar project(const Scalar& rate, const Scalar& estimate, const Scalar& minimum, const Scalar& maximum) {
  const Scalar kept_below = select(estimate >= maximum, select(rate > 0.0, Scalar(0.0), rate), rate);
  return select(estimate <= minimum, select(rate < 0.0, Scalar(0.0), kept_below), kept_below);
}

/// One Euler step of the projected law, `change` being sample time times rate: at a bound the clamp takes back
/// what (14) would have stopped, and what would overshoot a bound within the step ends on it.
template <class Scalar>
Scalar adapt(const Scalar& estimate, const Scalar& change, const Scalar& minimum, const Scalar& maximum) {
  return clamp(estimate + change, minimum, maximum);
}

}  // namespace cogging
