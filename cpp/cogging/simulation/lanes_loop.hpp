#pragma once
// Many runs side by side in the lanes of a pack, each with the bits that it has alone.

#include <algorithm>
#include <exception>
#include <span>

#include "cogging/simulation/closed_loop.hpp"
#include "cogging/simulation/packing.hpp"

namespace cogging {

/// One of the runs of a pack: what it is, and what ended it before its end; null where nothing did.
struct RunInLane {
  const Plant<double>* plant = nullptr;
  std::uint64_t seed;
  std::optional<double> initial_position;  // m; the reference's first position when not given
  std::exception_ptr ended = nullptr;
};

/// Which lanes hold a run that goes on. The others, of runs that have ended or never were, follow the first of them:
/// the numbers in them are those of no run.
template <std::size_t count>
class LanesAtWork {
 public:
  explicit LanesAtWork(std::span<RunInLane> runs) : runs_(runs), left_(runs.size()) {
    for (std::size_t i = 0; i < count; ++i) at_work_[i] = i < runs.size();
  }

  bool operator[](std::size_t i) const { return at_work_[i]; }
  bool none() const { return left_ == 0; }
  bool all() const { return left_ == count; }
  std::size_t first() const {
    return static_cast<std::size_t>(std::find(at_work_.begin(), at_work_.end(), true) - at_work_.begin());
  }

  /// Does something for lane i, whose run ends with what it throws.
  template <class Work>
  void guard(std::size_t i, const Work& work) {
    if (!at_work_[i]) return;
    try {
      work();
    } catch (...) {
      runs_[i].ended = std::current_exception();
      at_work_[i] = false;
      --left_;
    }
  }

 private:
  std::span<RunInLane> runs_;
  std::size_t left_;
  std::array<bool, count> at_work_{};
};

/// The axes of a pack: a step of all lanes at once, and where that is not accurate in a lane, the step of its axis
/// alone.
template <std::size_t count>
class AxesInLanes {
 public:
  using Scalar = Lanes<count>;

  AxesInLanes(const Plant<Scalar>& pack, const std::array<const Plant<double>*, count>& plants,
              LanesAtWork<count>& at_work, double longest_step)
      : together_(pack.axis, pack.cogging, pack.effects), at_work_(at_work) {
    together_.expect_steps(longest_step);
    for (const Plant<double>* plant : plants) alone_.emplace_back(plant->axis, plant->cogging, plant->effects);
  }

  bool has_events() const { return together_.has_events(); }
  double next_event(double time) const { return together_.next_event(time); }

  void advance(AxisState<Scalar>& state, const Drive<Scalar>& drive, double time, double h) {
    const AxisState<Scalar> start = state;
    const Scalar excess = together_.try_step(state, drive, time, h);
    if (!all(excess <= 0.0)) [[unlikely]]
      advance_alone(state, start, excess, drive, time, h);
    state.speed_max = larger(state.speed_max, abs(state.velocity));
  }

 private:
  COGGING_NOINLINE void advance_alone(AxisState<Scalar>& state, const AxisState<Scalar>& start, const Scalar& excess,
                                      const Drive<Scalar>& drive, double time, double h) {
    for (std::size_t i = 0; i < count; ++i) {
      if (lane(excess, i) <= 0.0) continue;
      at_work_.guard(i, [&] {
        AxisState<double> one{lane(start.position, i), lane(start.velocity, i)};
        one.speed_max = lane(start.speed_max, i);
        const Drive<double> driven{lane(drive.target, i), lane(drive.deviation, i), lane(drive.rate, i),
                                   lane(drive.force, i), drive.lagging};
        alone_[i].advance(one, driven, time, h);
        set_lane(state.position, i, one.position);
        set_lane(state.velocity, i, one.velocity);
      });
    }
  }

  Axis<Scalar> together_;
  std::vector<Axis<double>> alone_;
  LanesAtWork<count>& at_work_;
};

/// The machines of a pack, sample by sample.
template <std::size_t count>
class MachinesInLanes {
 public:
  using Scalar = Lanes<count>;
  using Plants = std::array<const Plant<double>*, count>;

  MachinesInLanes(std::span<RunInLane> runs, double sample_time, double start, const RunOptions& options)
      : at_work_(runs),
        plants_(plants_of(runs)),
        pack_(packed_plant<count>(plants_)),
        bounds_(detail::bounds_of(pack_.axis.travel)),
        axes_(pack_, plants_, at_work_, sample_time / options.steps_per_sample),
        amplifier_(pack_.effects, sample_time),
        steps_(options.steps_per_sample),
        state_{start, options.initial_velocity} {
    for (std::size_t i = 0; i < count; ++i) {
      const Plant<double>& plant = *plants_[i];
      const RunInLane& run = runs[std::min(i, runs.size() - 1)];
      validated(plant.encoder);
      set_lane(state_.position, i, run.initial_position.value_or(start));
      force_noise_.emplace_back(plant.noise, sample_time, run.seed);
      encoder_noise_.emplace_back(run.seed ^ 0x9e3779b97f4a7c15ULL);
      set_lane(resolution_, i, plant.encoder.resolution);
      noisy_ = noisy_ || plant.encoder.noise > 0.0;
      pushed_ = pushed_ || plant.noise.force > 0.0;
    }
  }

