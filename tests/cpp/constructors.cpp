// Every field of every parameter struct, with a value that breaks its rule: the class that takes the struct refuses it
// and names the field.

#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "check.hpp"
#include "cogging/control/list.hpp"
#include "cogging/lanes.hpp"
#include "cogging/plant/amplifier.hpp"
#include "cogging/plant/plant.hpp"
#include "cogging/reference/list.hpp"
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

template <class... C>
void controllers(const std::variant<C...>*, const std::string& added) {
  (spoil_each_field(std::string(C::name) + added, typename C::Parameters{}, [](const auto& q) { C made(q); }), ...);
}

// A motion that is given by its samples has no fields.
template <class R>
void reference() {
  if constexpr (requires(R motion) { motion.parameters(); })
    spoil_each_field(std::string(R::name), std::decay_t<decltype(std::declval<R>().parameters())>{},
                     [](const auto& q) { R made(q); });
}
template <class... R>
void references(const std::variant<R...>*) {
  (reference<R>(), ...);
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

}  // namespace

int main() {
  controllers(static_cast<const AnyController<>*>(nullptr), "");
  controllers(static_cast<const AnyController<Lanes<4>>*>(nullptr), " in lanes");
  references(static_cast<const AnyReference*>(nullptr));
  plant();
  return check::status();
}
