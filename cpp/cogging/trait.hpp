#pragma once
// What a search needs to know of a parameter that it has never heard of: whether the law is linear in it, and
// over which range it is worth looking.

#include <string_view>

namespace cogging {

struct Role {
  static constexpr std::string_view setting = "setting";  // chosen, never searched for: an order, knots
  static constexpr std::string_view amplitude =
      "amplitude";                                    // the law is linear in it and vanishes at its neutral value
  static constexpr std::string_view shape = "shape";  // the law is not linear in it
};

/// What a parameter is measured against: `low` and `high` are multiples of this value of a log.
struct Quantity {
  using Name = std::string_view;
  static constexpr Name one = "one";                                // 1
  static constexpr Name relative = "relative";                      // 1, a share of something
  static constexpr Name exponent = "exponent";                      // 1
  static constexpr Name force = "force";                            // V: largest |command|
  static constexpr Name command = "command";                        // V: the same, of what lives on the command's axis
  static constexpr Name friction = "friction";                      // V: the Coulomb level
  static constexpr Name force_per_position = "force_per_position";  // V/m: largest |command| over length of the travel
  static constexpr Name force_per_velocity = "force_per_velocity";  // V/(m/s): largest |command| over largest speed
  static constexpr Name force_per_velocity_squared = "force_per_velocity_squared";  // V/(m/s)^2: over its square
  static constexpr Name stiffness = "stiffness";      // V/m: the Coulomb level over length of the travel
  static constexpr Name position = "position";        // m: a place, 0 = lower end and 1 = upper end of the travel
  static constexpr Name distance = "distance";        // m: length of the travel
  static constexpr Name angle = "angle";              // rad: one turn, 2 pi
  static constexpr Name velocity = "velocity";        // m/s: largest speed
  static constexpr Name time = "time";                // s: duration
  static constexpr Name sample_time = "sample_time";  // s: between two samples
  static constexpr Name frequency = "frequency";      // Hz: half the sample rate
};

struct Trait {
  std::string_view role = Role::setting, quantity = Quantity::one;
  double low = 0.0, high = 0.0;  // multiples of the quantity's value; of an amplitude: plausible, not binding
  bool logarithmic = false;      // step evenly in the logarithm
  bool vanishes = false;         // at its default the whole effect does nothing
};

constexpr Trait amplitude(Quantity::Name quantity, double high = 1.0) {
  return {Role::amplitude, quantity, -high, high, false, true};
}
/// An amplitude that the effect's name gives a sign.
constexpr Trait positive_amplitude(Quantity::Name quantity, double high = 1.0) {
  return {Role::amplitude, quantity, 0.0, high, false, true};
}
constexpr Trait linear_shape(Quantity::Name quantity, double low, double high) {
  return {Role::shape, quantity, low, high, false, false};
}
constexpr Trait logarithmic_shape(Quantity::Name quantity, double low, double high) {
  return {Role::shape, quantity, low, high, true, false};
}
/// The same, of a parameter at whose default the effect does nothing, whatever the others are.
constexpr Trait vanishing(Trait trait) {
  trait.vanishes = true;
  return trait;
}

}  // namespace cogging
