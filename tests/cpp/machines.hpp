#pragma once
// Machines drawn at random with all effects, and parameters with which every controller works: for programs that run
// many of them.

#include <cstddef>
#include <memory>
#include <random>
#include <type_traits>
#include <vector>

#include "cogging/control/list.hpp"
#include "cogging/lanes.hpp"
#include "cogging/plant/plant.hpp"

namespace drawn {

using namespace cogging;

// What differs from lane to lane.
struct Machine {
  double mass, viscous, coulomb, coulomb_width, stiffness, static_excess, limit, lag;
  double mass_estimate, error_gain, feedback_gain;
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
              uniform(0.0, 2.0), uniform(0.0, 0.1),     uniform(1.0, 3.0),   uniform(1e-4, 1e-3),
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

// Drag of a user's own, which falls again beyond a speed.
class EddyDrag final : public OwnLaw {
 public:
  double at(double, double velocity, double) const override {
    return -0.05 * velocity / (1.0 + 16.0 * velocity * velocity);
  }
};

template <class Scalar>
Plant<Scalar> plant_of(const std::vector<Machine>& list) {
  AxisParameters<Scalar> axis;
  axis.mass = of<Scalar>(list, [](const Machine& m) { return m.mass; });
  axis.viscous = of<Scalar>(list, [](const Machine& m) { return m.viscous; });
  axis.coulomb = of<Scalar>(list, [](const Machine& m) { return m.coulomb; });
  axis.coulomb_width = of<Scalar>(list, [](const Machine& m) { return m.coulomb_width; });
  axis.travel = {0.0, 0.51};
  std::vector<Scalar> coefficients;
  for (int c = 0; c < plant_basis().coefficients(); ++c)
    coefficients.push_back(of<Scalar>(list, [c](const Machine& m) { return m.cogging[c]; }));
  CableSpring<Scalar> spring;
  spring.stiffness = of<Scalar>(list, [](const Machine& m) { return m.stiffness; });
  StribeckFriction<Scalar> stribeck;
  stribeck.static_excess = of<Scalar>(list, [](const Machine& m) { return m.static_excess; });
  CommandSaturation<Scalar> saturation;
  saturation.limit = of<Scalar>(list, [](const Machine& m) { return m.limit; });
  ActuatorLag<Scalar> lag;
  lag.time_constant = of<Scalar>(list, [](const Machine& m) { return m.lag; });
  CoulombAsymmetry<Scalar> coulomb_asymmetry;
  coulomb_asymmetry.difference = of<Scalar>(list, [](const Machine& m) { return 0.1 * m.coulomb; });
  ViscousAsymmetry<Scalar> viscous_asymmetry;
  viscous_asymmetry.difference = of<Scalar>(list, [](const Machine& m) { return 0.1 * m.viscous; });
  QuadraticDrag<Scalar> drag;
  drag.coefficient = of<Scalar>(list, [](const Machine& m) { return 0.2 * m.viscous; });
  CoggingHarmonic<Scalar> harmonic;
  harmonic.period = of<Scalar>(list, [](const Machine& m) { return 0.1 * m.mass; });
  harmonic.sine = of<Scalar>(list, [](const Machine& m) { return 0.1 * m.coulomb; });
  DisturbanceStep<Scalar> step;
  step.level = of<Scalar>(list, [](const Machine& m) { return m.coulomb; });
  step.start = 0.20003;
  step.stop = 0.30004;
  DisturbanceTone<Scalar> tone;
  tone.frequency = of<Scalar>(list, [](const Machine& m) { return 100.0 * m.mass; });
  tone.sine = of<Scalar>(list, [](const Machine& m) { return 0.1 * m.coulomb; });
  ForceConstantRipple<Scalar> ripple;
  ripple.period = of<Scalar>(list, [](const Machine& m) { return 0.3 * m.mass; });
  ripple.sine = of<Scalar>(list, [](const Machine& m) { return 0.2 * m.coulomb; });
  ForceConstantDrift<Scalar> drift;
  drift.change = of<Scalar>(list, [](const Machine& m) { return 0.2 * m.mass; });
  drift.time_constant = of<Scalar>(list, [](const Machine& m) { return m.coulomb; });
  CommandDeadZone<Scalar> dead_zone;
  dead_zone.width = of<Scalar>(list, [](const Machine& m) { return 0.1 * m.coulomb; });
  EncoderPeriodicError<Scalar> wrong_by_period;
  wrong_by_period.sine = of<Scalar>(list, [](const Machine& m) { return 1e-5 * m.mass; });
  EncoderScaleError<Scalar> wrong_by_scale;
  wrong_by_scale.scale = of<Scalar>(list, [](const Machine& m) { return 1e-3 * m.mass; });
  EndEffect<Scalar> ends;
  ends.level = of<Scalar>(list, [](const Machine& m) { return m.coulomb; });
  ends.decay_length = of<Scalar>(list, [](const Machine& m) { return 0.2 * m.mass; });
  CoggingModulation<Scalar> modulation;
  for (int c = 0; c < 13; ++c) {
    modulation.sine.push_back(0.01 * c);
    modulation.cosine.push_back(-0.005 * c);
  }
  PositionDependentFriction<Scalar> along;
  along.nodes = {0.1, 0.2, 0.4};
  along.levels = {0.05, -0.02, 0.1};
  Custom<Scalar> own;
  own.label = "eddy_drag";
  own.force_law = std::make_shared<const EddyDrag>();
  ConstantForce<Scalar> force;
  force.level = of<Scalar>(list, [](const Machine& m) { return 0.1 * m.coulomb; });
  return {axis,
          CoggingModel<Scalar>(plant_basis(), coefficients),
          {spring,
           stribeck,
           saturation,
           lag,
           CommandDelay<Scalar>{0.00013},
           coulomb_asymmetry,
           viscous_asymmetry,
           drag,
           harmonic,
           step,
           tone,
           force,
           ripple,
           drift,
           dead_zone,
           wrong_by_period,
           wrong_by_scale,
           ends,
           modulation,
           along,
           own,
           PreslidingFriction<Scalar>{},
           Backlash<Scalar>{},
           FlexibleMode<Scalar>{}},
          EncoderParameters{0.5e-6, 1e-7},
          NoiseParameters{0.01, 100.0}};
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
