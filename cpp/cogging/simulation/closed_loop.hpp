#pragma once
// One run: reference -> controller -> amplifier -> axis -> encoder -> log.

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cogging/control/controller.hpp"
#include "cogging/interruption.hpp"
#include "cogging/plant/amplifier.hpp"
#include "cogging/plant/integration.hpp"
#include "cogging/plant/plant.hpp"
#include "cogging/simulation/log.hpp"

namespace cogging {

struct RunOptions {
  double duration = 0.0;     // s; 0 = the reference's own end
  std::uint64_t seed = 0;    // of the noise
  int steps_per_sample = 1;  // Runge-Kutta steps between two samples
  bool record_estimates = false;
  std::optional<double> initial_position;  // m; the reference's first position when not given
  double initial_velocity = 0.0;           // m/s
  std::vector<double> added_command;       // V, one a row, added to the controller's; empty = none
  StopRequest* stop = nullptr;             // asked in every few rows whether to end the run
};

namespace detail {

inline std::size_t count_samples(const Reference& reference, const RunOptions& options, double sample_rate) {
  const double duration = options.duration > 0.0 ? options.duration : reference.end();
  require(std::isfinite(duration), "duration", "must be given for a reference without an end of its own", duration);
  const double samples = duration * sample_rate;
  require(samples >= 1.0 && samples < 1e9, "duration", "must hold 1 to 1e9 samples", duration);
  return static_cast<std::size_t>(std::floor(samples + 1e-6)) + 1;
}

template <class Scalar>
void record_reference(Log<Scalar>& log, const Reference& reference, double sample_rate, const Range& travel,
                      StopCheck& stop) {
  for (std::size_t k = 0; k < log.time.size(); ++k) {
    stop.row();
    log.time[k] = static_cast<double>(k) / sample_rate;
    const ReferencePoint point = reference.at(log.time[k]);
    if (!(point.position >= travel[0] && point.position <= travel[1]))
      refuse("reference", "must stay within travel [" + format(travel[0]) + ", " + format(travel[1]) + "]",
             format(point.position) + " at " + format(log.time[k]) + " s");
    log.reference[k] = point.position;
    log.reference_velocity[k] = point.velocity;
    log.reference_acceleration[k] = point.acceleration;
  }
}

// Half a travel beyond its ends, the run is over: a number from there would be no measurement of anything.
template <class Scalar>
void require_bounded(const AxisState<Scalar>& state, const Range& travel, double time) {
  const double length = travel[1] - travel[0];
  const double margin = std::isfinite(length) ? 0.5 * length : 0.0;
  const double lower = std::isfinite(travel[0]) ? travel[0] - margin : -1e6;
  const double upper = std::isfinite(travel[1]) ? travel[1] + margin : 1e6;
  if (all(state.position > lower) && all(state.position < upper) && all_finite(state.velocity)) return;
  std::string where = "a lane";
  if constexpr (std::is_same_v<Scalar, double>)
    where = "position " + format(state.position) + " m, velocity " + format(state.velocity) + " m/s";
  throw DivergedError("the run diverged at " + format(time) + " s: " + where + "; the travel is [" + format(travel[0]) +
                      ", " + format(travel[1]) + "] m");
}

}  // namespace detail

/// Integrates the plant over one sample, with `steps` steps of the integrator where nothing happens within it.
template <class Scalar>
void advance_sample(const Axis<Scalar>& axis, Amplifier<Scalar>& amplifier, AxisState<Scalar>& state, double time,
                    double time_next, const Scalar& force, int steps) {
  const double sample_time = time_next - time;
  const auto steps_of = [&](double start, double end) {
    const bool whole = start == time && end == time_next;
    return whole ? steps : std::max(1, int(std::ceil(steps * (end - start) / sample_time)));
  };
  amplifier.over(time, time_next, [&](Drive<Scalar> drive, double from, double to) {
    drive.force = force;
    advance_through_events(axis, amplifier, state, drive, from, to, steps_of);
  });
}

namespace detail {

inline void require_options(const RunOptions& options) {
  require(options.steps_per_sample >= 1 && options.steps_per_sample <= 10000, "steps_per_sample",
          "must be from 1 to 10000", options.steps_per_sample);
  require(std::isfinite(options.duration) && options.duration >= 0.0, "duration",
          "must be finite and above 0 (or left out)", options.duration);
  require_finite("initial_velocity", options.initial_velocity);
  if (options.initial_position) require_finite("initial_position", *options.initial_position);
}

/// A log with the reference of every row, and room for what the run will tell.
template <class Scalar>
Log<Scalar> log_of_reference(const Reference& reference, const RunOptions& options, double sample_rate,
                             const Range& travel, StopCheck& stop) {
  Log<Scalar> log;
  const std::size_t rows = count_samples(reference, options, sample_rate);
  const auto make = [&](auto& column) {
    stop.ask();  // a column of a long run takes long to clear
    column.resize(rows);
  };
  for (auto* column : {&log.time, &log.reference, &log.reference_velocity, &log.reference_acceleration}) make(*column);
  for (auto* column : {&log.position, &log.command, &log.true_position, &log.true_velocity}) make(*column);
  require(options.added_command.empty() || options.added_command.size() >= rows, "added_command",
          "must have an entry for each row", static_cast<double>(options.added_command.size()));
  record_reference(log, reference, sample_rate, travel, stop);
  return log;
}

/// What a controller believes at the start of each row, kept beside the log where that is asked for.
template <class Scalar, class C>
class EstimateRecord {
 public:
  EstimateRecord(const RunOptions& options, const C& controller, Log<Scalar>& log) : kept_(options.record_estimates) {
    if (!kept_) return;
    log.estimate_count = static_cast<int>(controller.estimates().size());
    log.estimates.reserve(log.time.size() * static_cast<std::size_t>(log.estimate_count));
  }

