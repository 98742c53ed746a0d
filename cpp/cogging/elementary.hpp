#pragma once
// Sine, cosine, arctangent, exponential and logarithm from additions, multiplications and divisions alone: the core
// gives the same bits on every machine, whatever mathematics library and instructions it has (that of GNU has an
// exponential for processors with fused multiplication and another one for those without), and the compiler can put
// them inline. Against long double over 12 million arguments, in units in the last place: sine and cosine within 2.4
// (1.5 below 300 rad), arctangent 0.9, exponential 0.9, logarithm 0.8, expm1 1.8, hyperbolic tangent 2.4, cube root
// 0.8.
//
// Polynomials and interval constants are those of fdlibm: Copyright (C) 1993 by Sun Microsystems, Inc. All rights
// reserved. Developed at SunPro, a Sun Microsystems, Inc. business. Permission to use, copy, modify, and distribute
// this software is freely granted, provided that this notice is preserved.

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "cogging/inlining.hpp"

namespace cogging {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// What a number and a register of numbers (registers.hpp) share: `Number` is either.
namespace elementary {

// Adding and taking away 1.5 * 2^52 rounds to the nearest whole number.
inline constexpr double round_shift = 6755399441055744.0, two_over_pi = 0.63661977236758134308;

/// pi/2 in three parts of 33 bits: products with a whole number below 2^20 are exact.
inline constexpr double half_pi[] = {1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21};

/// Sine and cosine of angle - turns * pi / 2, at most some pi / 4.
template <class Number>
COGGING_INLINE void quarter_sin_cos(const Number& angle, const Number& turns, Number& sine, Number& cosine) {
  const Number r = ((angle - turns * half_pi[0]) - turns * half_pi[1]) - turns * half_pi[2];
  const Number z = r * r;
  const Number w = z * z;
  sine = r + r * z *
                 ((-1.66666666666666324348e-01 + z * 8.33333333332248946124e-03) +
                  w * ((-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06) +
                       w * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  const Number half = 0.5 * z, rest = 1.0 - half;
  cosine =
      rest + (((1.0 - rest) - half) + w * ((4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) +
                                           w * ((2.48015872894767294178e-05 + z * -2.75573143513906633035e-07) +
                                                w * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))));
}

/// atan(x) = high + low + atan(t): high and low of the intervals from 7/16, 11/16, 19/16 and 39/16 on.
inline constexpr double atan_high[] = {4.63647609000806093515e-01, 7.85398163397448278999e-01,
                                       9.82793723247329054082e-01, 1.57079632679489655800e+00};
inline constexpr double atan_low[] = {2.26987774529616870924e-17, 3.06161699786838301793e-17,
                                      1.39033110312309984516e-17, 6.12323399573676603587e-17};

/// 1 - atan(t) / t for |t| < 7/16.
template <class Number>
COGGING_INLINE Number atan_series(const Number& t) {
  const Number z = t * t, w = z * z, w2 = w * w;
  const Number odd = z * ((3.33333333333329318027e-01 + w * 1.42857142725034663711e-01) +
                          w2 * ((9.09088713343650656196e-02 + w * 6.66107313738753120669e-02) +
                                w2 * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)));
  const Number even =
      w * ((-1.99999999998764832476e-01 + w * -1.11111104054623557880e-01) +
           w2 * ((-7.69187620504482999495e-02 + w * -5.83357013379057348645e-02) + w2 * -3.65315727442169155270e-02));
  return odd + even;
}

inline constexpr double small_turn = 1.0 / 16.0, small_tangent = 1.0 / 64.0;

/// Sine and cosine of an angle that differs by at most small_turn from that of the given ones.
template <class Number>
COGGING_INLINE void turn_a_little(const Number& change, Number& sine, Number& cosine) {
  const Number z = change * change;
  const Number w = z * z;
  const Number rises = change - change * z * ((1.0 / 6.0 - z * (1.0 / 120.0)) + w * (1.0 / 5040.0));
  const Number falls = z * ((0.5 - z * (1.0 / 24.0)) + w * (1.0 / 720.0 - z * (1.0 / 40320.0)));
  const Number s = sine;
  sine = s + (cosine * rises - s * falls);
  cosine = cosine - (s * rises + cosine * falls);
}

/// Arctangent of at most small_tangent, to the last place of 1.
template <class Number>
COGGING_INLINE Number atan_of_small(const Number& t) {
  const Number z = t * t;
  return t - t * z * ((1.0 / 3.0 - z * (1.0 / 5.0)) + (z * z) * (1.0 / 7.0));
}

/// Sine and cosine behind a number of quarter turns.
COGGING_INLINE void turn(int quadrant, double& sine, double& cosine) {
  const double s = quadrant & 1 ? cosine : sine, c = quadrant & 1 ? sine : cosine;
  sine = quadrant & 2 ? -s : s;
  cosine = (quadrant + 1) & 2 ? -c : c;
}

/// From a million radians on. Beyond 1e12, where an angle and the next number lie 1e-4 rad apart, the library answers.
COGGING_COLD inline void sin_cos_of_large(double angle, double& sine, double& cosine) {
  if (!(std::abs(angle) < 1e12)) {
    sine = std::sin(angle);
    cosine = std::cos(angle);
    return;
  }
  const double turns = (angle * two_over_pi + round_shift) - round_shift;
  const double many = static_cast<double>(static_cast<std::int64_t>(turns * 0x1p-20)) * 0x1p20;
  const double few = turns - many;  // products of both are exact
  const double r = (((angle - many * half_pi[0]) - few * half_pi[0]) - many * half_pi[1]) - few * half_pi[1];
  quarter_sin_cos(r - turns * half_pi[2], 0.0, sine, cosine);
  turn(static_cast<int>(static_cast<std::int64_t>(turns) & 3), sine, cosine);
}

}  // namespace elementary

/// Sine and cosine of an angle (rad).
COGGING_INLINE void sin_cos(double angle, double& sine, double& cosine) {
  if (!(std::abs(angle) < 1e6)) [[unlikely]] {
    double s, c;  // those of the caller would have to leave their registers
    elementary::sin_cos_of_large(angle, s, c);
    sine = s, cosine = c;
    return;
  }
  const double turns = (angle * elementary::two_over_pi + elementary::round_shift) - elementary::round_shift;
  elementary::quarter_sin_cos(angle, turns, sine, cosine);
  elementary::turn(static_cast<int>(turns) & 3, sine, cosine);
}

/// Arctangent, rad.
COGGING_INLINE double atan(double value) {
  using elementary::atan_high, elementary::atan_low;
  const double x = std::abs(value);
  double high = 0.0, low = 0.0, t = x;  // |t| < 7/16
  if (x >= 2.4375) {
    high = atan_high[3], low = atan_low[3], t = -1.0 / x;
  } else if (x >= 1.1875) {
    high = atan_high[2], low = atan_low[2], t = (x - 1.5) / (1.0 + 1.5 * x);
  } else if (x >= 0.6875) {
    high = atan_high[1], low = atan_low[1], t = (x - 1.0) / (x + 1.0);
  } else if (x >= 0.4375) {
    high = atan_high[0], low = atan_low[0], t = (2.0 * x - 1.0) / (2.0 + x);
  }
  const double result = high - ((t * elementary::atan_series(t) - low) - t);
  return value < 0.0 ? -result : result;
}

namespace elementary {

inline constexpr double ln_2_high = 6.93147180369123816490e-01, ln_2_low = 1.90821492927058770002e-10;

/// 2^power for a power from -1022 to 1023.
inline double power_of_two(int power) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + power) << 52);
}

