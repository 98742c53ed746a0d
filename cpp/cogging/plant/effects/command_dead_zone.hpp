#pragma once
// Small commands do nothing.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// sgn(u) max(|u| - width, 0), V.
template <class Scalar = double>
struct CommandDeadZone {
  static constexpr std::string_view name = "command_dead_zone";
  static constexpr std::string_view law = "sgn(u) max(|u| - width, 0)";

  Scalar width = 0.0;  // V

  static constexpr auto fields() {
    using E = CommandDeadZone;
    return std::tuple{Field{"width", &E::width, "V", "half of the zone: largest command that does nothing",
                            Rule::not_negative, vanishing(linear_shape(Quantity::command, 0.0, 0.5))}};
  }

  Scalar shape_command(const Scalar& command) const { return command - clamp(command, -width, width); }
};

}  // namespace cogging
