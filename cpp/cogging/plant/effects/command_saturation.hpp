#pragma once
// Large commands are cut.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// The command cut to [-limit, limit], V. The controller does not know of it (its own is `command_limit`).
template <class Scalar = double>
struct CommandSaturation {
  static constexpr std::string_view name = "command_saturation";
  static constexpr std::string_view law = "min(max(u, -limit), limit)";

  Scalar limit = infinity;  // V

  static constexpr auto fields() {
    return std::tuple{Field{"limit", &CommandSaturation::limit, "V", "largest command that passes; infinite = none",
                            Rule::above_0, vanishing(logarithmic_shape(Quantity::command, 0.1, 1.0))}};
  }

  Scalar shape_command(const Scalar& command) const { return clamp(command, -limit, limit); }
};

}  // namespace cogging
