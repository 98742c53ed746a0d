#pragma once
// Every effect that a plant may have: one line each.

#include <variant>

#include "cogging/plant/effects/actuator_lag.hpp"
#include "cogging/plant/effects/cable_spring.hpp"
#include "cogging/plant/effects/cogging_harmonic.hpp"
#include "cogging/plant/effects/command_delay.hpp"
#include "cogging/plant/effects/command_saturation.hpp"
#include "cogging/plant/effects/constant_force.hpp"
#include "cogging/plant/effects/coulomb_asymmetry.hpp"
#include "cogging/plant/effects/disturbance_step.hpp"
#include "cogging/plant/effects/disturbance_tone.hpp"
#include "cogging/plant/effects/quadratic_drag.hpp"
#include "cogging/plant/effects/stribeck_friction.hpp"
#include "cogging/plant/effects/viscous_asymmetry.hpp"

namespace cogging {

template <class Scalar = double>
using Effect = std::variant<ConstantForce<Scalar>,      // offset, tilt
                            CableSpring<Scalar>,        // linear in position
                            CoggingHarmonic<Scalar>,    // a spatial period that the model lacks
                            CoulombAsymmetry<Scalar>,   // Coulomb level by direction
                            ViscousAsymmetry<Scalar>,   // viscous slope by direction
                            StribeckFriction<Scalar>,   // friction falls as speed rises from zero
                            QuadraticDrag<Scalar>,      // grows with v^2
                            CommandDelay<Scalar>,       // the command acts later
                            ActuatorLag<Scalar>,        // first-order current loop
                            CommandSaturation<Scalar>,  // large commands are cut
                            DisturbanceStep<Scalar>,    // from one time to another
                            DisturbanceTone<Scalar>     // a sinusoid in time
                            >;

}  // namespace cogging
