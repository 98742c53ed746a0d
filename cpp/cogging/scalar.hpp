#pragma once
// What the hot code asks of its scalar, for `double`. A pack of lanes (lanes.hpp) answers the same questions.

#include <algorithm>
#include <cstddef>

#include "cogging/elementary.hpp"

namespace cogging {

using std::abs;

/// To the nearest whole number, halves away from zero, as std::round, which is a call without SSE4.1.
inline double round(double value) {
  if (!(std::abs(value) < 0x1p52)) return value;
  const double below_half = 0.49999999999999994;  // what lies just below a half must not be lifted over it
  return std::copysign(static_cast<double>(static_cast<std::int64_t>(value + std::copysign(below_half, value))), value);
}

inline double select(bool condition, double if_true, double if_false) {
  return condition ? if_true : if_false;
}
inline double clamp(double value, double lower, double upper) {
  const double raised = lower > value ? lower : value;  // maximum, then minimum: no branch
  return upper < raised ? upper : raised;
}
inline double sign(double value) {
  return value > 0.0 ? 1.0 : (value < 0.0 ? -1.0 : 0.0);
}
inline bool all_finite(double value) {
  return std::isfinite(value);
}
inline double largest(double value) {
  return value;
}
inline double smallest(double value) {
  return value;
}
inline bool all(bool condition) {
  return condition;
}

/// The whole number in a value, towards 0: the type's own end of one that lies beyond it, and 0 of a NaN. Of both C++
/// itself would give any number at all.
template <class Integer = int>
Integer whole_part(double value) {
  using Limits = std::numeric_limits<Integer>;
  constexpr double beyond = 2.0 * static_cast<double>(Limits::max() / 2 + 1);  // the largest itself may be no double
  if (value >= beyond) return Limits::max();
  if (value <= static_cast<double>(Limits::min())) return Limits::min();
  return value == value ? static_cast<Integer>(value) : Integer{0};
}

/// How many numbers a scalar holds, and each of them.
template <class Scalar>
inline constexpr std::size_t lanes_of = 1;
inline double lane(double value, std::size_t) {
  return value;
}
inline void set_lane(double& value, std::size_t, double lane_value) {
  value = lane_value;
}

template <class Scalar>
Scalar larger(const Scalar& a, const Scalar& b) {
  return select(a < b, b, a);
}
template <class Scalar>
Scalar smaller(const Scalar& a, const Scalar& b) {
  return select(b < a, b, a);
}

/// A state that dies away by a factor a sample, 0 at last. Left alone it would end as a denormal number, with which
/// many processors take a hundred times as long; its squares and products get there long before it.
template <class Scalar>
Scalar died_away(const Scalar& state) {
  return select(abs(state) < 1e-100, Scalar(0.0), state);
}

/// The integer that goes with a scalar, for table look-up.
template <class Scalar>
struct IndexOf;
template <>
struct IndexOf<double> {
  using type = int;
};
/// Of a value below 2^31, at most `last`; 0 for one below 0 and for a NaN, which is no integer.
inline int truncate_to_index(double value, int last) {
  return std::min(static_cast<int>(value > 0.0 ? value : 0.0), last);
}
inline double from_index(int value) {
  return static_cast<double>(value);
}
inline double gather(const double* table, int index) {
  return table[index];
}
inline void scatter(double* table, int index, double value) {
  table[index] = value;
}
/// function(index), as a plain integer where that serves all lanes.
template <class Function>
COGGING_INLINE decltype(auto) with_index(int index, const Function& function) {
  return function(index);
}

/// S(v) = (2/pi) atan(v / width); width = 0 is sgn(v), with sgn(0) = 0. Each lane by its own width.
template <class Scalar>
COGGING_INLINE Scalar smooth_sign(const Scalar& velocity, const Scalar& width) {
  using elementary::two_over_pi;
  const auto smooth = width > 0.0;
  if (all(smooth)) return two_over_pi * atan(velocity / width);
  if constexpr (lanes_of<Scalar> == 1)
    return sign(velocity);
  else
    return select(smooth, two_over_pi * atan(velocity / select(smooth, width, Scalar(1.0))), sign(velocity));
}

/// smooth_sign of one width without the division, whose result every stage of a step would wait for.
template <class Scalar>
class SmoothSign {
 public:
  SmoothSign() = default;
  explicit SmoothSign(const Scalar& width)
      : width_(width),
        inverse_(smaller(Scalar(1.0) / width, Scalar(std::numeric_limits<double>::max()))),
        smooth_(all(width > 0.0)) {}

  COGGING_INLINE Scalar operator()(const Scalar& velocity) const {
    using elementary::two_over_pi;
    if (smooth_) [[likely]]
      return two_over_pi * atan(velocity * inverse_);
    if constexpr (lanes_of<Scalar> == 1)
      return sign(velocity);
    else  // not smooth_sign: a lane has the bits of its machine alone, whatever the others are
      return select(width_ > 0.0, two_over_pi * atan(velocity * inverse_), sign(velocity));
  }

  /// A velocity, in widths, and its sign.
  struct Known {
    Scalar ratio, sign;
  };
  COGGING_INLINE Known known(const Scalar& velocity) const { return {velocity * inverse_, (*this)(velocity)}; }

  /// The same from another velocity, cheaper where they are near: atan(a) - atan(b) = atan((a - b) / (1 + a b)).
  COGGING_INLINE Scalar operator()(const Scalar& velocity, const Known& other) const {
    using elementary::small_tangent, elementary::two_over_pi;
    if (!smooth_) [[unlikely]]
      return (*this)(velocity);
    const Scalar ratio = velocity * inverse_, change = ratio - other.ratio, below = 1.0 + ratio * other.ratio;
    const auto near = abs(change) <= small_tangent * below;
    const Scalar sign = other.sign + two_over_pi * elementary::atan_of_small(change / below);
    return all(near) ? sign : select(near, sign, (*this)(velocity));
  }

 private:
  Scalar width_ = 0.0, inverse_ = 0.0;
  bool smooth_ = false;
};

}  // namespace cogging
