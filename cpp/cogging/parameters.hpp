#pragma once
// A parameter struct says once, in `fields()`, what its members are called, their unit, what they mean and their rule.
// The bindings, the model files and the packing of many machines into lanes all read that list.

#include <tuple>
#include <type_traits>

#include "cogging/inlining.hpp"
#include "cogging/require.hpp"
#include "cogging/trait.hpp"

namespace cogging {

/// What a real number, or each of a list, must be: finite, unless its field says otherwise. `above_0` may be infinite,
/// a `share` is at least 0 and below 1, and `any` leaves it to the struct's own validate().
enum class Rule { finite, not_negative, positive, period, above_0, share, any };

template <class Struct, class Member>
struct Field {
  constexpr Field(std::string_view its_name, Member Struct::* its_member, std::string_view its_unit,
                  std::string_view its_meaning, Rule its_rule = Rule::finite, const Trait& its_trait = {})
      : name(its_name), member(its_member), unit(its_unit), meaning(its_meaning), rule(its_rule), trait(its_trait) {}
  constexpr Field(std::string_view its_name, Member Struct::* its_member, std::string_view its_unit,
                  std::string_view its_meaning, const Trait& its_trait)
      : Field(its_name, its_member, its_unit, its_meaning, Rule::finite, its_trait) {}

  std::string_view name;
  Member Struct::* member;
  std::string_view unit;
  std::string_view meaning;
  Rule rule;
  Trait trait;  // of the effects' parameters
};

/// Calls visit(field) for each field of Struct, in order.
template <class Struct, class Visitor>
void for_each_field(Visitor&& visit) {
  static constexpr auto fields = Struct::fields();
  std::apply([&](const auto&... field) { (visit(field), ...); }, fields);
}

template <class Member>
COGGING_NOINLINE void require_rule(Rule rule, std::string_view name, const Member& value) {
  if constexpr (requires { value.begin(); }) {
    for (const auto& entry : value) require_rule(rule, name, entry);
  } else if constexpr (!std::is_integral_v<Member>) {
    if (rule == Rule::finite) require_finite(name, value);
    if (rule == Rule::not_negative) require_not_negative(name, value);
    if (rule == Rule::positive) require_positive(name, value);
    if (rule == Rule::period) require_period(name, value);
    if (rule == Rule::above_0) require(value > 0.0, name, "must be above 0 (infinite = none)", value);
    if (rule != Rule::share) return;
    for (const auto& holds : {value >= 0.0, value < 1.0}) require(holds, name, "must be at least 0 and below 1", value);
  }
}

/// The struct, whose rules all hold: those of its fields, then those of its validate(), where it has one. What a
/// constructor that takes one begins with.
///
/// Raises std::invalid_argument, naming the field.
template <class Struct>
const Struct& validated(const Struct& parameters) {
  if constexpr (requires { Struct::fields(); })
    for_each_field<Struct>([&](const auto& f) { require_rule(f.rule, f.name, parameters.*(f.member)); });
  if constexpr (requires { parameters.validate(); }) parameters.validate();
  return parameters;
}

}  // namespace cogging