  void keep(const C& controller, Log<Scalar>& log) const {
    if (!kept_) return;
    const std::span<const Scalar> estimates = controller.estimates();
    log.estimates.insert(log.estimates.end(), estimates.begin(), estimates.end());
  }

 private:
  bool kept_;
};

/// The command of row k that acts on the amplifier: cut at the limit, with what is added behind the controller.
template <class Scalar, class C>
COGGING_INLINE Scalar command_of_row(C& controller, const Reference& reference, const Log<Scalar>& log, std::size_t k,
                                     const Scalar& reading, double limit, const std::vector<double>& added) {
  const ReferencePoint point{log.reference[k], log.reference_velocity[k], log.reference_acceleration[k]};
  Scalar command;
  if constexpr (LooksAhead<C>)
    command = controller.command(point, reference.at(log.time[k] + controller.preview()), reading);
  else
    command = controller.command(point, reading);
  if (limit > 0.0) command = clamp(command, Scalar(-limit), Scalar(limit));
  controller.update(command);
  if (added.empty()) return command;
  command += added[k];  // the controller does not know of it
  return limit > 0.0 ? clamp(command, Scalar(-limit), Scalar(limit)) : command;
}

}  // namespace detail

/// A pure function of its arguments: the controller is copied, and the noise comes from the seed.
template <class Scalar, ClosesLoop<Scalar> C>
Log<Scalar> closed_loop(const Plant<Scalar>& plant, C controller, const Reference& reference,
                        const RunOptions& options) {
  detail::require_options(options);
  plant.encoder.validate();
  const double sample_time = 1.0 / controller.sample_rate(), limit = controller.command_limit();
  const Axis<Scalar> axis(plant.axis, plant.cogging, plant.effects);
  Amplifier<Scalar> amplifier(plant.effects, sample_time);
  ForceNoise force_noise(plant.noise, sample_time, options.seed);
  NormalNumbers encoder_noise(options.seed ^ 0x9e3779b97f4a7c15ULL);
  StopCheck stop(options.stop);
  Log<Scalar> log =
      detail::log_of_reference<Scalar>(reference, options, controller.sample_rate(), plant.axis.travel, stop);
  const detail::EstimateRecord<Scalar, C> estimates(options, controller, log);

  AxisState<Scalar> state{options.initial_position.value_or(log.reference.front()), options.initial_velocity};
  for (std::size_t k = 0, rows = log.time.size(); k < rows; ++k) {
    stop.row();
    detail::require_bounded(state, plant.axis.travel, log.time[k]);
    const double noise = plant.encoder.noise > 0.0 ? encoder_noise() : 0.0;
    const Scalar reading = read_encoder(plant.encoder, encoder_position(plant.effects, state.position), noise);
    if constexpr (MayFail<C>) controller.begin_row(k, log.time[k]);
    estimates.keep(controller, log);
    const Scalar command = detail::command_of_row(controller, reference, log, k, reading, limit, options.added_command);
    log.position[k] = reading;
    log.command[k] = command;
    log.true_position[k] = state.position;
    log.true_velocity[k] = state.velocity;
    if (k + 1 == rows) break;
    amplifier.accept(command);
    advance_sample(axis, amplifier, state, log.time[k], log.time[k + 1], Scalar(force_noise()),
                   options.steps_per_sample);
  }
  return log;
}

}  // namespace cogging
