#pragma once
// Every effect and controller of the lists with values that show in a motion, and machines drawn at random.

#include <cstddef>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "cogging/control/list.hpp"
#include "cogging/plant/plant.hpp"

namespace drawn {

using namespace cogging;

constexpr double pitch = 0.05;  // m
constexpr int points = 13;

inline double uniform(std::mt19937_64& engine, double low, double high) {
  return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1.0p-53;
}

/// The effect with values by the names of its fields, which leave a loop stable; `scale` may differ in a pack.
template <class Law>
Law sized(Law law, double scale) {
  if constexpr (requires { law.stiffness; }) law.stiffness = (requires { law.damping; } ? 3e3 : 0.8) * scale;
  if constexpr (requires { law.level; }) law.level = 0.12 * scale;
  if constexpr (requires { law.moment; }) law.moment = 0.05 * scale;
  if constexpr (requires { law.decay_length; }) law.decay_length = 0.1 * scale;
  if constexpr (requires { law.difference; }) law.difference = 0.02 * scale;
  if constexpr (requires { law.static_excess; }) law.static_excess = 0.09 * scale, law.exponent = 1.3;
  if constexpr (requires { law.nodes; }) law.nodes = {-0.1, 0.0, 0.2}, law.levels = {0.03, -0.02, 0.06};
  if constexpr (requires { law.coefficient; }) law.coefficient = 0.3 * scale;
  if constexpr (requires { law.change; }) law.change = 0.05 * scale, law.time_constant = 0.4;
  if constexpr (requires { law.delay; }) law.delay = 0.00037;
  if constexpr (std::is_same_v<Law, ActuatorLag<>>) law.time_constant = 0.0007 * scale;
  if constexpr (requires { law.limit; }) law.limit = 1.1 * scale;
  if constexpr (requires { law.width; }) law.width = 0.02 * scale;
  if constexpr (requires { law.scale; }) law.scale = 1e-3 * scale;
  if constexpr (requires { law.gap; }) law.gap = 2e-5, law.mass_ratio = 0.2;
  if constexpr (std::is_same_v<Law, FlexibleMode<>>) law.frequency = 60.0, law.mass_ratio = 0.2;
  if constexpr (std::is_same_v<Law, DisturbanceTone<>>) law.frequency = 23.0 * scale;
  if constexpr (requires { law.start; }) law.start = 0.01003, law.stop = 0.02004;
  if constexpr (std::is_same_v<Law, EmpiricalForce<>>)
    law.position_nodes = {-0.1, 0.05, 0.2}, law.position_forces = {0.02, -0.04, 0.03};
  if constexpr (std::is_same_v<Law, CoggingModulation<>>) {
    law.pitch = pitch, law.period = pitch;
    for (int c = 0; c < points; ++c) law.sine.push_back(0.01 * c), law.cosine.push_back(-0.005 * c);
  } else if constexpr (std::is_same_v<Law, EncoderPeriodicError<>>) {
    law.sine = 2e-6 * scale;
  } else if constexpr (requires { law.sine; }) {
    law.sine = 0.03 * scale, law.cosine = -0.02 * scale;
  }
  return law;
}

template <class... E>
std::vector<Effect<>> sized_effects(const std::variant<E...>*, double scale) {
  return {sized(E{}, scale)...};
}

/// Every effect of the list but a user's own.
inline std::vector<Effect<>> every_effect(double scale = 1.0) {
  std::vector<Effect<>> all = sized_effects(static_cast<const Effect<>*>(nullptr), scale);
  std::erase_if(all, [](const Effect<>& effect) { return std::holds_alternative<Custom<>>(effect); });
  return all;
}

/// An axis with cogging, encoder and noise, these effects, and friction that sticks where the width is 0.
inline Plant<> machine(std::mt19937_64& engine, double coulomb_width, std::vector<Effect<>> effects) {
  AxisParameters<> axis;
  axis.mass = uniform(engine, 0.1, 0.2);
  axis.viscous = uniform(engine, 0.1, 0.4);
  axis.coulomb = uniform(engine, 0.1, 0.3);
  axis.coulomb_width = coulomb_width;
  axis.travel = {-0.51, 0.51};
  const SplineHarmonics basis =
      SplineHarmonics::of_harmonics(pitch, {1, 2, 3, 6, 12}, BSpline(3, -0.15, pitch, points));
  std::vector<double> coefficients;
  for (int c = 0; c < basis.coefficients(); ++c) coefficients.push_back(uniform(engine, -0.05, 0.05));
  return {axis, CoggingModel<>(basis, coefficients), std::move(effects), EncoderParameters{0.5e-6, 1e-7},
          NoiseParameters{0.01, 100.0}};
}

/// Values that make a controller's memory matter and hold the axis, by the names of the fields.
template <class Parameters>
void tune(Parameters& q) {
  q.command_limit = 2.0;
  if constexpr (requires { q.mass_adaptation; }) {
    q.mass_adaptation = 1.0;
    q.viscous_adaptation = q.coulomb_adaptation = 10.0;
    q.disturbance_adaptation = 1000.0;
    q.cogging_harmonics = {1, 2, 3};
    q.cogging_control_points = points;
    q.cogging_adaptation = 100.0;
    q.epsilon = 0.1;
  } else if constexpr (requires { q.kp; }) {
    q.sample_rate = 5000.0;
    q.kp = 100.0;
  } else if constexpr (requires { q.observer_gain_slope; }) {
    q.sample_rate = 5000.0;
    q.delay = 0.00033;
    q.velocity_min = 0.1;
    q.observer_gain = {300.0, 3e4, 1e6, 1e4, -2e4};
  } else if constexpr (requires { q.coulomb; }) {
    q.coulomb = 0.1;
  }
  if constexpr (requires { q.feedforward_velocity; }) {
    q.mass = 0.12, q.coulomb = 0.1, q.viscous = 0.2;
    q.feedforward_velocity = "measured";
    if constexpr (requires { q.delay; }) q.delay = 0.00053;
  }
  if constexpr (requires { q.ki; }) q.ki = 1e4;
  if constexpr (requires { q.kd; }) q.kd = 40.0;
  if constexpr (requires { q.kv; }) q.kv = 40.0;
}

template <class C>
C tuned() {
  typename C::Parameters q;
  tune(q);
  return C(q);
}

}  // namespace drawn
