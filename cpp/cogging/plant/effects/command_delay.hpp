#pragma once
// The command acts later than it was computed.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// A pure delay of any length, s: whole samples and the fraction of one. Until the first command arrives, 0 V
/// act.
template <class Scalar = double>
struct CommandDelay {
  static constexpr std::string_view name = "command_delay";
  static constexpr std::string_view law = "u(t - delay)";

  double delay = 0.0;  // s

  static constexpr auto fields() {
    return std::tuple{Field{"delay", &CommandDelay::delay, "s", "from computed to acting", Rule::not_negative,
                            vanishing(linear_shape(Quantity::sample_time, 0.0, 50.0))}};
  }

  double command_delay() const { return delay; }
};

}  // namespace cogging
