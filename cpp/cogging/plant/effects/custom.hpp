#pragma once
// An effect of somebody's own, whose laws are functions.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cogging/plant/effect.hpp"

namespace cogging {

/// Where an axis was: one entry a moment, m, m/s and s.
struct Course {
  std::span<const double> position, velocity, time;
};

/// A function of position (m), velocity (m/s) and time (s, from the first row), its parameters inside it.
///
/// It is pure: the same numbers give the same bits, from any thread. It may throw.
class OwnLaw {
 public:
  virtual ~OwnLaw() = default;

  virtual double at(double position, double velocity, double time) const = 0;

  /// The same along a course; `values` is as long as it.
  virtual void along(const Course& course, std::span<double> values) const {
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = at(course.position[k], course.velocity[k], course.time[k]);
  }

  /// Whether one thread at a time can be in it (an interpreter's lock): more threads then gain nothing.
  virtual bool serial() const { return false; }
};

/// " at position 0.1, velocity 0.2, time 3 s"
inline std::string place_of(double position, double velocity, double time) {
  return " at position " + format(position) + ", velocity " + format(velocity) + ", time " + format(time) + " s";
}

/// Any of four laws: a force (V), what is added to the Coulomb level (V) and to the gain 1 of the command, and by how
/// much the encoder reads too much (m).
///
/// Nothing is known of how quickly they change. So no step of the integrator passes for accurate before it has been
/// looked at as one in which a law has a kink or a jump; and what is narrower than the path, or the time, between two
/// moments at which a law is asked (half a step) must be stated as a scale, or it is passed over.
template <class Scalar = double>
struct Custom {
  static constexpr std::string_view name = "custom";

  using Law = std::shared_ptr<const OwnLaw>;

  std::string label;                   // its own name, for messages
  std::array<Law, 4> laws;             // each at the place of its Hook; null where it has none
  double length_scale = infinity;      // m, the shortest on which a law changes
  double velocity_scale = infinity;    // m/s
  double time_scale = infinity;        // s
  std::shared_ptr<const void> origin;  // what its maker knows it by

  void validate() const {
    require(std::any_of(laws.begin(), laws.end(), [](const Law& law) { return law != nullptr; }), label,
            "must have at least one law, has", 0);
    for (const auto& [scale, value] :
         {std::pair("length_scale", length_scale), std::pair("velocity_scale", velocity_scale),
          std::pair("time_scale", time_scale)})
      require(value > 0.0, scale, "must be above 0 (infinite = not stated)", value);
  }

  const OwnLaw* law_of(Hook hook) const { return laws[static_cast<std::size_t>(hook)].get(); }
  bool uses(Hook hook) const { return law_of(hook) != nullptr; }
  bool serial() const {
    return std::any_of(laws.begin(), laws.end(), [](const Law& law) { return law != nullptr && law->serial(); });
  }

  Scalar force(const Motion<Scalar>& motion) const {
    return value(Hook::force, motion.position, motion.velocity, motion.time);
  }
  Scalar friction_level(const Motion<Scalar>& motion) const {
    return value(Hook::friction_level, motion.position, motion.velocity, motion.time);
  }
  Scalar command_gain(const Scalar& position, double time) const {
    return value(Hook::command_gain, position, Scalar(0.0), time);
  }
  Scalar reading_error(const Scalar& position) const { return value(Hook::reading_error, position, Scalar(0.0), 0.0); }

  /// One law at one moment; 0 where it has none.
  Scalar value(Hook hook, const Scalar& position, const Scalar& velocity, double time) const {
    const OwnLaw* law = law_of(hook);
    Scalar values = 0.0;
    if (law == nullptr) return values;
    for (std::size_t i = 0; i < lanes_of<Scalar>; ++i) {
      const double x = lane(position, i), v = lane(velocity, i);
      const double one = law->at(x, v, time);
      // Where the run itself has left the numbers, the run says so.
      if (!std::isfinite(one) && std::isfinite(x) && std::isfinite(v)) refuse_value(hook, one, x, v, time);
      set_lane(values, i, one);
    }
    return values;
  }

  /// One law at each moment of a course; zeros where it has none.
  std::vector<double> along(Hook hook, const Course& course) const {
    std::vector<double> values(course.position.size(), 0.0);
    if (const OwnLaw* law = law_of(hook)) {
      law->along(course, values);
      for (std::size_t k = 0; k < values.size(); ++k)
        if (!std::isfinite(values[k]))
          refuse_value(hook, values[k], course.position[k], course.velocity[k], course.time[k]);
    }
    return values;
  }

  Variation variation() const {
    Variation told;
    told.rough = uses(Hook::force) || uses(Hook::friction_level) || uses(Hook::command_gain);
    if (told.rough) told.path = length_scale, told.change = velocity_scale, told.duration = time_scale;
    return told;
  }

 private:
  [[noreturn]] COGGING_NOINLINE void refuse_value(Hook hook, double got, double x, double v, double time) const {
    throw DivergedError(label + "." + std::string(to_string(hook)) + ": must be a finite number, got " + format(got) +
                            place_of(x, v, time),
                        time);
  }
};

}  // namespace cogging
