#pragma once
// A parameter struct says once, in `fields()`, what its members are called, their unit and what they mean.
// The bindings, the model files and the packing of many machines into lanes all read that list.

#include <string_view>
#include <tuple>

#include "cogging/trait.hpp"

namespace cogging {

template <class Struct, class Member>
struct Field {
  std::string_view name;
  Member Struct::* member;
  std::string_view unit;
  std::string_view meaning;
  Trait trait = {};  // of the effects' parameters
};

/// Calls visit(field) for each field of Struct, in order.
template <class Struct, class Visitor>
constexpr void for_each_field(Visitor&& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, Struct::fields());
}

/// The struct, whose rules all hold; what a constructor that takes one begins with.
///
/// Raises std::invalid_argument, naming the field.
template <class Struct>
const Struct& validated(const Struct& parameters) {
  parameters.validate();
  return parameters;
}

}  // namespace cogging
