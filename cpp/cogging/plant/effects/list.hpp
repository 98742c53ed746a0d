#pragma once
// Every effect that a plant may have: one line each.

#include <concepts>
#include <utility>
#include <variant>

#include "cogging/plant/effects/actuator_lag.hpp"
#include "cogging/plant/effects/backlash.hpp"
#include "cogging/plant/effects/cable_spring.hpp"
#include "cogging/plant/effects/cogging_harmonic.hpp"
#include "cogging/plant/effects/cogging_modulation.hpp"
#include "cogging/plant/effects/command_dead_zone.hpp"
#include "cogging/plant/effects/command_delay.hpp"
#include "cogging/plant/effects/command_saturation.hpp"
#include "cogging/plant/effects/constant_force.hpp"
#include "cogging/plant/effects/coulomb_asymmetry.hpp"
#include "cogging/plant/effects/custom.hpp"
#include "cogging/plant/effects/disturbance_step.hpp"
#include "cogging/plant/effects/disturbance_tone.hpp"
#include "cogging/plant/effects/empirical_force.hpp"
#include "cogging/plant/effects/encoder_periodic_error.hpp"
#include "cogging/plant/effects/encoder_scale_error.hpp"
#include "cogging/plant/effects/end_effect.hpp"
#include "cogging/plant/effects/flexible_mode.hpp"
#include "cogging/plant/effects/force_constant_drift.hpp"
#include "cogging/plant/effects/force_constant_ripple.hpp"
#include "cogging/plant/effects/gravity.hpp"
#include "cogging/plant/effects/local_force.hpp"
#include "cogging/plant/effects/position_dependent_friction.hpp"
#include "cogging/plant/effects/presliding_friction.hpp"
#include "cogging/plant/effects/quadratic_drag.hpp"
#include "cogging/plant/effects/stribeck_friction.hpp"
#include "cogging/plant/effects/viscous_asymmetry.hpp"

namespace cogging {

template <class Scalar = double>
using Effect = std::variant<ConstantForce<Scalar>,              // offset, tilt
                            CableSpring<Scalar>,                // linear in position
                            EndEffect<Scalar>,                  // close to the ends
                            LocalForce<Scalar>,                 // at one place
                            Gravity<Scalar>,                    // an unbalanced mass, one turn
                            CoggingHarmonic<Scalar>,            // a spatial period that the model lacks
                            CoggingModulation<Scalar>,          // a harmonic that changes along the travel
                            CoulombAsymmetry<Scalar>,           // Coulomb level by direction
                            ViscousAsymmetry<Scalar>,           // viscous slope by direction
                            StribeckFriction<Scalar>,           // friction falls as speed rises from zero
                            PreslidingFriction<Scalar>,         // spring-like before breakaway
                            PositionDependentFriction<Scalar>,  // Coulomb level along the travel
                            QuadraticDrag<Scalar>,              // grows with v^2
                            ForceConstantRipple<Scalar>,        // command gain along the travel
                            ForceConstantDrift<Scalar>,         // command gain in time
                            CommandDelay<Scalar>,               // the command acts later
                            ActuatorLag<Scalar>,                // first-order current loop
                            CommandSaturation<Scalar>,          // large commands are cut
                            CommandDeadZone<Scalar>,            // small commands do nothing
                            EncoderPeriodicError<Scalar>,       // reading wrong with a period
                            EncoderScaleError<Scalar>,          // reading wrong in scale
                            Backlash<Scalar>,                   // lost motion between motor and load
                            FlexibleMode<Scalar>,               // resonance between motor and load
                            DisturbanceStep<Scalar>,            // from one time to another
                            DisturbanceTone<Scalar>,            // a sinusoid in time
                            EmpiricalForce<Scalar>,             // of any shape, of no known cause
                            Custom<Scalar>                      // of the user's own
                            >;

namespace detail {

template <std::size_t place, class AnyEffect, class Visitor>
COGGING_INLINE void visit_at(AnyEffect& effect, const Visitor& visitor) {
  if constexpr (std::invocable<const Visitor&, std::variant_alternative_t<place, AnyEffect>&>)
    if (auto* const law = std::get_if<place>(&effect)) visitor(*law);
}

}  // namespace detail

/// Calls visitor(law) where the law of the effect is one that the visitor takes: its parameter names the hook, as in
/// `[&](const HasForce<Scalar> auto& law) { ... }`.
template <class AnyEffect, class Visitor>
COGGING_INLINE void visit_law(AnyEffect& effect, const Visitor& visitor) {
  [&]<std::size_t... place>(std::index_sequence<place...>) COGGING_INLINE_LAMBDA {
    // Few are asked for one by one: std::visit would have a function for each effect of the list.
    if constexpr ((std::size_t{std::invocable<const Visitor&, std::variant_alternative_t<place, AnyEffect>&>} + ...) <=
                  4)
      (detail::visit_at<place>(effect, visitor), ...);
    else
      std::visit(
          [&](auto& law) {
            if constexpr (std::invocable<const Visitor&, decltype(law)>) visitor(law);
          },
          effect);
  }(std::make_index_sequence<std::variant_size_v<AnyEffect>>());
}

/// The same for each of the effects, in their order.
template <class Effects, class Visitor>
COGGING_INLINE void for_each_law(Effects& effects, const Visitor& visitor) {
  for (auto& effect : effects) visit_law(effect, visitor);
}

/// Raises std::invalid_argument for a parameter of an effect that breaks its rule.
template <class Scalar>
void validate_effects(const std::vector<Effect<Scalar>>& effects) {
  for_each_law(effects, [](const auto& law) { validated(law); });
}

/// A copy of the effects, each having taken from the plant what it needs of it.
///
/// Raises std::invalid_argument where the plant lacks that, and for a parameter that breaks its rule.
template <class Scalar>
std::vector<Effect<Scalar>> bind_effects(std::vector<Effect<Scalar>> effects, const PlantContext& plant) {
  validate_effects(effects);
  for_each_law(effects, [&](HasBind auto& law) { law.bind(plant); });
  return effects;
}

/// Whether one of the effects can be asked by one thread at a time alone.
template <class Scalar>
bool is_serial(const std::vector<Effect<Scalar>>& effects) {
  bool serial = false;
  for_each_law(effects, [&](const MaySerialise auto& law) { serial = serial || law.serial(); });
  return serial;
}

}  // namespace cogging
