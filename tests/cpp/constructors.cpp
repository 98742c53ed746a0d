// Every field of every parameter struct, with a value that breaks its rule: the class that takes the struct refuses it
// and names the field.

#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "check.hpp"
#include "cogging/control/adaptive_robust.hpp"
#include "cogging/control/cascade.hpp"
#include "cogging/control/observer_based.hpp"
#include "cogging/control/output_feedback_adaptive_robust.hpp"
#include "cogging/control/pid.hpp"
#include "cogging/control/speed.hpp"
#include "cogging/lanes.hpp"
#include "cogging/memory.hpp"
#include "cogging/plant/amplifier.hpp"
#include "cogging/plant/plant.hpp"
#include "cogging/reference/filtered.hpp"
#include "cogging/reference/point_to_point.hpp"
#include "cogging/reference/sine.hpp"
#include "cogging/simulation/closed_loop.hpp"

namespace {

using namespace cogging;

// A value that no rule allows; false where there is none, as of a switch.
bool spoil(double& value) {
  value = NAN;
  return true;
}
bool spoil(int& value) {
  value = -1;
  return true;
}
bool spoil(std::string& value) {
  value = "neither";
  return true;
}
bool spoil(bool&) {
  return false;
}
template <std::size_t count>
bool spoil(Lanes<count>& value) {
  value.set(count / 2, NAN);
  return true;
}
template <class Value>
bool spoil(std::vector<Value>& values) {
  if (values.empty()) values.emplace_back();
  return spoil(values.back());
}
template <class Value, std::size_t count>
bool spoil(std::array<Value, count>& values) {
  return spoil(values[0]);
}

std::string answer(const std::function<void()>& make) {
  try {
    make();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "taken";
}

void require_named(const std::string& name, std::string_view field, const std::string& said) {
  const bool named = said.substr(0, said.find(": ")).find(field) != std::string::npos;
  check::holds(named && said.find(", got ") != std::string::npos && said.find('\n') == std::string::npos,
               name + "." + std::string(field) + " spoilt: " + said);
}

/// Makes with each field spoilt in turn, and with none.
template <class Struct, class Make>
void spoil_each_field(const std::string& name, const Struct& valid, const Make& make) {
  check::holds(answer([&] { make(valid); }) == "taken", name + " is refused as it should be");
  Struct spoilt = valid;
  const std::function<void()> make_spoilt = [&] { make(spoilt); };
  for_each_field<Struct>([&](const auto& field) {
    spoilt = valid;
    if (spoil(spoilt.*(field.member))) require_named(name, field.name, answer(make_spoilt));
  });
}

template <template <class> class Kind>
void spoil_controller(const std::string& name) {
  spoil_each_field(name, typename Kind<double>::Parameters{}, [](const auto& q) { Kind<double> made(q); });
  spoil_each_field(name + " in lanes", typename Kind<Lanes<4>>::Parameters{},
                   [](const auto& q) { Kind<Lanes<4>> made(q); });
}

template <class Scalar>
using PlainArc = AdaptiveRobust<Scalar, false>;
template <class Scalar>
using PlainDcarc = AdaptiveRobust<Scalar, true>;

void controllers() {
  spoil_controller<Pid>("pid");
  spoil_controller<Cascade>("cascade");
  spoil_controller<Speed>("speed");
  spoil_controller<PlainArc>("arc");
  spoil_controller<PlainDcarc>("dcarc");
  spoil_controller<OutputFeedbackArc>("output_feedback_arc");
  spoil_controller<ObserverBased>("observer_based");
}

template <class R, class Struct>
void spoil_reference(const std::string& name, const Struct& valid) {
  spoil_each_field(name, valid, [](const Struct& q) { R made(q); });
}

void references() {
  spoil_reference<PointToPoint>("point_to_point", PointToPointParameters{});
  spoil_reference<Sine>("sine", SineParameters{});
  spoil_reference<FilteredSine>("filtered_sine", FilteredSineParameters{});
}

// Axis and amplifier take all effects, whichever of them acts there.
void in_axis_and_amplifier(const Effect<double>& effect) {
  const std::string by_axis = answer([&] { Axis<double>({.travel = {0.0, 1.0}}, {}, {effect}); });
  const std::string by_amplifier = answer([&] { Amplifier<double>({effect}, 1e-3); });
  if (by_axis != by_amplifier) refused("axis: " + by_axis + ", amplifier: " + by_amplifier);
  if (by_axis != "taken") refused(by_axis);
}

// An effect of the user's own has no fields: its parameters are its functions'.
template <class E>
void effect() {
  if constexpr (requires { E::fields(); }) spoil_each_field(std::string(E::name), E{}, in_axis_and_amplifier);
}

template <class... E>
void effects(const std::variant<E...>*) {
  (effect<E>(), ...);
}

void plant() {
  spoil_each_field("axis", AxisParameters<>{}, [](const auto& q) { Axis<> made(q, {}); });
  spoil_each_field("noise", NoiseParameters{}, [](const auto& q) { ForceNoise made(q, 1e-3, 1); });
  spoil_each_field("encoder", EncoderParameters{}, [](const auto& q) {
    const Plant<> machine{.axis = {}, .cogging = {}, .effects = {}, .encoder = q, .noise = {}};
    closed_loop<double>(machine, Pid<>(), Sine(SineParameters{}),
                        {.duration = 0.01, .initial_position = {}, .added_command = {}});
  });
  effects(static_cast<const Effect<double>*>(nullptr));
}

// What does not fit into memory is refused by name, and what does is not.
void memory() {
  const auto refused = [](double bytes) {
    try {
      require_memory("duration", bytes, "samples", "1");
    } catch (const std::invalid_argument& error) {
      return std::string(error.what()).rfind("duration: must fit into memory: samples take ", 0) == 0;
    }
    return false;
  };
  check::holds(memory_left() > 0.0, "memory: none is left");
  check::holds(refused(4.0 * memory_left() + 1e9), "memory: more than there is was granted");
  check::holds(!refused(0.1 * memory_left()), "memory: a part of what there is was refused");
}

}  // namespace

int main() {
  controllers();
  references();
  plant();
  memory();
  return check::status();
}
