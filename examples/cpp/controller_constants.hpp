// Generated from model.toml by generate.py: change the model and generate again.
#pragma once

#include <limits>

#include "cogging/control/adaptive_robust.hpp"
#include "cogging/plant/plant.hpp"

namespace constants {

using Controller = cogging::Dcarc<>;

inline Controller::Parameters controller() {
  Controller::Parameters q;
  q.sample_rate = 5000.0;
  q.error_gain = 200.0;
  q.feedback_gain = 48.0;
  q.mass = 0.13;
  q.mass_bounds = {0.1, 0.2};
  q.mass_adaptation = 1.0;
  q.viscous = 0.2;
  q.viscous_bounds = {0.0, 1.0};
  q.viscous_adaptation = 10.0;
  q.coulomb = 0.1;
  q.coulomb_bounds = {0.0, 1.0};
  q.coulomb_adaptation = 10.0;
  q.coulomb_width = 0.00111;
  q.disturbance = 0.0;
  q.disturbance_bounds = {-1.0, 1.0};
  q.disturbance_adaptation = 1000.0;
  q.cogging_pitch = 0.05;
  q.cogging_harmonics = {1, 2, 3};
  q.cogging_order = 3;
  q.cogging_origin = 0.0;
  q.cogging_control_points = 1;
  q.cogging_bounds = {-0.1, 0.1};
  q.cogging_adaptation = 100.0;
  q.cogging_estimates = {};
  q.epsilon = 0.0;
  q.disturbance_bound = 0.0;
  q.command_limit = 10.0;
  q.error_difference = false;
  return q;
}

/// The machine as the model has it, for a loop without one.
inline cogging::Plant<> plant() {
  cogging::Plant<> p;
  p.axis.mass = 0.12;
  p.axis.viscous = 0.166;
  p.axis.coulomb = 0.15;
  p.axis.coulomb_width = 0.00111;
  p.axis.travel = {0.0, 0.51};
  p.encoder.resolution = 5e-07;
  p.encoder.noise = 0.0;
  const auto basis = cogging::SplineHarmonics::of_harmonics(0.05, {1, 2, 3}, cogging::BSpline(1, 0.0, 0.05, 1));
  p.cogging = cogging::CoggingModel<>(basis, {0.08, 0.0, 0.04, 0.02, 0.01, 0.0});
  return p;
}

}  // namespace constants
