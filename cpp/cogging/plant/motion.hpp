#pragma once
// What a force law may look at.

namespace cogging {

template <class Scalar>
struct Motion {
  Scalar position;   // m
  Scalar velocity;   // m/s
  Scalar direction;  // S(velocity) in the smooth form, -1 or +1 where the axis slides (or is about to) in the
                     // exact one
  double time;       // s, from the first row
};

}  // namespace cogging