  double delay() const { return amplifier_.delay(); }
  bool none_left() const { return at_work_.none(); }
  const AxisState<Scalar>& state() const { return state_; }

  /// Ends runs that have left their travel.
  void require_bounded(double time) {
    if (!at_work_.all()) fill_idle_lanes();
    if (detail::is_bounded(state_, bounds_)) [[likely]]
      return;
    for (std::size_t i = 0; i < count; ++i)
      at_work_.guard(i, [&] {
        const AxisState<double> one{lane(state_.position, i), lane(state_.velocity, i)};
        detail::require_bounded(one, bounds_, pack_.axis.travel, time);
      });
    fill_idle_lanes();
  }

  Scalar reading() {
    Scalar noise = 0.0;
    if (noisy_)
      noise = Scalar::map([&](std::size_t i) {
        const double rms = plants_[i]->encoder.noise;
        return rms > 0.0 ? rms * encoder_noise_[i]() : 0.0;
      });
    const Scalar seen = encoder_position(pack_.effects, state_.position) + noise;
    return lane(resolution_, 0) > 0.0 ? resolution_ * round(seen / resolution_) : seen;
  }

  /// The command acts over the sample from `time` to `next`.
  void move(const Scalar& command, double time, double next) {
    Scalar shaped = amplifier_.shaped(command);
    if (!all_finite(shaped)) [[unlikely]]
      for (std::size_t i = 0; i < count; ++i) {
        if (std::isfinite(lane(shaped, i))) continue;
        at_work_.guard(i, [&] { amplifier_.refuse_command(lane(shaped, i)); });
        set_lane(shaped, i, 0.0);
      }
    amplifier_.pass_on(shaped);
    Scalar force = 0.0;
    if (pushed_) force = Scalar::map([&](std::size_t i) { return force_noise_[i](); });
    detail::advance_sample(axes_, amplifier_, state_, time, next, force, steps_);
  }

 private:
  static Plants plants_of(std::span<RunInLane> runs) {
    Plants plants;
    for (std::size_t i = 0; i < count; ++i) plants[i] = runs[std::min(i, runs.size() - 1)].plant;
    return plants;
  }

  COGGING_NOINLINE void fill_idle_lanes() {
    if (at_work_.none()) return;
    const std::size_t from = at_work_.first();
    for (std::size_t i = 0; i < count; ++i)
      if (!at_work_[i])
        for (Scalar* part : {&state_.position, &state_.velocity, &state_.speed_max})
          set_lane(*part, i, lane(*part, from));
  }

  LanesAtWork<count> at_work_;
  Plants plants_;
  Plant<Scalar> pack_;
  Range bounds_;
  AxesInLanes<count> axes_;
  Amplifier<Scalar> amplifier_;
  std::vector<ForceNoise> force_noise_;
  std::vector<NormalNumbers> encoder_noise_;
  Scalar resolution_;
  bool noisy_ = false, pushed_ = false;
  int steps_;
  AxisState<Scalar> state_;
};

/// Runs the machines of a pack, all of one course, under the controllers of another pack, and tells `recorder` every
/// row; see closed_loop_into. A run that ends before its end says so in `runs`, and the others go on: what the recorder
/// is told of it afterwards is nothing. Where each starts stands in `runs`, not in the options.
template <std::size_t count, ClosesLoop<Lanes<count>> C>
void closed_loop_in_lanes(Recorder<Lanes<count>>& recorder, std::span<RunInLane> runs, C controller,
                          const ReferenceRows& reference, const RunOptions& options) {
  using Scalar = Lanes<count>;
  detail::require_options(options);
  const double limit = controller.command_limit();
  MachinesInLanes<count> machines(runs, 1.0 / controller.sample_rate(), reference.at(0).position, options);
  StopCheck stop(options.stop);
  const std::size_t rows = reference.size();
  detail::begin_run(recorder, controller, machines.delay(), runs[0].plant->axis.travel, reference, options, stop);
  double time = 0.0;
  for (std::size_t k = 0; k < rows; ++k) {
    stop.row();
    machines.require_bounded(time);
    if (machines.none_left()) return;
    const Scalar reading = machines.reading();
    const ReferencePoint point = reference.at(k);
    const Scalar command =
        detail::command_of_row(controller, reference, k, time, point, reading, limit, options.added_command);
    const AxisState<Scalar>& state = machines.state();
    recorder.row({k, time, point, reading, command, state.position, state.velocity});
    if (k + 1 == rows) return;
    const double next = reference.time(k + 1);
    machines.move(command, time, next);
    time = next;
  }
}

}  // namespace cogging
