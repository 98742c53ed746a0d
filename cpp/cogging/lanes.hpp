#pragma once
// A pack of independent lanes that behaves like a number: the hot code runs many machines at once with it.
// Each lane has the bits that it would have alone. Lanes share what decides the course of a step: the event times, that
// friction is smooth (the exact one, with sticking, runs on `double` alone), and whether there is a current loop; where
// they do not, a plant of them is refused.

#include "cogging/registers.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// What holds in each lane.
template <std::size_t count>
struct LaneMask {
  static constexpr std::size_t width = std::min(count, register_width), parts = count / width;
  static_assert(parts * width == count);
  typename Register<width>::Mask part[parts];

  LaneMask() = default;
  COGGING_INLINE LaneMask(bool value) {  // NOLINT: one condition is a mask of equal lanes
    for (auto& p : part) p = Register<width>::mask_of(value);
  }
  COGGING_INLINE bool operator[](std::size_t i) const { return Register<width>::holds(part[i / width], i % width); }
};

template <std::size_t count>
struct Lanes {
  static constexpr std::size_t width = std::min(count, register_width), parts = count / width;
  static_assert(parts * width == count);
  typename Register<width>::Numbers part[parts];

  Lanes() = default;                    // no zeros by default: scratch arrays of lanes are large
  COGGING_INLINE Lanes(double value) {  // NOLINT: a number is a pack of equal lanes
    for (auto& p : part) p = Register<width>::of(value);
  }
  COGGING_INLINE double operator[](std::size_t i) const { return Register<width>::get(part[i / width], i % width); }
  COGGING_INLINE void set(std::size_t i, double value) { Register<width>::set(part[i / width], i % width, value); }

  template <class Function>
  static Lanes map(const Function& function) {
    Lanes result;
    for (std::size_t i = 0; i < count; ++i) result.set(i, function(i));
    return result;
  }

#define COGGING_LANES_ARITHMETIC(op)                                                 \
  COGGING_INLINE friend Lanes operator op(const Lanes& a, const Lanes& b) {          \
    Lanes result;                                                                    \
    for (std::size_t p = 0; p < parts; ++p) result.part[p] = a.part[p] op b.part[p]; \
    return result;                                                                   \
  }                                                                                  \
  COGGING_INLINE Lanes& operator op##=(const Lanes & other) { return *this = *this op other; }
  COGGING_LANES_ARITHMETIC(+)
  COGGING_LANES_ARITHMETIC(-)
  COGGING_LANES_ARITHMETIC(*)
  COGGING_LANES_ARITHMETIC(/)
#undef COGGING_LANES_ARITHMETIC

#define COGGING_LANES_COMPARISON(op)                                                    \
  COGGING_INLINE friend LaneMask<count> operator op(const Lanes & a, const Lanes & b) { \
    LaneMask<count> result;                                                             \
    for (std::size_t p = 0; p < parts; ++p) result.part[p] = a.part[p] op b.part[p];    \
    return result;                                                                      \
  }
  COGGING_LANES_COMPARISON(<)
  COGGING_LANES_COMPARISON(>)
  COGGING_LANES_COMPARISON(<=)
  COGGING_LANES_COMPARISON(>=)
  COGGING_LANES_COMPARISON(==)
#undef COGGING_LANES_COMPARISON

  COGGING_INLINE friend Lanes operator-(const Lanes& a) {
    Lanes result;
    for (std::size_t p = 0; p < parts; ++p) result.part[p] = -a.part[p];
    return result;
  }
};

// Of whole registers, each lane with the bits of the function for a number.
#define COGGING_LANES_OF_REGISTERS(function)                                                           \
  template <std::size_t count>                                                                         \
  COGGING_INLINE Lanes<count> function(const Lanes<count>& a) {                                        \
    Lanes<count> result;                                                                               \
    for (std::size_t p = 0; p < a.parts; ++p) result.part[p] = Register<a.width>::function(a.part[p]); \
    return result;                                                                                     \
  }
COGGING_LANES_OF_REGISTERS(abs)
COGGING_LANES_OF_REGISTERS(atan)
COGGING_LANES_OF_REGISTERS(round)
#undef COGGING_LANES_OF_REGISTERS

#define COGGING_LANES_ONE_BY_ONE(function)                                            \
  template <std::size_t count>                                                        \
  Lanes<count> function(const Lanes<count>& a) {                                      \
    return Lanes<count>::map([&](std::size_t i) { return cogging::function(a[i]); }); \
  }
COGGING_LANES_ONE_BY_ONE(exp)
COGGING_LANES_ONE_BY_ONE(tanh)
COGGING_LANES_ONE_BY_ONE(sign)
#undef COGGING_LANES_ONE_BY_ONE

