#pragma once
// What a search needs to know of a parameter that it has never heard of: whether the law is linear in it, and
// over which range it is worth looking.

#include <string_view>

namespace cogging {

enum class Role {
  setting,    // chosen, never searched for: an order, knots
  amplitude,  // the law is linear in it and vanishes at its neutral value
  shape       // the law is not linear in it
};

/// What a parameter is measured against: `low` and `high` are multiples of this value of a log.
enum class Quantity {
  one,                         // 1
  relative,                    // 1, a share of something
  exponent,                    // 1
  force,                       // V: largest |command|
  command,                     // V: largest |command|, of a parameter that lives on the command's axis
  friction,                    // V: the Coulomb level
  force_per_position,          // V/m: largest |command| over length of the travel
  force_per_velocity,          // V/(m/s): largest |command| over largest speed
  force_per_velocity_squared,  // V/(m/s)^2: largest |command| over largest speed squared
  stiffness,                   // V/m: the Coulomb level over length of the travel
  position,                    // m: a place, 0 = lower end and 1 = upper end of the travel
  distance,                    // m: length of the travel
  angle,                       // rad: one turn, 2 pi
  velocity,                    // m/s: largest speed
  time,                        // s: duration
  sample_time,                 // s: between two samples
  frequency                    // Hz: half the sample rate
};

constexpr std::string_view to_string(Role role) {
  constexpr std::string_view names[] = {"setting", "amplitude", "shape"};
  return names[static_cast<int>(role)];
}

constexpr std::string_view to_string(Quantity quantity) {
  constexpr std::string_view names[] = {"one",
                                        "relative",
                                        "exponent",
                                        "force",
                                        "command",
                                        "friction",
                                        "force_per_position",
                                        "force_per_velocity",
                                        "force_per_velocity_squared",
                                        "stiffness",
                                        "position",
                                        "distance",
                                        "angle",
                                        "velocity",
                                        "time",
                                        "sample_time",
                                        "frequency"};
  return names[static_cast<int>(quantity)];
}

struct Trait {
  Role role = Role::setting;
  Quantity quantity = Quantity::one;
  double low = 0.0, high = 0.0;  // multiples of the quantity's value; of an amplitude: plausible, not binding
  bool logarithmic = false;      // step evenly in the logarithm
  bool vanishes = false;         // at its default the whole effect does nothing
};

constexpr Trait amplitude(Quantity quantity, double high = 1.0) {
  return {Role::amplitude, quantity, -high, high, false, true};
}
/// An amplitude that the effect's name gives a sign.
constexpr Trait positive_amplitude(Quantity quantity, double high = 1.0) {
  return {Role::amplitude, quantity, 0.0, high, false, true};
}
constexpr Trait linear_shape(Quantity quantity, double low, double high) {
  return {Role::shape, quantity, low, high, false, false};
}
constexpr Trait logarithmic_shape(Quantity quantity, double low, double high) {
  return {Role::shape, quantity, low, high, true, false};
}
/// The same, of a parameter at whose default the effect does nothing, whatever the others are.
constexpr Trait vanishing(Trait trait) {
  trait.vanishes = true;
  return trait;
}

}  // namespace cogging