/// exp(high - low) - 1 where that is at most some ln(2) / 2.
inline double exp_less_one(double high, double low) {
  const double r = high - low, z = r * r;
  const double c =
      r -
      z * (1.66666666666666019037e-01 +
           z * (-2.77777777770155933842e-03 +
                z * (6.61375632143793436117e-05 + z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))));
  return high - (low - r * c / (2.0 - c));
}

/// The whole number of ln(2) nearest to a value, and what is left of it: high - low.
inline int whole_ln_2(double value, double& high, double& low) {
  const double whole = (value * 1.44269504088896338700 + round_shift) - round_shift;
  high = value - whole * ln_2_high;  // the product is exact
  low = whole * ln_2_low;
  return static_cast<int>(whole);
}

}  // namespace elementary

/// exp(value).
inline double exp(double value) {
  if (value != value) return value;
  if (value > 709.782712893383973096) return infinity;
  if (value < -745.13321910194110842) return 0.0;
  double high, low;
  const int power = elementary::whole_ln_2(value, high, low), half = power / 2;
  const double grown = 1.0 + elementary::exp_less_one(high, low);
  return grown * elementary::power_of_two(half) * elementary::power_of_two(power - half);
}

/// exp(value) - 1, exact to its last places near 0 too.
inline double expm1(double value) {
  if (!(std::abs(value) < 38.0)) return exp(value) - 1.0;
  double high, low;
  const double scale = elementary::power_of_two(elementary::whole_ln_2(value, high, low));
  return scale * elementary::exp_less_one(high, low) + (scale - 1.0);
}

/// Natural logarithm of a number from 0 on.
inline double log(double value) {
  if (!(value > 0.0)) return value == 0.0 ? -infinity : std::nan("");
  if (!(value <= std::numeric_limits<double>::max())) return value;
  int power;
  double part = std::frexp(value, &power);  // from 1/2 to 1
  if (part < 0.70710678118654752440) part *= 2.0, --power;
  const double f = part - 1.0, s = f / (2.0 + f), z = s * s, w = z * z, half = 0.5 * f * f;
  const double even = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
  const double odd =
      z * (6.666666666666735130e-01 +
           w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
  const double high = power * elementary::ln_2_high, low = power * elementary::ln_2_low;
  return high - ((half - (s * (half + (odd + even)) + low)) - f);
}

/// base^exponent of a base from 0 on, within |exponent log(base)| + 2 units in the last place; those of 1 and 2
/// exactly.
inline double pow(double base, double exponent) {
  if (exponent == 1.0) return base;
  if (exponent == 2.0) return base * base;
  return exponent == 0.0 ? 1.0 : exp(exponent * log(base));
}

/// Hyperbolic tangent.
inline double tanh(double value) {
  const double grown = expm1(2.0 * std::abs(value));
  const double result = grown < 1e17 ? grown / (grown + 2.0) : 1.0;
  return std::copysign(value != value ? value : result, value);
}

/// Cube root of a number from 0 on.
inline double cube_root(double value) {
  if (value == 0.0) return 0.0;
  const double near = exp(log(value) / 3.0);
  return near - (near - value / (near * near)) / 3.0;
}

}  // namespace cogging