template <std::size_t count>
Lanes<count> pow(const Lanes<count>& base, const Lanes<count>& exponent) {
  return Lanes<count>::map([&](std::size_t i) { return cogging::pow(base[i], exponent[i]); });
}
template <std::size_t count>
COGGING_INLINE Lanes<count> select(const LaneMask<count>& condition, const Lanes<count>& if_true,
                                   const Lanes<count>& if_false) {
  Lanes<count> result;
  for (std::size_t p = 0; p < result.parts; ++p)
    result.part[p] = condition.part[p] ? if_true.part[p] : if_false.part[p];
  return result;
}
template <std::size_t count>
COGGING_INLINE Lanes<count> clamp(const Lanes<count>& value, const Lanes<count>& lower, const Lanes<count>& upper) {
  const Lanes<count> raised = select(lower > value, lower, value);
  return select(upper < raised, upper, raised);
}
template <std::size_t count>
COGGING_INLINE void sin_cos(const Lanes<count>& angle, Lanes<count>& sine, Lanes<count>& cosine) {
  if (!all(abs(angle) < 1e6)) [[unlikely]] {
    for (std::size_t i = 0; i < count; ++i) {
      double s, c;
      sin_cos(angle[i], s, c);
      sine.set(i, s), cosine.set(i, c);
    }
    return;
  }
  for (std::size_t p = 0; p < angle.parts; ++p)
    Register<angle.width>::sin_cos(angle.part[p], sine.part[p], cosine.part[p]);
}
template <std::size_t count>
double largest(const Lanes<count>& values) {
  double result = values[0];
  for (std::size_t i = 1; i < count; ++i) result = values[i] > result ? values[i] : result;
  return result;
}
template <std::size_t count>
double smallest(const Lanes<count>& values) {
  return -largest(-values);
}
template <std::size_t count>
inline constexpr std::size_t lanes_of<Lanes<count>> = count;
template <std::size_t count>
double lane(const Lanes<count>& value, std::size_t i) {
  return value[i];
}
template <std::size_t count>
void set_lane(Lanes<count>& value, std::size_t i, double lane_value) {
  value.set(i, lane_value);
}

template <std::size_t count>
COGGING_INLINE bool all(const LaneMask<count>& condition) {
  auto together = condition.part[0];
  for (std::size_t p = 1; p < condition.parts; ++p) together = together & condition.part[p];
  return Register<condition.width>::all(together);
}
template <std::size_t count>
COGGING_INLINE bool all_finite(const Lanes<count>& value) {
  return all(value - value == Lanes<count>(0.0));
}
/// A rule holds where it holds in every lane.
template <std::size_t count>
void require(const LaneMask<count>& holds, std::string_view name, std::string_view rule, const Lanes<count>& value) {
  for (std::size_t i = 0; i < count; ++i) require(holds[i], name, rule, value[i]);
}
#define COGGING_LANES_RULE(rule)                                   \
  template <std::size_t count>                                     \
  void rule(std::string_view name, const Lanes<count>& values) {   \
    for (std::size_t i = 0; i < count; ++i) rule(name, values[i]); \
  }
COGGING_LANES_RULE(require_finite)
COGGING_LANES_RULE(require_period)
COGGING_LANES_RULE(require_positive)
COGGING_LANES_RULE(require_not_negative)
#undef COGGING_LANES_RULE

/// Whole numbers, and whether they are all the same: then a table is read in one go.
template <std::size_t count>
struct LaneIndex {
  Lanes<count> whole;
  bool same = false;

  int operator[](std::size_t i) const { return static_cast<int>(whole[i]); }
  COGGING_INLINE friend LaneIndex operator*(const LaneIndex& a, int factor) {
    return {a.whole * double(factor), a.same};
  }
};
template <std::size_t count>
struct IndexOf<Lanes<count>> {
  using type = LaneIndex<count>;
};
template <std::size_t count>
COGGING_INLINE LaneIndex<count> truncate_to_index(const Lanes<count>& value, int last) {
  Lanes<count> whole = select(value > 0.0, value, Lanes<count>(0.0));
  for (auto& part : whole.part) part = Register<whole.width>::trunc(part);
  whole = smaller(whole, Lanes<count>(last));
  return {whole, all(whole == Lanes<count>(whole[0]))};
}
template <std::size_t count>
COGGING_INLINE Lanes<count> from_index(const LaneIndex<count>& value) {
  return value.whole;
}
template <std::size_t count, class Function>
COGGING_INLINE decltype(auto) with_index(const LaneIndex<count>& index, const Function& function) {
  if (index.same) [[likely]]
    return function(index[0]);
  return function(index);
}
template <std::size_t count>
COGGING_INLINE const Lanes<count>& gather(const Lanes<count>* table, int index) {
  return table[index];
}
template <std::size_t count>
COGGING_INLINE void scatter(Lanes<count>* table, int index, const Lanes<count>& value) {
  table[index] = value;
}
template <std::size_t count>
Lanes<count> gather(const Lanes<count>* table, const LaneIndex<count>& index) {
  return Lanes<count>::map([&](std::size_t i) { return table[index[i]][i]; });
}
template <std::size_t count>
void scatter(Lanes<count>* table, const LaneIndex<count>& index, const Lanes<count>& value) {
  for (std::size_t i = 0; i < count; ++i) table[index[i]].set(i, value[i]);
}

}  // namespace cogging
