#pragma once
// Small commands do nothing.

#include <tuple>

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
    return std::tuple{Field<E, Scalar>{"width", &E::width, "V", "half of the zone: largest command that does nothing",
                                       vanishing(linear_shape(Quantity::command, 0.0, 0.5))}};
  }
  void validate() const { require_not_negative("width", width); }

  Scalar shape_command(const Scalar& command) const { return command - clamp(command, -width, width); }
};

}  // namespace cogging
