#pragma once
// What an effect is. Each stands in one file of effects/ and in one line of effects/list.hpp.
//
// An effect is a struct template over the scalar with
//   static constexpr std::string_view name, law;      // as in the vocabulary; the formula
//   static constexpr auto fields();                   // its parameters, whose defaults make it vanish
//   void validate() const;                            // throws, naming the field
// and at least one of
//   Scalar force(const Motion<Scalar>&) const;           // V, added to the force balance
//   Scalar friction_level(const Motion<Scalar>&) const;  // V, added to the Coulomb level that multiplies
//   S(v) Scalar shape_command(const Scalar& command) const;   // V, what the amplifier makes of a command,
//   without memory double command_delay() const;                        // s, how much later the command acts
//   Scalar lag_time_constant() const;                    // s, of a first-order current loop
//   double next_event(double time) const;                // s, the next time at which its law jumps: steps
//   end there

#include <string_view>

#include "cogging/parameters.hpp"
#include "cogging/plant/motion.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

template <class E, class Scalar>
concept HasForce = requires(const E& effect, const Motion<Scalar>& motion) { effect.force(motion); };
template <class E, class Scalar>
concept HasFrictionLevel = requires(const E& effect, const Motion<Scalar>& motion) { effect.friction_level(motion); };
template <class E, class Scalar>
concept HasShapeCommand = requires(const E& effect, const Scalar& command) { effect.shape_command(command); };
template <class E>
concept HasCommandDelay = requires(const E& effect) { effect.command_delay(); };
template <class E>
concept HasLag = requires(const E& effect) { effect.lag_time_constant(); };
template <class E>
concept HasEvents = requires(const E& effect, double time) { effect.next_event(time); };

}  // namespace cogging
