#pragma once
// What one more effect adds to the forces along a given motion: its own law alone is evaluated, and the plant that it
// joins once for all of them.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "cogging/estimation/prediction.hpp"
#include "cogging/plant/plant.hpp"
#include "cogging/plant/recorded_amplifier.hpp"

namespace cogging {

/// Whether an effect changes what reaches the motor: by shape, delay or lag.
template <class E>
concept AltersCommand = HasShapeCommand<E, double> || HasCommandDelay<E> || HasLag<E>;

class AddedForce {
 public:
  /// Position and velocity are those half-way between row k and row k + 1, as in net_force.
  AddedForce(const Plant<double>& plant, const Recording& log, std::span<const double> middle_position,
             std::span<const double> middle_velocity, StopRequest* stop = nullptr)
      : plant_(plant), log_(log), stop_(stop), context_(context_of(plant.axis, plant.cogging)) {
    const std::size_t rows = log.time.size();
    const Axis<double> axis(plant.axis, plant.cogging, plant.effects);
    RecordedAmplifier amplifier(plant.effects, log.time, log.command);
    std::vector<Row> made;
    made.reserve(rows - 1);
    StopCheck check(stop_);
    for (std::size_t k = 0; k + 1 < rows; ++k) {
      check.row();
      const double start = log.time[k], end = log.time[k + 1];
      const double v = middle_velocity[k];
      const Motion<double> motion{middle_position[k], v, smooth_sign(v, plant.axis.coulomb_width), 0.5 * (start + end)};
      made.push_back({motion, amplifier.moments(start, end), axis.summed_friction_level(motion),
                      1.0 + axis.command_gain(motion.position, motion.time)});
    }
    rows_ = std::make_shared<const std::vector<Row>>(std::move(made));
  }

  /// The same, in which another is asked whether to end.
  AddedForce heeding(StopRequest* stop) const {
    AddedForce other = *this;
    other.stop_ = stop;
    return other;
  }

  /// Adds to `force` (V, one entry a row) what the effect pushes with, friction taken off, and to `excess` (V s^2, see
  /// ObserverLoop::pass) how early in each interval it does; both per `size` of it.
  void add(Effect<double> effect, double size, std::span<double> force, std::span<double> excess) const {
    const double share = 1.0 / size;
    visit_law(effect, [&](HasBind auto& law) { law.bind(context_); });
    bool at_once = false;
    visit_law(effect, [&](const AnswersAlong auto& law) {
      add_along(law, share, force);
      at_once = true;
    });
    if (!at_once) add_row_by_row(effect, share, force, excess);
    force.back() = force[force.size() - 2];
  }

 private:
  struct Row {
    Motion<double> motion;
    CommandMoments acting;
    double friction_level, gain;  // V, before it is kept from pushing; 1, of the command
  };

  void add_row_by_row(const Effect<double>& effect, double share, std::span<double> force,
                      std::span<double> excess) const {
    const auto add_pushes = [&](const auto& push) {  // push(row), V
      StopCheck check(stop_);
      for (std::size_t k = 0; k < rows_->size(); ++k) {
        check.row();
        force[k] += push((*rows_)[k]) * share;
      }
    };
    visit_law(effect, [&](const HasForce<double> auto& law) {
      add_pushes([&](const Row& row) { return law.force(row.motion); });
    });
    visit_law(effect, [&](const HasFrictionLevel<double> auto& law) {
      add_pushes([&](const Row& row) {  // friction never pushes
        const double level = std::max(row.friction_level + law.friction_level(row.motion), 0.0);
        return -(level - std::max(row.friction_level, 0.0)) * row.motion.direction;
      });
    });
    visit_law(effect, [&](const HasCommandGain<double> auto& law) {
      add_pushes(
          [&](const Row& row) { return law.command_gain(row.motion.position, row.motion.time) * row.acting.mean; });
    });
    visit_law(effect, [&](const AltersCommand auto&) { add_command(effect, share, force, excess); });
  }

  // All rows in one call of each law.
  template <class E>
  void add_along(const E& law, double share, std::span<double> force) const {
    std::vector<double> position, velocity, time;
    for (const Row& row : *rows_) {
      position.push_back(row.motion.position);
      velocity.push_back(row.motion.velocity);
      time.push_back(row.motion.time);
    }
    const Course course{position, velocity, time};
    const std::vector<double> pushes = law.along(Hook::force, course);
    const std::vector<double> levels = law.along(Hook::friction_level, course);
    const std::vector<double> gains = law.along(Hook::command_gain, course);
    for (std::size_t k = 0; k < rows_->size(); ++k) {
      const Row& row = (*rows_)[k];
      const double level = std::max(row.friction_level + levels[k], 0.0) - std::max(row.friction_level, 0.0);
      force[k] += (pushes[k] - level * row.motion.direction + gains[k] * row.acting.mean) * share;
    }
  }

  void add_command(const Effect<double>& effect, double share, std::span<double> force,
                   std::span<double> excess) const {
    std::vector<Effect<double>> effects = plant_.effects;
    effects.push_back(effect);
    RecordedAmplifier amplifier(effects, log_.time, log_.command);
    StopCheck check(stop_);
    for (std::size_t k = 0; k < rows_->size(); ++k) {
      check.row();
      const Row& row = (*rows_)[k];
      const CommandMoments acting = amplifier.moments(log_.time[k], log_.time[k + 1]);
      force[k] += (acting.mean - row.acting.mean) * row.gain * share;
      excess[k] += (acting.excess - row.acting.excess) * row.gain * share;
    }
  }

  const Plant<double>& plant_;
  const Recording& log_;
  StopRequest* stop_;
  PlantContext context_;
  std::shared_ptr<const std::vector<Row>> rows_;
};

}  // namespace cogging
