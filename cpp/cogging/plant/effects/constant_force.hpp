#pragma once
// Offset of the amplifier, tilt of the axis.

#include <tuple>

#include "cogging/plant/effect.hpp"

namespace cogging {

/// A force that never changes, V; positive pushes towards +x.
template <class Scalar = double>
struct ConstantForce {
  static constexpr std::string_view name = "constant_force";
  static constexpr std::string_view law = "force";

  Scalar level = 0.0;

  static constexpr auto fields() {
    return std::tuple{Field<ConstantForce, Scalar>{"force", &ConstantForce::level, "V", "pushes towards +x",
                                                   amplitude(Quantity::force)}};
  }
  void validate() const { require_finite("force", level); }

  Scalar force(const Motion<Scalar>&) const { return level; }
};

}  // namespace cogging
