#pragma once
// A first-order current loop.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// time_constant df/dt = u - f, solved exactly for the held command; starts at 0 V.
template <class Scalar = double>
struct ActuatorLag {
  static constexpr std::string_view name = "actuator_lag";
  static constexpr std::string_view law = "u / (time_constant s + 1)";

  Scalar time_constant = 0.0;  // s

  static constexpr auto fields() {
    return std::tuple{Field{"time_constant", &ActuatorLag::time_constant, "s", "of the current loop",
                            Rule::not_negative, vanishing(logarithmic_shape(Quantity::sample_time, 0.1, 100.0))}};
  }

  Scalar lag_time_constant() const { return time_constant; }
};

}  // namespace cogging
