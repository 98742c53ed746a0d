#pragma once
// One run: reference -> controller -> amplifier -> axis -> encoder -> recorder.

#include <optional>

#include "cogging/control/controller.hpp"
#include "cogging/interruption.hpp"
#include "cogging/memory.hpp"
#include "cogging/plant/amplifier.hpp"
#include "cogging/plant/integration.hpp"
#include "cogging/plant/plant.hpp"
#include "cogging/scalar.hpp"
#include "cogging/simulation/recorder.hpp"
#include "cogging/simulation/reference_rows.hpp"

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

// Half a travel beyond its ends, the run is over: a number from there would be no measurement of anything.
inline Range bounds_of(const Range& travel) {
  const double length = travel[1] - travel[0];
  const double margin = std::isfinite(length) ? 0.5 * length : 0.0;
  return {std::isfinite(travel[0]) ? travel[0] - margin : -1e6, std::isfinite(travel[1]) ? travel[1] + margin : 1e6};
}

template <class Scalar>
COGGING_INLINE bool is_bounded(const AxisState<Scalar>& state, const Range& bounds) {
  return all(state.position > bounds[0]) && all(state.position < bounds[1]) && all_finite(state.velocity);
}

template <class Scalar>
[[noreturn]] COGGING_NOINLINE void refuse_state(const AxisState<Scalar>& state, const Range& travel, double time) {
  std::string where = "a lane";
  if constexpr (std::is_same_v<Scalar, double>)
    where = "position " + format(state.position) + ", velocity " + format(state.velocity);
  throw DivergedError("the run diverged at " + format(time) + " s: " + where + "; the travel is [" + format(travel[0]) +
                          ", " + format(travel[1]) + "]",
                      time);
}

template <class Scalar>
COGGING_INLINE void require_bounded(const AxisState<Scalar>& state, const Range& bounds, const Range& travel,
                                    double time) {
  if (!is_bounded(state, bounds)) [[unlikely]]
    refuse_state(state, travel, time);
}

// Where events happen within the sample, or the command changes or settles in it.
template <class AnyAxis, class Scalar>
COGGING_NOINLINE void advance_eventful_sample(AnyAxis& axis, Amplifier<Scalar>& amplifier, AxisState<Scalar>& state,
                                              double time, double time_next, const Scalar& force, int steps) {
  const double sample_time = time_next - time;
  const auto steps_of = [&](double start, double end) {
    const bool whole = start == time && end == time_next;
    return whole ? steps : std::max(1, whole_part(std::ceil(steps * (end - start) / sample_time)));
  };
  amplifier.over(time, time_next, [&](Drive<Scalar> drive, double from, double to) {
    drive.force = force;
    advance_through_events(axis, amplifier, state, drive, from, to, steps_of);
  });
}

/// Integrates the plant over one sample, with `steps` steps of the integrator where nothing happens within it.
template <class AnyAxis, class Scalar>
COGGING_INLINE void advance_sample(AnyAxis& axis, Amplifier<Scalar>& amplifier, AxisState<Scalar>& state, double time,
                                   double time_next, const Scalar& force, int steps) {
  if (!amplifier.holds() || axis.has_events()) {
    advance_eventful_sample(axis, amplifier, state, time, time_next, force, steps);
    return;
  }
  Drive<Scalar> drive = amplifier.held();
  drive.force = force;
  if (steps == 1) {
    axis.advance(state, drive, time, time_next - time);
    return;
  }
  const double h = (time_next - time) / steps;
  for (int step = 0; step < steps; ++step) axis.advance(state, drive, time + step * h, h);
}

inline void require_options(const RunOptions& options) {
  require(options.steps_per_sample >= 1 && options.steps_per_sample <= 10000, "steps_per_sample",
          "must be from 1 to 10000", options.steps_per_sample);
  require(std::isfinite(options.duration) && options.duration >= 0.0, "duration",
          "must be finite and above 0 (or left out)", options.duration);
  require_finite("initial_velocity", options.initial_velocity);
  if (options.initial_position) require_finite("initial_position", *options.initial_position);
}

/// A command that comes when the run is over is none.
inline void require_delay(std::string_view name, double delay, const ReferenceRows& reference) {
  const double end = reference.time(reference.size() - 1);
  require(delay <= 0.0 || delay < end, name, "must be shorter than the run of " + format(end) + " s", delay);
}

/// Refuses what no run along these rows can have, and tells the recorder of them.
template <class Scalar, class C>
void begin_run(Recorder<Scalar>& recorder, const C& controller, double amplifier_delay, const Range& travel,
               const ReferenceRows& reference, const RunOptions& options, StopCheck& stop) {
  require_delay("command_delay.delay", amplifier_delay, reference);
  if constexpr (requires { controller.dead_time(); })
    require_delay("controller.delay", controller.dead_time(), reference);
  recorder.begin(reference.size(), reference.sample_rate(), stop);
  require(options.added_command.empty() || options.added_command.size() >= reference.size(), "added_command",
          "must have an entry for each row", options.added_command.size());
  reference.require_within(travel);
}

