#pragma once
// What an effect is. Each stands in one file of effects/ and in one line of effects/list.hpp.
//
// An effect is a struct template over the scalar with
//   static constexpr std::string_view name, law;      // as in the vocabulary; the formula
//   static constexpr auto fields();                   // its parameters, their rules and traits; defaults make it
//   vanish void validate() const;                            // where a rule binds several fields: throws, naming the
//   field static Kinds kinds();                             // where parameters belong together: what they are
// and at least one of
//   Scalar force(const Motion<Scalar>&) const;            // V, added to the force balance
//   Scalar friction_level(const Motion<Scalar>&) const;   // V, added to the Coulomb level that multiplies S(v)
//   Scalar command_gain(const Scalar& position, double time) const;  // added to 1: the gains of all effects add,
//                                                         // and multiply what the amplifier puts out
//   Scalar shape_command(const Scalar& command) const;    // V, what the amplifier makes of a command, no memory
//   double command_delay() const;                         // s, how much later the command acts
//   Scalar lag_time_constant() const;                     // s, of a first-order current loop
//   Scalar reading_error(const Scalar& position) const;   // m, by which the encoder reads too much there: the
//                                                         // errors of all effects add
//   Bristle bristle() const;                              // a friction contact with a state, in place of S(v)
//   CouplingParameters coupling() const;                  // a load that is a mass of its own
// Beside these it may have
//   Variation variation() const;                          // how quickly it changes along the travel and in time
//   std::vector<double> kinks() const;                    // m, places at which it has a kink or a jump
//   std::vector<double> velocity_kinks() const;           // m/s, velocities at which it has one
//   double next_event(double time) const;                 // s, the next time at which its law jumps: steps end there
//   void bind(const PlantContext&);                       // takes what it needs from the plant; throws where that
//                                                         // is missing
//   bool uses(Hook) const;                                // where a type has hooks that not each effect of it uses
//   bool serial() const;                                  // only one thread at a time can ask it

#include "cogging/basis/b_spline.hpp"
#include "cogging/parameters.hpp"
#include "cogging/plant/kinds.hpp"
#include "cogging/plant/step_control.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// What a force law may look at.
template <class Scalar>
struct Motion {
  Scalar position;   // m
  Scalar velocity;   // m/s
  Scalar direction;  // S(velocity) in the smooth form, -1 or +1 where the axis slides (or is about to) in the
                     // exact one
  double time;       // s, from the first row
};

using Range = std::array<double, 2>;

/// Refuses a travel that is empty.
inline void require_travel(const Range& travel) {
  if (!(travel[0] < travel[1]))
    refuse("travel", "needs lower end < upper end", "[" + format(travel[0]) + ", " + format(travel[1]) + "]");
}

/// What an effect may take from the plant that it stands in.
struct PlantContext {
  Range travel = {-infinity, infinity};  // m
  bool has_knots = false;                // there is a cogging model
  BSpline knots;  // of its amplitudes; constant amplitudes have a constant spline, whose pitch is kept
};

/// The laws that an effect may be without though its type has them.
enum class Hook { force, friction_level, command_gain, reading_error };

constexpr std::string_view to_string(Hook hook) {
  constexpr std::string_view names[] = {"force", "friction_level", "command_gain", "reading_error"};
  return names[static_cast<int>(hook)];
}

template <class E, class Scalar>
concept HasForce = requires(const E& effect, const Motion<Scalar>& motion) { effect.force(motion); };
template <class E, class Scalar>
concept HasFrictionLevel = requires(const E& effect, const Motion<Scalar>& motion) { effect.friction_level(motion); };
/// Either of them: what a motion decides.
template <class E, class Scalar>
concept HasMotionLaw = HasForce<E, Scalar> || HasFrictionLevel<E, Scalar>;
template <class E, class Scalar>
concept HasCommandGain =
    requires(const E& effect, const Scalar& position, double time) { effect.command_gain(position, time); };
template <class E, class Scalar>
concept HasShapeCommand = requires(const E& effect, const Scalar& command) { effect.shape_command(command); };
template <class E>
concept HasCommandDelay = requires(const E& effect) { effect.command_delay(); };
template <class E>
concept HasLag = requires(const E& effect) { effect.lag_time_constant(); };
template <class E, class Scalar>
concept HasReading = requires(const E& effect, const Scalar& position) { effect.reading_error(position); };
template <class E>
concept HasBristle = requires(const E& effect) { effect.bristle(); };
template <class E>
concept HasCoupling = requires(const E& effect) { effect.coupling(); };
/// More of the axis than position and velocity has a memory.
template <class E>
concept HasState = HasBristle<E> || HasCoupling<E>;
/// A load that is loose: its coupling has play, of which the effect's own `gap` is the width.
template <class E>
concept HasPlay = HasCoupling<E> && requires(E& effect) { effect.gap *= 1.0; };
template <class E>
concept HasVariation = requires(const E& effect) { effect.variation(); };
template <class E>
concept HasKinks = requires(const E& effect) { effect.kinks(); };
template <class E>
concept HasVelocityKinks = requires(const E& effect) { effect.velocity_kinks(); };
template <class E>
concept HasEvents = requires(const E& effect, double time) { effect.next_event(time); };
template <class E>
concept ChoosesHooks = requires(const E& effect) { effect.uses(Hook::force); };
template <class E>
concept MaySerialise = requires(const E& effect) { effect.serial(); };
template <class E>
concept HasBind = requires(E& effect, const PlantContext& context) { effect.bind(context); };

/// Whether an effect whose type has a hook uses it.
template <class E>
bool uses(const E& effect, [[maybe_unused]] Hook hook) {
  if constexpr (ChoosesHooks<E>)
    return effect.uses(hook);
  else
    return true;
}

}  // namespace cogging
