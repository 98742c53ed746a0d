#pragma once
// A cable chain or bellows that pulls towards one position.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// A force linear in position: -stiffness (x - center), V.
template <class Scalar = double>
struct CableSpring {
  static constexpr std::string_view name = "cable_spring";
  static constexpr std::string_view law = "-stiffness (x - center)";

  Scalar stiffness = 0.0;  // V/m
  Scalar center = 0.0;     // m

  static constexpr auto fields() {
    using E = CableSpring;
    return std::tuple{
        Field{"stiffness", &E::stiffness, "V/m", "force a metre of distance", amplitude(Quantity::force_per_position)},
        Field{"center", &E::center, "m", "where the spring is slack", linear_shape(Quantity::position, 0.0, 1.0)}};
  }

  Scalar force(const Motion<Scalar>& motion) const { return stiffness * (center - motion.position); }

  Variation variation() const { return {.stiffness = largest(abs(stiffness))}; }
};

}  // namespace cogging
