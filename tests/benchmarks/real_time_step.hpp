#pragma once
// One sample of every controller of the core's list, as a loop calls it.

#include <array>
#include <cstddef>
#include <variant>

#include "cogging/control/list.hpp"

namespace real_time {

inline constexpr std::size_t controllers = std::variant_size_v<cogging::AnyController<>>;

template <std::size_t number>
using Listed = std::variant_alternative_t<number, cogging::AnyController<>>;

/// Command and update of a controller that lies at `memory`; gives the command (V) that is applied, cut at its limit.
/// `ahead` is the reference at the time that a controller looks ahead to.
using Step = double (*)(void* memory, const cogging::ReferencePoint& reference, const cogging::ReferencePoint& ahead,
                        double reading);

/// By the number in the list, each defined in real_time_step.cpp.
extern const std::array<Step, controllers> steps;

}  // namespace real_time
