// The steps and nothing beside them: what this unit calls, and how much stack, is what a sample may.

#include "real_time_step.hpp"

#include <utility>

namespace real_time {

template <std::size_t number>
double step(void* memory, const cogging::ReferencePoint& reference, const cogging::ReferencePoint& ahead,
            double reading) {
  auto& controller = *static_cast<Listed<number>*>(memory);
  double command;
  if constexpr (cogging::LooksAhead<Listed<number>>)
    command = controller.command(reference, ahead, reading);
  else
    command = controller.command(reference, reading);
  const double limit = controller.command_limit();
  const double applied = limit > 0.0 ? cogging::clamp(command, -limit, limit) : command;
  controller.update(applied);
  return applied;
}

template <std::size_t... number>
constexpr std::array<Step, controllers> all(std::index_sequence<number...>) {
  return {&step<number>...};
}
constexpr std::array<Step, controllers> steps = all(std::make_index_sequence<controllers>{});

}  // namespace real_time
