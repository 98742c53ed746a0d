#pragma once
// A force at one place: a defect of the guide, a joint, a snag.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// force exp(-((x - center) / width)^2), V.
template <class Scalar = double>
struct LocalForce {
  static constexpr std::string_view name = "local_force";
  static constexpr std::string_view law = "force exp(-((x - center) / width)^2)";

  Scalar level = 0.0;   // V
  Scalar center = 0.0;  // m
  Scalar width = 0.01;  // m

  static constexpr auto fields() {
    using E = LocalForce;
    return std::tuple{
        Field{"force", &E::level, "V", "at the center, towards +x", amplitude(Quantity::force)},
        Field{"center", &E::center, "m", "place of the largest force", linear_shape(Quantity::position, 0.0, 1.0)},
        Field{"width", &E::width, "m", "distance from the center at which it has fallen to 1/e", Rule::positive,
              logarithmic_shape(Quantity::distance, 0.002, 0.1)}};
  }
  static Kinds kinds() { return {Place{"center", "width"}}; }

  Scalar force(const Motion<Scalar>& motion) const {
    const Scalar distance = (motion.position - center) / width;
    return level * exp(-(distance * distance));
  }
  // The fourth derivative, which decides what a step misses, is 12 force / width^4 at the center.
  Variation variation() const { return {.force = largest(abs(level)), .wavenumber = 1.87 / smallest(width)}; }
};

}  // namespace cogging
