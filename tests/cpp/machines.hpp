#pragma once
// Machines drawn at random with all effects, and parameters with which every controller works: for programs that run
// many of them.

#include <cstddef>
#include <random>
#include <type_traits>
#include <variant>
#include <vector>

#include "cogging/control/list.hpp"
#include "cogging/lanes.hpp"
#include "cogging/plant/plant.hpp"

namespace drawn {

using namespace cogging;

// What differs from lane to lane.
struct Machine {
  double mass, viscous, coulomb, coulomb_width, mass_estimate, error_gain, feedback_gain;
  std::vector<double> cogging;
};

inline SplineHarmonics plant_basis() {
  return SplineHarmonics::of_harmonics(0.05, {1, 2, 3, 6, 12}, BSpline(3, 0.0, 0.05, 13));
}

inline std::vector<Machine> machines(std::size_t count) {
  std::mt19937_64 engine(1);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1.0p-53;
  };
  std::vector<Machine> list;
  for (std::size_t i = 0; i < count; ++i) {
    Machine m{uniform(0.1, 0.2), uniform(0.1, 0.3),     uniform(0.1, 0.3),   uniform(1e-3, 1e-2),
              uniform(0.1, 0.2), uniform(100.0, 200.0), uniform(30.0, 60.0), {}};
    for (int c = 0; c < plant_basis().coefficients(); ++c) m.cogging.push_back(uniform(-0.05, 0.05));
    list.push_back(m);
  }
  return list;
}

// A value of every lane's machine, as the scalar wants it: that of one machine, or of all four.
template <class Scalar, class Get>
Scalar of(const std::vector<Machine>& list, const Get& get) {
  if constexpr (std::is_same_v<Scalar, double>) {
    return get(list.front());
  } else {
    return Scalar::map([&](std::size_t i) { return get(list[i]); });
  }
}

// Of a size that shows in the motion and leaves the loop stable, by the names of the fields.
template <class Law>
Law sized(Law law) {
  if constexpr (requires { law.stiffness; }) law.stiffness = requires { law.damping; } ? 3e3 : 0.8;
  if constexpr (requires { law.level; }) law.level = 0.12;
  if constexpr (requires { law.difference; }) law.difference = 0.07;
  if constexpr (requires { law.static_excess; }) law.static_excess = 0.09, law.exponent = 1.3;
  if constexpr (requires { law.nodes; }) law.nodes = {-0.1, 0.0, 0.2}, law.levels = {0.03, -0.02, 0.06};
  if constexpr (requires { law.coefficient; }) law.coefficient = 0.3;
  if constexpr (requires { law.change; }) law.change = 0.05, law.time_constant = 0.4;
  if constexpr (requires { law.delay; }) law.delay = 0.00037;
  if constexpr (std::is_same_v<Law, ActuatorLag<>>) law.time_constant = 0.0006;
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
    law.pitch = law.period = 0.05;
    for (int c = 0; c < 9; ++c) law.sine.push_back(0.01 * c), law.cosine.push_back(-0.005 * c);
  } else if constexpr (std::is_same_v<Law, EncoderPeriodicError<>>) {
    law.sine = 2e-6, law.cosine = -1e-6;
  } else if constexpr (requires { law.sine; }) {
    law.sine = 0.03, law.cosine = -0.02;
  }
  if constexpr (std::is_same_v<Law, EmpiricalForce<>>)
    law.position_nodes = {-0.1, 0.05, 0.2}, law.position_forces = {0.02, -0.04, 0.03};
  return law;
}

// All effects of such a size but a user's own; of those with a state, which exclude each other, all or none.
template <class... E>
std::vector<Effect<>> sized_effects(bool with_state, const std::variant<E...>*) {
  std::vector<Effect<>> effects;
  const auto add = [&]<class Law>(const Law& law) {
    constexpr bool has_state = HasBristle<Law> || HasCoupling<Law>;
    if constexpr (!ChoosesHooks<Law>)
      if (with_state || !has_state) effects.push_back(sized(law));
  };
  (add(E{}), ...);
  return effects;
}
inline std::vector<Effect<>> sized_effects(bool with_state) {
  return sized_effects(with_state, static_cast<const Effect<>*>(nullptr));
}

template <class Scalar>
AxisParameters<Scalar> axis_of(const std::vector<Machine>& list) {
  AxisParameters<Scalar> axis;
  axis.mass = of<Scalar>(list, [](const Machine& m) { return m.mass; });
  axis.viscous = of<Scalar>(list, [](const Machine& m) { return m.viscous; });
  axis.coulomb = of<Scalar>(list, [](const Machine& m) { return m.coulomb; });
  axis.coulomb_width = of<Scalar>(list, [](const Machine& m) { return m.coulomb_width; });
  axis.travel = {0.0, 0.51};
  return axis;
}

inline Plant<> plant_of(const Machine& machine) {
  return {axis_of<double>({machine}), CoggingModel<>(plant_basis(), machine.cogging), sized_effects(false),
          EncoderParameters{0.5e-6, 1e-7}, NoiseParameters{0.01, 100.0}};
}

// What makes a controller's memory matter, by the fields that it has.
template <class Parameters>
void tune(Parameters& q) {
  q.command_limit = 2.0;
  if constexpr (requires { q.mass_adaptation; }) {
    q.mass_adaptation = 1.0;
    q.viscous_adaptation = q.coulomb_adaptation = 10.0;
    q.disturbance_adaptation = 1000.0;
    q.cogging_harmonics = {1, 2, 3};
    q.cogging_control_points = 13;
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
    q.mass = 0.12;
    q.coulomb = 0.1;
    q.viscous = 0.2;
    q.feedforward_velocity = "measured";
    if constexpr (requires { q.delay; }) q.delay = 0.00053;
  }
  if constexpr (requires { q.ki; }) q.ki = 1e4;
  if constexpr (requires { q.kd; }) q.kd = 40.0;
  if constexpr (requires { q.kv; }) q.kv = 40.0;
}

}  // namespace drawn
