// Numbers of the core in full, to be compared between processors and compilers: every controller, every effect with
// friction that sticks and that is smooth, every motion, and predictions along what they logged. A case is a line with
// its name, a hash over the bits of all its numbers, and then column by column some of them.

#include <bit>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cogging/control/list.hpp"
#include "cogging/estimation/predictor.hpp"
#include "cogging/plant/effects/list.hpp"
#include "cogging/reference/list.hpp"
#include "cogging/simulation/closed_loop.hpp"

namespace {

using namespace cogging;

constexpr double pitch = 0.05, frequency = 0.7;
constexpr int points = 9;

template <class... E>
struct Named {
  static std::vector<Effect<>> all() { return {named(E{})...}; }

  // Of a size that shows in the motion and leaves the loop stable, by the names of the fields.
  template <class Law>
  static Effect<> named(Law law) {
    if constexpr (requires { law.stiffness; }) law.stiffness = requires { law.damping; } ? 3e3 : 0.8;
    if constexpr (requires { law.level; }) law.level = 0.12;
    if constexpr (requires { law.difference; }) law.difference = 0.07;
    if constexpr (requires { law.static_excess; }) law.static_excess = 0.09, law.exponent = 1.3;
    if constexpr (requires { law.nodes; }) law.nodes = {-0.1, 0.0, 0.2}, law.levels = {0.03, -0.02, 0.06};
    if constexpr (requires { law.coefficient; }) law.coefficient = 0.3;
    if constexpr (requires { law.change; }) law.change = 0.05, law.time_constant = 0.4;
    if constexpr (requires { law.delay; }) law.delay = 0.00037;
    if constexpr (std::is_same_v<Law, ActuatorLag<>>) law.time_constant = 0.0004;
    if constexpr (requires { law.limit; }) law.limit = 1.1;
    if constexpr (requires { law.width; }) law.width = 0.02;
    if constexpr (requires { law.scale; }) law.scale = 1e-3;
    if constexpr (requires { law.gap; }) law.gap = 2e-5, law.mass_ratio = 0.2;
    if constexpr (std::is_same_v<Law, FlexibleMode<>>) law.frequency = 60.0, law.mass_ratio = 0.2;
    if constexpr (requires { law.start; }) law.start = 0.11, law.stop = 0.33;
    if constexpr (requires {
                    law.frequency;
                    law.sine;
                  })
      law.frequency = 23.0;
    if constexpr (std::is_same_v<Law, CoggingModulation<>>) {
      law.pitch = pitch, law.period = pitch;
      for (int c = 0; c < points; ++c) law.sine.push_back(0.01 * c), law.cosine.push_back(-0.005 * c);
    } else if constexpr (std::is_same_v<Law, EncoderPeriodicError<>>) {
      law.sine = 2e-6, law.cosine = -1e-6;
    } else if constexpr (requires { law.sine; }) {
      law.sine = 0.03, law.cosine = -0.02;
    }
    if constexpr (std::is_same_v<Law, EmpiricalForce<>>)
      law.position_nodes = {-0.1, 0.05, 0.2}, law.position_forces = {0.02, -0.04, 0.03};
    return law;
  }
};
template <class... E>
std::vector<Effect<>> every_effect(const std::variant<E...>*) {
  return Named<E...>::all();
}

Plant<> machine(double width, std::vector<Effect<>> effects) {
  AxisParameters<> axis;
  axis.mass = 0.15, axis.viscous = 0.4, axis.coulomb = 0.2, axis.coulomb_width = width, axis.travel = {-0.15, 0.25};
  const SplineHarmonics basis = SplineHarmonics::of_harmonics(pitch, {1, 2, 3}, BSpline(3, -0.15, pitch, points));
  std::vector<double> coefficients;
  for (int c = 0; c < basis.coefficients(); ++c) coefficients.push_back(0.05 - 0.013 * ((7 * c) % 9));
  return {axis, CoggingModel<>(basis, coefficients), std::move(effects), EncoderParameters{1e-7, 2e-8},
          NoiseParameters{0.01, 40.0}};
}

// Gains that hold the axis, by the names of the fields.
template <class C>
C controller() {
  typename C::Parameters q;
  if constexpr (requires { q.sample_rate; }) q.sample_rate = 2500.0;
  if constexpr (requires { q.kd; }) q.kp = 1500.0, q.ki = 1e4, q.kd = 20.0;
  if constexpr (requires { q.kv; }) q.kp = 60.0, q.kv = 20.0;
  if constexpr (requires {
                  q.kp;
                  q.feedforward_velocity;
                })
    q.mass = 0.15, q.coulomb = 0.15, q.coulomb_width = 2e-3;
  if constexpr (std::is_same_v<C, Speed<>>) q.kp = 8.0;
  if constexpr (requires { q.mass_adaptation; }) {
    q.mass_adaptation = 1.0, q.viscous_adaptation = q.coulomb_adaptation = 10.0, q.epsilon = 0.1;
    q.cogging_harmonics = {1, 2, 3}, q.cogging_control_points = points, q.cogging_adaptation = 100.0;
  }
  if constexpr (requires { q.observer_gain_slope; }) {
    q.periods = {pitch};
    q.observer_gain = {300.0, 3e4, 1e6, 1e4, -2e4};
  }
  return C(q);
}

// SplitMix64's mixing, over the bits in their order.
std::uint64_t mixed(std::uint64_t hash, double value) {
  std::uint64_t z = (hash ^ std::bit_cast<std::uint64_t>(value)) + 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

void told(const std::string& name, const std::vector<const std::vector<double>*>& columns) {
  std::uint64_t hash = 0;
  for (const auto* column : columns)
    for (const double value : *column) hash = mixed(hash, value);
  std::printf("%s %016llx", name.c_str(), static_cast<unsigned long long>(hash));
  for (const auto* column : columns) {
    std::printf(" |");
    for (std::size_t k = 1; k <= 40; ++k) std::printf(" %.17g", (*column)[k * (column->size() - 1) / 40]);
  }
  std::printf("\n");
}

// One run, and one step ahead along it with a plant that lacks what is at its front.
template <class C>
void run(const std::string& name, const C& control, const Plant<>& plant, const Reference& motion) {
  RunOptions options;
  options.duration = 0.5;
  options.seed = 5;
  const Log<> log = closed_loop<double>(plant, control, motion, options);
  told(name, {&log.position, &log.command, &log.true_position, &log.true_velocity});
  const Predictor predictor(log.time, log.position, log.command);
  const Prediction along = predictor.predict(plant);
  told(name + ",predicted", {&along.innovation, &along.velocity, &along.slope_velocity});
}

template <class... C>
void every_controller(const std::variant<C...>*, const Reference& motion) {
  const auto both = [&]<class One>(const One& control) {
    for (const double width : {0.0, 2e-3})
      run(std::string(One::name) + (width > 0.0 ? ",smooth" : ",sticks"), control, machine(width, {}), motion);
  };
  (both(controller<C>()), ...);
}

template <class E>
constexpr std::string_view name_of(const E&) {
  return E::name;
}

}  // namespace

int main() {
  const Sine sine(SineParameters{0.0, 0.08, frequency});
  const PointToPoint move(PointToPointParameters{.start = -0.05,
                                                 .distance = 0.1,
                                                 .velocity = 0.6,
                                                 .acceleration = 8.0,
                                                 .jerk = 400.0,
                                                 .dwell = 0.05,
                                                 .repeats = 1});
  FilteredSineParameters filtered;
  filtered.amplitude = 0.05, filtered.frequency = frequency;
  every_controller(static_cast<const AnyController<>*>(nullptr), move);
  run("pid,sine", controller<Pid<>>(), machine(2e-3, {}), sine);
  run("pid,filtered_sine", controller<Pid<>>(), machine(0.0, {}), FilteredSine(filtered));
  for (const Effect<>& effect : every_effect(static_cast<const Effect<>*>(nullptr)))
    for (const double width : {0.0, 2e-3}) {
      const std::string name = std::visit([](const auto& law) { return std::string(name_of(law)); }, effect);
      if (name == "custom") continue;  // a user's own law is the user's own arithmetic
      run(name + (width > 0.0 ? ",smooth" : ",sticks"), controller<Pid<>>(), machine(width, {effect}), move);
    }
}
