#pragma once
// Offset of the amplifier, tilt of the axis.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// A force that never changes, V; positive pushes towards +x.
template <class Scalar = double>
struct ConstantForce {
  static constexpr std::string_view name = "constant_force";
  static constexpr std::string_view law = "force";

  Scalar level = 0.0;

  static constexpr auto fields() {
    return std::tuple{Field{"force", &ConstantForce::level, "V", "pushes towards +x", amplitude(Quantity::force)}};
  }

  Scalar force(const Motion<Scalar>&) const { return level; }
};

}  // namespace cogging
