#pragma once
// Lost motion between motor and load.

#include "cogging/plant/coupling.hpp"
#include "cogging/plant/effect.hpp"

namespace cogging {

/// Two masses, (1 - mass_ratio) M of the motor and mass_ratio M of the load, with `gap` of play between them: the
/// load q ahead of the motor is free for |q| < gap / 2. Beyond, the contact is the spring and damper of a
/// flexible_mode of contact_frequency and contact_damping_ratio that never pulls. All forces act on the motor, and
/// so does the encoder; the load starts in the middle of the gap and at the motor's velocity. gap = 0: rigid.
template <class Scalar = double>
struct Backlash {
  static constexpr std::string_view name = "backlash";
  static constexpr std::string_view law =
      "m1 x'' = forces + T(q, q'), m2 (x + q)'' = -T(q, q'), T = 0 for |q| < gap / 2";

  double gap = 0.0;  // m
  double mass_ratio = 0.0;
  double contact_frequency = 400.0;    // Hz, assumed: stiff
  double contact_damping_ratio = 1.0;  // assumed: a lubricated contact hardly rebounds

  static constexpr auto fields() {
    using E = Backlash;
    return std::tuple{
        Field{"gap", &E::gap, "m", "full play of the load", Rule::not_negative,
              vanishing(logarithmic_shape(Quantity::distance, 1e-6, 0.02))},
        Field{"mass_ratio", &E::mass_ratio, "1", "load over total", Rule::share,
              vanishing(linear_shape(Quantity::relative, 0.0, 0.9))},
        Field{"contact_frequency", &E::contact_frequency, "Hz", "of the free-free vibration in contact",
              Rule::positive},
        Field{"contact_damping_ratio", &E::contact_damping_ratio, "1", "of that vibration", Rule::not_negative}};
  }

  CouplingParameters coupling() const { return {mass_ratio, contact_frequency, contact_damping_ratio, gap, true}; }
};

}  // namespace cogging
