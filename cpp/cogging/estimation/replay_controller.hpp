#pragma once
// What a controller would have commanded: the loop is open, the readings are given.

#include "cogging/control/controller.hpp"
#include "cogging/interruption.hpp"
#include "cogging/reference/sampled.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// The command of every row when a fresh controller is fed the references and readings of a log, one call a row,
/// whatever the rows' times are. It is told that its own command, cut at its limit, was applied, or, where `applied`
/// is not empty, what it holds. A controller that looks ahead sees the reference interpolated between rows.
template <ClosesLoop<double> C>
std::vector<double> replay_controller(C controller, const std::vector<double>& time,
                                      const std::vector<double>& reference,
                                      const std::vector<double>& reference_velocity,
                                      const std::vector<double>& reference_acceleration,
                                      std::span<const double> position, std::span<const double> applied,
                                      StopRequest* request = nullptr) {
  const Sampled motion(time, reference, reference_velocity, reference_acceleration);
  const std::size_t rows = time.size();
  require(position.size() == rows, "position", "must be as long as time", position.size());
  require(applied.empty() || applied.size() == rows, "applied", "must be as long as time", applied.size());
  for (std::size_t k = 0; k < rows; ++k) require_finite("position", position[k]);
  for (const double& value : applied) require_finite("applied", value);
  const double limit = controller.command_limit();
  std::vector<double> commands(rows);
  StopCheck stop(request);
  for (std::size_t k = 0; k < rows; ++k) {
    stop.row();
    const ReferencePoint point = motion.sample(k);
    if constexpr (MayFail<C>) controller.begin_row(k, time[k]);
    double command = command_at(controller, motion, time[k], point, position[k]);
    if (limit > 0.0) command = clamp(command, -limit, limit);
    controller.update(applied.empty() ? command : applied[k]);
    commands[k] = command;
  }
  return commands;
}

}  // namespace cogging
