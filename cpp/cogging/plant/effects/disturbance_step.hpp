#pragma once
// A force that acts for a while.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// A force from `start` (included) to `stop` (excluded), V. Integration steps end at both.
template <class Scalar = double>
struct DisturbanceStep {
  static constexpr std::string_view name = "disturbance_step";
  static constexpr std::string_view law = "force for start <= t < stop, else 0";

  Scalar level = 0.0;      // V
  double start = 0.0;      // s
  double stop = infinity;  // s

  static constexpr auto fields() {
    using E = DisturbanceStep;
    return std::tuple{
        Field{"force", &E::level, "V", "pushes towards +x", amplitude(Quantity::force)},
        Field{"start", &E::start, "s", "time at which it begins", linear_shape(Quantity::time, 0.0, 1.0)},
        Field{"stop", &E::stop, "s", "time at which it ends", Rule::any, linear_shape(Quantity::time, 0.0, 1.0)}};
  }
  static Kinds kinds() { return {Window{"start", "stop"}}; }
  void validate() const { require(stop > start, "stop", "must be above start = " + format(start), stop); }

  Scalar force(const Motion<Scalar>& motion) const {
    return motion.time >= start && motion.time < stop ? level : Scalar(0.0);
  }
  double next_event(double time) const { return time < start ? start : (time < stop ? stop : infinity); }
};

}  // namespace cogging
