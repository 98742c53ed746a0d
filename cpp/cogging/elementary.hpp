#pragma once
// Sine, cosine and arctangent from additions, multiplications and divisions alone: the hot loop gives the same bits on
// every machine, whatever mathematics library it has, and the compiler can put them inline. Against long double over 12
// million arguments: sine and cosine within 2.4 units in the last place (1.5 below 300 rad), arctangent within 0.9.
// Polynomials and interval constants are those of fdlibm: Copyright (C) 1993 by Sun Microsystems, Inc. All rights
// reserved. Developed at SunPro, a Sun Microsystems, Inc. business. Permission to use, copy, modify, and distribute this
// software is freely granted, provided that this notice is preserved.

#include <cmath>

#include "cogging/inlining.hpp"

namespace cogging {

/// What a number and a register of numbers (registers.hpp) share: `Number` is either.
namespace elementary {

// Adding and taking away 1.5 * 2^52 rounds to the nearest whole number.
inline constexpr double round_shift = 6755399441055744.0, two_over_pi = 0.63661977236758134308;

/// Sine and cosine of angle - turns * pi / 2, at most some pi / 4.
template <class Number>
COGGING_INLINE void quarter_sin_cos(const Number& angle, const Number& turns, Number& sine, Number& cosine) {
  // pi/2 in three parts of 33 bits: products with a whole number below 2^20 are exact.
  const Number r = ((angle - turns * 1.57079632673412561417) - turns * 6.07710050630396597660e-11) -
                   turns * 2.02226624879595063154e-21;
  const Number z = r * r;
  sine = r + r * z *
                 (-1.66666666666666324348e-01 +
                  z * (8.33333333332248946124e-03 +
                       z * (-1.98412698298579493134e-04 +
                            z * (2.75573137070700676789e-06 +
                                 z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
  const Number half = 0.5 * z, rest = 1.0 - half;
  cosine = rest + (((1.0 - rest) - half) +
                   z * z *
                       (4.16666666666666019037e-02 +
                        z * (-1.38888888888741095749e-03 +
                             z * (2.48015872894767294178e-05 +
                                  z * (-2.75573143513906633035e-07 +
                                       z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))))));
}

/// atan(x) = high + low + atan(t): high and low of the intervals from 7/16, 11/16, 19/16 and 39/16 on.
inline constexpr double atan_high[] = {4.63647609000806093515e-01, 7.85398163397448278999e-01,
                                       9.82793723247329054082e-01, 1.57079632679489655800e+00};
inline constexpr double atan_low[] = {2.26987774529616870924e-17, 3.06161699786838301793e-17,
                                      1.39033110312309984516e-17, 6.12323399573676603587e-17};

/// 1 - atan(t) / t for |t| < 7/16.
template <class Number>
COGGING_INLINE Number atan_series(const Number& t) {
  const Number z = t * t, w = z * z;
  const Number odd = z * (3.33333333333329318027e-01 +
                          w * (1.42857142725034663711e-01 +
                               w * (9.09088713343650656196e-02 +
                                    w * (6.66107313738753120669e-02 +
                                         w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const Number even =
      w *
      (-1.99999999998764832476e-01 +
       w * (-1.11111104054623557880e-01 +
            w * (-7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  return odd + even;
}

}  // namespace elementary

/// Sine and cosine of an angle (rad). Beyond a million radians the library's functions answer.
COGGING_INLINE void sin_cos(double angle, double& sine, double& cosine) {
  if (!(std::abs(angle) < 1e6)) {
    sine = std::sin(angle);
    cosine = std::cos(angle);
    return;
  }
  const double turns = (angle * elementary::two_over_pi + elementary::round_shift) - elementary::round_shift;
  const int quadrant = static_cast<int>(turns) & 3;
  double sine_r, cosine_r;
  elementary::quarter_sin_cos(angle, turns, sine_r, cosine_r);
  const double s = quadrant & 1 ? cosine_r : sine_r, c = quadrant & 1 ? sine_r : cosine_r;
  sine = quadrant & 2 ? -s : s;
  cosine = (quadrant + 1) & 2 ? -c : c;
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

}  // namespace cogging
