#pragma once
// An extra force close to the ends of the travel.

#include <cmath>

#include "cogging/plant/effect.hpp"

namespace cogging {

/// force (exp(-(x1 - x) / decay_length) - exp(-(x - x0) / decay_length)), V: pushes out of the travel [x0, x1]
/// where positive, at the ends by `force`.
template <class Scalar = double>
struct EndEffect {
  static constexpr std::string_view name = "end_effect";
  static constexpr std::string_view law = "force (exp(-(x1 - x) / decay_length) - exp(-(x - x0) / decay_length))";

  Scalar level = 0.0;                    // V
  Scalar decay_length = 0.01;            // m
  Range travel = PlantContext().travel;  // m

  static constexpr auto fields() {
    using E = EndEffect;
    return std::tuple{
        Field{"force", &E::level, "V", "at an end, outwards", amplitude(Quantity::force)},
        Field{"decay_length", &E::decay_length, "m", "distance from the end at which it has fallen to 1/e",
              Rule::positive, logarithmic_shape(Quantity::distance, 0.005, 0.5)},
        Field{"travel", &E::travel, "m", "ends x0, x1 from which it is measured; infinite = of [axis]", Rule::any}};
  }
  static Kinds kinds() { return {Travel{"travel"}}; }
  void validate() const { require_travel(travel); }

  void bind(const PlantContext& plant) {
    for (int end : {0, 1})
      if (!std::isfinite(travel[end])) travel[end] = plant.travel[end];
    for (double end : travel)
      require(std::isfinite(end) || all(level == 0.0), "end_effect.travel", "needs two ends, here or in [axis]", end);
  }

  Scalar force(const Motion<Scalar>& motion) const {
    return level *
           (exp((motion.position - travel[1]) / decay_length) - exp((travel[0] - motion.position) / decay_length));
  }
  Variation variation() const { return {.force = largest(abs(level)), .wavenumber = 1.0 / smallest(decay_length)}; }
};

}  // namespace cogging
