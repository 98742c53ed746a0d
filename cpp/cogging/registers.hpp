#pragma once
// What one register of the processor holds: doubles side by side, by the compilers' vector types (GCC, Clang). The
// elementary functions do the operations of elementary.hpp in the same order, so each number has the same bits; where
// those take one branch of several, all are taken and the right one is chosen.

#include "cogging/register_types.hpp"
#include "cogging/scalar.hpp"

#if defined(__AVX__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <smmintrin.h>  // a tenth of that, for the compiler
#endif

namespace cogging {

#if defined(__AVX512F__) && defined(__AVX512DQ__)
inline constexpr std::size_t register_width = 8;
#elif defined(__AVX__)
inline constexpr std::size_t register_width = 4;
#elif defined(__GNUC__)
inline constexpr std::size_t register_width = 2;
#else
inline constexpr std::size_t register_width = 1;
#endif

template <std::size_t width>
struct Register;

/// Without vector types: one number.
template <>
struct Register<1> {
  using Numbers = double;
  using Mask = bool;

  static Mask mask_of(bool value) { return value; }
  static bool holds(Mask mask, std::size_t) { return mask; }
  static bool all(Mask mask) { return mask; }
  static Numbers of(double value) { return value; }
  static double get(Numbers a, std::size_t) { return a; }
  static void set(Numbers& a, std::size_t, double value) { a = value; }
  static Numbers abs(Numbers a) { return std::abs(a); }
  static Numbers trunc(Numbers a) { return std::trunc(a); }
  static Numbers round(Numbers a) { return std::round(a); }
  static Numbers atan(Numbers a) { return cogging::atan(a); }
  static void sin_cos(Numbers angle, Numbers& sine, Numbers& cosine) { cogging::sin_cos(angle, sine, cosine); }
};

#if defined(__GNUC__)

template <std::size_t width>
struct Register {
  using Numbers = typename RegisterTypes<width>::Numbers;
  using Mask = typename RegisterTypes<width>::Mask;  // all bits, or none

  COGGING_INLINE static Mask mask_of(bool value) { return Mask{} - std::int64_t{value}; }
  COGGING_INLINE static bool holds(const Mask& mask, std::size_t i) { return mask[i] != 0; }
  COGGING_INLINE static Numbers of(double value) { return value - Numbers{}; }  // less zero: of -0.0 too
  COGGING_INLINE static double get(const Numbers& a, std::size_t i) { return a[i]; }
  COGGING_INLINE static void set(Numbers& a, std::size_t i, double value) { a[i] = value; }

  COGGING_INLINE static bool all(const Mask& mask) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
    if constexpr (width == 8) return _mm512_movepi64_mask((__m512i)mask) == 0xff;
#endif
#if defined(__AVX__)
    if constexpr (width == 4) return _mm256_movemask_pd((__m256d)mask) == 0xf;
#endif
#if defined(__SSE2__)
    if constexpr (width == 2) return _mm_movemask_pd((__m128d)mask) == 0x3;
#endif
    std::int64_t together = mask[0];
    for (std::size_t i = 1; i < width; ++i) together &= mask[i];
    return together != 0;
  }

  COGGING_INLINE static Numbers abs(const Numbers& a) { return Numbers(Mask(a) & (mask_of(true) ^ sign_bit())); }

  COGGING_INLINE static Numbers trunc(const Numbers& a) {
#if defined(__AVX512F__)
    if constexpr (width == 8) return Numbers(_mm512_mask_roundscale_pd((__m512d)a, 0xff, (__m512d)a, 0x0b));
#endif
#if defined(__AVX__)
    if constexpr (width == 4) return Numbers(_mm256_round_pd((__m256d)a, 0x0b));
#endif
#if defined(__SSE4_1__)
    if constexpr (width == 2) return Numbers(_mm_round_pd((__m128d)a, 0x0b));
#endif
    Numbers result = a;
    for (std::size_t i = 0; i < width; ++i) result[i] = std::trunc(a[i]);
    return result;
  }

  /// Halves away from zero, as std::round: what lies just below a half must not be lifted over it.
  COGGING_INLINE static Numbers round(const Numbers& a) {
    const Numbers below_half = of(0.49999999999999994);
    return trunc(a + Numbers(Mask(below_half) | (Mask(a) & sign_bit())));
  }

  COGGING_INLINE static Numbers atan(const Numbers& value) {
    const Numbers x = abs(value), one = of(1.0), zero = of(0.0);
    const Mask b1 = x >= 0.4375, b2 = x >= 0.6875, b3 = x >= 1.1875, b4 = x >= 2.4375;
    const Numbers above = b4 ? -one : b3 ? x - 1.5 : b2 ? x - 1.0 : b1 ? 2.0 * x - 1.0 : x;
    const Numbers below = b4 ? x : b3 ? 1.0 + 1.5 * x : b2 ? x + 1.0 : b1 ? 2.0 + x : one;
    const Numbers t = above / below;
    const Numbers high = b4   ? of(elementary::atan_high[3])
                         : b3 ? of(elementary::atan_high[2])
                         : b2 ? of(elementary::atan_high[1])
                         : b1 ? of(elementary::atan_high[0])
                              : zero;
    const Numbers low = b4   ? of(elementary::atan_low[3])
                        : b3 ? of(elementary::atan_low[2])
                        : b2 ? of(elementary::atan_low[1])
                        : b1 ? of(elementary::atan_low[0])
                             : zero;
    const Numbers result = high - ((t * elementary::atan_series(t) - low) - t);
    return value < 0.0 ? -result : result;
  }

  /// Below a million radians.
  COGGING_INLINE static void sin_cos(const Numbers& angle, Numbers& sine, Numbers& cosine) {
    const Numbers shifted = angle * elementary::two_over_pi + elementary::round_shift;
    const Numbers turns = shifted - elementary::round_shift;
    const Mask quadrant = Mask(shifted);  // its last bits count the quarter turns
    Numbers sine_r, cosine_r;
    elementary::quarter_sin_cos(angle, turns, sine_r, cosine_r);
    const Mask odd = (quadrant & 1) != 0;
    const Numbers s = odd ? cosine_r : sine_r, c = odd ? sine_r : cosine_r;
    sine = Numbers(Mask(s) ^ ((quadrant & 2) << 62));
    cosine = Numbers(Mask(c) ^ (((quadrant + 1) & 2) << 62));
  }

 private:
  COGGING_INLINE static Mask sign_bit() { return Mask{} + std::numeric_limits<std::int64_t>::min(); }
};

#endif

}  // namespace cogging
