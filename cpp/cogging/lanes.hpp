#pragma once
// A pack of independent lanes that behaves like a number: the hot code runs many machines at once with it.
// Lanes share what decides the course of a step: the event times, that friction is smooth (the exact one, with
// sticking, runs on `double` alone), and whether there is a current loop; where they do not, a plant of them is
// refused. A run ends when one lane diverges.

#include <array>
#include <cstddef>
#include <string_view>

#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

template <class Value, std::size_t count>
struct Pack {
  std::array<Value, count> lane;  // no zeros by default: scratch arrays of lanes are large

  Pack() = default;
  Pack(Value value) { lane.fill(value); }  // NOLINT: a number is a pack of equal lanes

  template <class Function>
  static Pack map(Function function) {
    Pack result;
    for (std::size_t i = 0; i < count; ++i) result.lane[i] = function(i);
    return result;
  }

#define COGGING_PACK_ARITHMETIC(op)                                             \
  friend Pack operator op(const Pack& a, const Pack& b) {                       \
    return map([&](std::size_t i) -> Value { return a.lane[i] op b.lane[i]; }); \
  }                                                                             \
  Pack& operator op##=(const Pack & other) { return *this = *this op other; }
  COGGING_PACK_ARITHMETIC(+)
  COGGING_PACK_ARITHMETIC(-)
  COGGING_PACK_ARITHMETIC(*)
  COGGING_PACK_ARITHMETIC(/)
#undef COGGING_PACK_ARITHMETIC

#define COGGING_PACK_COMPARISON(op)                                                               \
  friend Pack<bool, count> operator op(const Pack & a, const Pack & b) {                          \
    return Pack<bool, count>::map([&](std::size_t i) -> bool { return a.lane[i] op b.lane[i]; }); \
  }
  COGGING_PACK_COMPARISON(<)
  COGGING_PACK_COMPARISON(>)
  COGGING_PACK_COMPARISON(<=)
  COGGING_PACK_COMPARISON(>=)
  COGGING_PACK_COMPARISON(==)
#undef COGGING_PACK_COMPARISON

  friend Pack operator-(const Pack& a) {
    return map([&](std::size_t i) -> Value { return -a.lane[i]; });
  }
};

template <std::size_t count>
using Lanes = Pack<double, count>;

#define COGGING_LANES_FUNCTION(function)                                                   \
  template <std::size_t count>                                                             \
  Lanes<count> function(const Lanes<count>& a) {                                           \
    return Lanes<count>::map([&](std::size_t i) { return cogging::function(a.lane[i]); }); \
  }
COGGING_LANES_FUNCTION(abs)
COGGING_LANES_FUNCTION(atan)
COGGING_LANES_FUNCTION(exp)
COGGING_LANES_FUNCTION(round)
COGGING_LANES_FUNCTION(tanh)
COGGING_LANES_FUNCTION(sign)
#undef COGGING_LANES_FUNCTION

template <std::size_t count>
Lanes<count> pow(const Lanes<count>& base, const Lanes<count>& exponent) {
  return Lanes<count>::map([&](std::size_t i) { return std::pow(base.lane[i], exponent.lane[i]); });
}
template <std::size_t count>
Lanes<count> select(const Pack<bool, count>& condition, const Lanes<count>& if_true, const Lanes<count>& if_false) {
  return Lanes<count>::map([&](std::size_t i) { return condition.lane[i] ? if_true.lane[i] : if_false.lane[i]; });
}
template <std::size_t count>
Lanes<count> clamp(const Lanes<count>& value, const Lanes<count>& lower, const Lanes<count>& upper) {
  return Lanes<count>::map([&](std::size_t i) { return clamp(value.lane[i], lower.lane[i], upper.lane[i]); });
}
template <std::size_t count>
void sin_cos(const Lanes<count>& angle, Lanes<count>& sine, Lanes<count>& cosine) {
  for (std::size_t i = 0; i < count; ++i) sin_cos(angle.lane[i], sine.lane[i], cosine.lane[i]);
}
template <std::size_t count>
double largest(const Lanes<count>& values) {
  double result = values.lane[0];
  for (double value : values.lane) result = value > result ? value : result;
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
  return value.lane[i];
}
template <std::size_t count>
void set_lane(Lanes<count>& value, std::size_t i, double lane_value) {
  value.lane[i] = lane_value;
}

template <std::size_t count>
bool all(const Pack<bool, count>& condition) {
  for (bool value : condition.lane)
    if (!value) return false;
  return true;
}
template <std::size_t count>
bool all_finite(const Lanes<count>& value) {
  for (double entry : value.lane)
    if (!std::isfinite(entry)) return false;
  return true;
}
/// A rule holds where it holds in every lane.
template <std::size_t count>
void require(const Pack<bool, count>& holds, std::string_view name, std::string_view rule, const Lanes<count>& value) {
  for (std::size_t i = 0; i < count; ++i) require(holds.lane[i], name, rule, value.lane[i]);
}
#define COGGING_LANES_RULE(rule)                                 \
  template <std::size_t count>                                   \
  void rule(std::string_view name, const Lanes<count>& values) { \
    for (double value : values.lane) rule(name, value);          \
  }
COGGING_LANES_RULE(require_finite)
COGGING_LANES_RULE(require_positive)
COGGING_LANES_RULE(require_not_negative)
#undef COGGING_LANES_RULE

template <std::size_t count>
struct IndexOf<Lanes<count>> {
  using type = Pack<int, count>;
};
template <std::size_t count>
Pack<int, count> truncate_to_index(const Lanes<count>& value) {
  return Pack<int, count>::map([&](std::size_t i) { return truncate_to_index(value.lane[i]); });
}
template <std::size_t count>
Pack<int, count> clamp_index(const Pack<int, count>& value, int lower, int upper) {
  return Pack<int, count>::map([&](std::size_t i) { return clamp_index(value.lane[i], lower, upper); });
}
template <std::size_t count>
Lanes<count> from_index(const Pack<int, count>& value) {
  return Lanes<count>::map([&](std::size_t i) { return from_index(value.lane[i]); });
}
template <std::size_t count>
Lanes<count> gather(const Lanes<count>* table, const Pack<int, count>& index) {
  return Lanes<count>::map([&](std::size_t i) { return table[index.lane[i]].lane[i]; });
}
template <std::size_t count>
void scatter(Lanes<count>* table, const Pack<int, count>& index, const Lanes<count>& value) {
  for (std::size_t i = 0; i < count; ++i) table[index.lane[i]].lane[i] = value.lane[i];
}

}  // namespace cogging
