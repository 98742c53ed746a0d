#pragma once
// Controllers are kept and copied with all that they have learned.

#include <tuple>
#include <type_traits>

#include "cogging/require.hpp"

/// Calls visit(number) for every number of a controller's state, in order.
template <class State, class Visitor>
void for_each_number(State& state, const Visitor& visit) {
  if constexpr (std::is_arithmetic_v<State>) {
    visit(state);
  } else if constexpr (requires { state.state(); }) {
    std::apply([&](auto&... part) { (for_each_number(part, visit), ...); }, state.state());
  } else {
    for (auto& entry : state) for_each_number(entry, visit);
  }
}

template <class C>
std::vector<double> numbers_of(C controller) {
  std::vector<double> numbers;
  for_each_number(controller, [&](const auto& number) { numbers.push_back(static_cast<double>(number)); });
  return numbers;
}

template <class C>
void set_numbers(C& controller, const std::vector<double>& numbers) {
  if (numbers.size() != numbers_of(controller).size())
    cogging::refuse("state", "must be that of a controller of this version",
                    cogging::format(numbers.size()) + " numbers");
  auto next = numbers.begin();
  for_each_number(controller,
                  [&](auto& number) { number = static_cast<std::remove_reference_t<decltype(number)>>(*next++); });
}
