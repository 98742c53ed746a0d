#pragma once
// A force constant that drifts in time: warm magnets, warm coils.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// The motor pushes with u (1 + change (1 - exp(-t / time_constant))), t from the first row.
template <class Scalar = double>
struct ForceConstantDrift {
  static constexpr std::string_view name = "force_constant_drift";
  static constexpr std::string_view law = "u (1 + change (1 - exp(-t / time_constant)))";

  Scalar change = 0.0;
  Scalar time_constant = 60.0;  // s

  static constexpr auto fields() {
    using E = ForceConstantDrift;
    return std::tuple{Field{"change", &E::change, "1", "relative, after a long time", amplitude(Quantity::relative)},
                      Field{"time_constant", &E::time_constant, "s", "of the drift", Rule::positive,
                            logarithmic_shape(Quantity::time, 0.02, 5.0)}};
  }

  Scalar command_gain(const Scalar&, double time) const { return change * (1.0 - exp(Scalar(-time) / time_constant)); }
  Variation variation() const {
    return {.gain = largest(abs(change)), .rate = 1.0 / smallest(time_constant), .decay = 1.0 / largest(time_constant)};
  }
};

}  // namespace cogging
