#pragma once
// An axis that is moved on by whoever gives the commands: the plant of a closed loop without its controller.

#include "cogging/plant/plant.hpp"
#include "cogging/simulation/closed_loop.hpp"
#include "held_commands.hpp"
#include "instantiated.hpp"

namespace cogging::fmi {

/// How a unit starts, and on which grid its noise is drawn.
struct Start {
  double sample_rate = 5000.0;  // Hz
  int steps_per_sample = 1;
  std::uint64_t seed = 0;  // of the noise
  double position = 0.0;   // m
  double velocity = 0.0;   // m/s

  static constexpr auto fields() {
    using S = Start;
    return std::tuple{
        Field{"sample_rate", &S::sample_rate, "Hz", "samples a second", Rule::positive},
        Field{"steps_per_sample", &S::steps_per_sample, "1", "fewest steps of the integrator in a sample"},
        Field{"initial_position", &S::position, "m", "where the axis starts"},
        Field{"initial_velocity", &S::velocity, "m/s", "with which it starts"}};
  }
};

/// The plant at any time, in steps of any length. Force and encoder noise are drawn once a sample and held, as in a
/// run; the integrator's steps end at the samples. So what it does depends on when commands change alone, not on how
/// the time between is cut; and under the commands of a run, given at its samples, it does what the run did, to the
/// bit.
class AxisUnit {
 public:
  /// Raises std::invalid_argument for a parameter that breaks its rule.
  AxisUnit(Plant<> plant, const Start& start)
      : plant_(std::move(plant)),
        rate_(validated(start).sample_rate),
        steps_(start.steps_per_sample),
        axis_(plant_.axis, plant_.cogging, plant_.effects),
        commands_(plant_.effects, 1.0 / start.sample_rate),
        force_noise_(plant_.noise, 1.0 / start.sample_rate, start.seed),
        encoder_noise_(start.seed ^ 0x9e3779b97f4a7c15ULL),
        state_{start.position, start.velocity} {
    validated(plant_.encoder);
    bounds_ = detail::bounds_of(plant_.axis.travel);
    detail::require_bounded(state_, bounds_, plant_.axis.travel, 0.0);
    draw();
  }

  double time() const { return time_; }                // s since the start
  double position() const { return state_.position; }  // m, the true one, of the motor
  double velocity() const { return state_.velocity; }  // m/s
  /// What the encoder shows, m.
  double reading() const {
    return read_encoder(plant_.encoder, encoder_position(plant_.effects, state_.position), encoder_number_);
  }

  /// Holds the command (V) from now on, and moves to a time (s since the start).
  ///
  /// Raises DivergedError where the motion leaves the travel by half its length, or a number.
  void advance(double until, double command) {
    until = snapped(until);
    while (time_ < until) {
      // Anew in each sample, as in a run: then it is the same whether a command is held by one step or by many.
      commands_.accept(sample_, time_ - time_of(sample_), command, time_);
      const double end = time_of(sample_ + 1), to = std::min(until, end);
      move(to);
      time_ = to;
      detail::require_bounded(state_, bounds_, plant_.axis.travel, time_);
      if (to == end) {
        ++sample_;
        draw();
      }
    }
  }

  /// The time of a sample where one is meant: importers add up their steps, and err in the last digits.
  double snapped(double time) const {
    const double samples = time * rate_, nearest = std::round(samples);
    return std::abs(samples - nearest) < 1e-6 + 1e-14 * samples ? nearest / rate_ : time;
  }

 private:
  double time_of(std::int64_t sample) const { return static_cast<double>(sample) / rate_; }

  void draw() {
    encoder_number_ = plant_.encoder.noise > 0.0 ? encoder_noise_() : 0.0;
    force_ = force_noise_();
  }

  // Within one sample.
  void move(double to) {
    const double start = time_of(sample_), end = time_of(sample_ + 1);
    const auto steps_of = [&](double from, double until) {
      const bool whole = from == start && until == end;
      return whole ? steps_ : std::max(1, whole_part(std::ceil(steps_ * (until - from) / (end - start))));
    };
    commands_.over(sample_, start, time_, to, [&](Drive<double> drive, double from, double until) {
      drive.force = force_;
      advance_through_events(axis_, commands_, state_, drive, from, until, steps_of);
    });
  }

  Plant<> plant_;
  double rate_;
  int steps_;
  Axis<> axis_;
  HeldCommands commands_;
  ForceNoise force_noise_;
  NormalNumbers encoder_noise_;
  AxisState<double> state_;
  Range bounds_{};
  double time_ = 0.0, force_ = 0.0, encoder_number_ = 0.0;
  std::int64_t sample_ = 0;
};

}  // namespace cogging::fmi