/// The command of row k that acts on the amplifier: cut at the limit, with what is added behind the controller.
template <class Scalar, class C>
COGGING_INLINE Scalar command_of_row(C& controller, const ReferenceRows& reference, std::size_t k, double time,
                                     const ReferencePoint& point, const Scalar& reading, double limit,
                                     const std::vector<double>& added) {
  Scalar command = command_at(controller, reference.reference(), time, point, reading);
  if (limit > 0.0) command = clamp(command, Scalar(-limit), Scalar(limit));
  controller.update(command);
  if (added.empty()) return command;
  command += added[k];  // the controller does not know of it
  return limit > 0.0 ? clamp(command, Scalar(-limit), Scalar(limit)) : command;
}

}  // namespace detail

/// Runs the plant under a copy of the controller along `reference`, whose rate is the controller's, and tells
/// `recorder` every row. options.duration and record_estimates are not looked at: the reference's rows and the recorder
/// say it.
template <class Scalar, ClosesLoop<Scalar> C>
void closed_loop_into(Recorder<Scalar>& recorder, const Plant<Scalar>& plant, C controller,
                      const ReferenceRows& reference, const RunOptions& options) {
  detail::require_options(options);
  validated(plant.encoder);
  const double sample_time = 1.0 / controller.sample_rate(), limit = controller.command_limit();
  require(reference.sample_rate() == controller.sample_rate(), "sample_rate", "must be that of the reference's rows",
          controller.sample_rate());
  Axis<Scalar> axis(plant.axis, plant.cogging, plant.effects);
  axis.expect_steps(sample_time / options.steps_per_sample);
  Amplifier<Scalar> amplifier(plant.effects, sample_time);
  ForceNoise force_noise(plant.noise, sample_time, options.seed);
  NormalNumbers encoder_noise(options.seed ^ 0x9e3779b97f4a7c15ULL);
  StopCheck stop(options.stop);
  const std::size_t rows = reference.size();
  const bool keeps_estimates = recorder.keeps_estimates();
  detail::begin_run(recorder, controller, amplifier.delay(), plant.axis.travel, reference, options, stop);

  AxisState<Scalar> state{options.initial_position.value_or(reference.at(0).position), options.initial_velocity};
  const Range bounds = detail::bounds_of(plant.axis.travel);
  double time = 0.0;
  for (std::size_t k = 0; k < rows; ++k) {
    stop.row();
    detail::require_bounded(state, bounds, plant.axis.travel, time);
    const double noise = plant.encoder.noise > 0.0 ? encoder_noise() : 0.0;
    const Scalar reading = read_encoder(plant.encoder, encoder_position(plant.effects, state.position), noise);
    if constexpr (MayFail<C>) controller.begin_row(k, time);
    if (keeps_estimates) recorder.estimates(controller.estimates());
    const ReferencePoint point = reference.at(k);
    const Scalar command =
        detail::command_of_row(controller, reference, k, time, point, reading, limit, options.added_command);
    recorder.row({k, time, point, reading, command, state.position, state.velocity});
    if (k + 1 == rows) break;
    amplifier.accept(command);
    const double next = reference.time(k + 1);
    detail::advance_sample(axis, amplifier, state, time, next, Scalar(force_noise()), options.steps_per_sample);
    time = next;
  }
}

/// The log of a run. A pure function of its arguments: the controller is copied, and the noise comes from the seed.
/// Raises std::invalid_argument for more samples than fit into memory, before it takes any.
template <class Scalar, ClosesLoop<Scalar> C>
Log<Scalar> closed_loop(const Plant<Scalar>& plant, C controller, const Reference& reference,
                        const RunOptions& options) {
  detail::require_options(options);
  StopCheck stop(options.stop);
  const auto count = static_cast<double>(ReferenceRows::count(reference, options.duration, controller.sample_rate()));
  const std::size_t estimates = options.record_estimates ? controller.estimates().size() : 0;
  const auto width = static_cast<double>(log_columns + estimates);
  require_memory("duration", 8.0 * count * width, format(count) + " samples of " + format(width) + " columns",
                 format(ReferenceRows::length(reference, options.duration)));
  ReferenceRows rows(reference, options.duration, controller.sample_rate(), stop,
                     std::numeric_limits<std::size_t>::max());
  LogRecorder<Scalar> recorder(options.record_estimates);
  closed_loop_into<Scalar>(recorder, plant, std::move(controller), rows, options);
  Log<Scalar> log = std::move(recorder.log);
  std::move(rows).move_to(log.reference, log.reference_velocity, log.reference_acceleration);
  return log;
}

}  // namespace cogging
