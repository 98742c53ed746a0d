#pragma once
// What one more effect adds to the innovations of a plant, to first order along its prediction.

#include <algorithm>
#include <array>
#include <cstddef>
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "cogging/estimation/added_force.hpp"
#include "cogging/estimation/added_load.hpp"
#include "cogging/estimation/observer_loop.hpp"
#include "cogging/simulation/batch.hpp"

namespace cogging {

/// Whether friction and a heavy load decide each other's moments, which no solution along the prediction foresees
/// (wrong by up to 10 %): a load that rings from one reversal of the axis to the next, or strikes with play.
inline bool friction_decides(const CouplingParameters& coupling, const AxisParameters<double>& axis) {
  constexpr double slow = 6.0, light = 0.1;  // 1/s; load over total, below which the motor hardly feels it
  const bool strikes = coupling.gap > 0.0 || coupling.pushes_only;
  return axis.coulomb > 0.0 && coupling.mass_ratio > light && (strikes || decay_rate(coupling, axis) < slow);
}

/// Whether what an effect adds to a plant can be told along the plant's prediction: forces, a command and a load of
/// its own can, a bristle and errors of the reading cannot, nor what has a memory beside a bristle or a load.
inline bool is_addable(const Plant<double>& plant, const Effect<double>& effect) {
  bool has_states = false, addable = true;
  for_each_law(plant.effects, [&](const HasState auto&) { has_states = true; });
  visit_law(effect, [&](const HasCoupling auto& law) {
    if (has_states || friction_decides(law.coupling(), plant.axis)) addable = false;
  });
  visit_law(effect, [&](const AltersCommand auto&) {
    if (has_states) addable = false;
  });
  visit_law(effect, [&](const HasBristle auto&) { addable = false; });
  visit_law(effect, [&](const HasReading<double> auto& law) {
    if (uses(law, Hook::reading_error)) addable = false;
  });
  return addable;
}

/// A plant along its prediction on a log, to which effects are added. What all of them need is worked out once, when
/// the first asks for it.
class PlantAlong {
 public:
  /// `along` and what `log` shows must outlive this.
  PlantAlong(Plant<double> plant, const Prediction& along, const Recording& log, const PredictionOptions& options)
      : plant_(std::move(plant)), along_(along), log_(log), loop_(along, log, options) {}

  std::size_t rows() const { return loop_.rows(); }

  /// What each effect adds to the innovations of the plant, m, per size of it, to first order along the prediction:
  /// (effects, rows).
  ///
  /// Raises std::invalid_argument for an effect that is not valid or not addable (see is_addable), for sizes that are
  /// not one an effect.
  std::vector<double> added(const std::vector<Effect<double>>& effects, const std::vector<double>& sizes,
                            unsigned threads, StopRequest* stop = nullptr) const {
    require(sizes.size() == effects.size(), "sizes", "must be as many as effects", static_cast<double>(sizes.size()));
    for (const double size : sizes) require_positive("sizes", size);
    for (const Effect<double>& effect : effects)
      visit_law(effect, [&](const auto& law) {
        law.validate();
        require(is_addable(plant_, effect), law.name, "must be predicted as a whole in this plant, added", 1);
      });
    if (is_serial(effects) || is_serial(plant_.effects)) threads = 1;
    std::vector<double> innovation(effects.size() * rows());
    std::vector<std::size_t> forces, loads;
    for (std::size_t i = 0; i < effects.size(); ++i)
      std::visit([&]<class E>(const E&) { (HasCoupling<E> ? loads : forces).push_back(i); }, effects[i]);
    if (!forces.empty()) add_forces(effects, sizes, forces, threads, stop, innovation);
    if (!loads.empty()) add_loads(effects, sizes, loads, threads, stop, innovation);
    return innovation;
  }

 private:
  AddedForce law(StopRequest* stop) const {
    const std::lock_guard lock(mutex_);
    if (!law_) law_.emplace(plant_, log_, along_.middle_position, along_.middle_velocity, stop);
    return law_->heeding(stop);
  }

  const std::vector<double>& force(StopRequest* stop) const {
    const std::lock_guard lock(mutex_);
    if (force_.empty()) force_ = net_force(plant_, log_, along_.middle_position, along_.middle_velocity, stop);
    return force_;
  }

  void add_forces(const std::vector<Effect<double>>& effects, const std::vector<double>& sizes,
                  const std::vector<std::size_t>& forces, unsigned threads, StopRequest* stop,
                  std::vector<double>& innovation) const {
    const AddedForce law = this->law(stop);
    const ObserverLoop loop = loop_.heeding(stop);
    const std::size_t rows = loop.rows();
    const auto pass = [&]<std::size_t width>(std::integral_constant<std::size_t, width>, std::size_t first) {
      std::vector<double> force(width * rows, 0.0), excess(width * rows, 0.0);
      std::array<double*, width> out;
      for (std::size_t i = 0; i < width; ++i) {
        const std::size_t effect = forces[first + i];
        law.add(effects[effect], sizes[effect], {force.data() + i * rows, rows}, {excess.data() + i * rows, rows});
        out[i] = innovation.data() + effect * rows;
      }
      const double *force_of = force.data(), *excess_of = excess.data();
      const bool steady = std::all_of(excess.begin(), excess.end(), [](double one) { return one == 0.0; });
      loop.pass<width>(plant_.axis.mass, rows_from<width>(force_of, 0, rows),
                       rows_from<width, const double*>(steady ? nullptr : excess_of, 0, rows), {}, out);
    };
    in_blocks(
        forces.size(), threads, stop,
        [&](std::size_t first) { pass(std::integral_constant<std::size_t, abreast>(), first); },
        [&](std::size_t one) { pass(std::integral_constant<std::size_t, 1>(), one); });
  }

  /// Effects that are loads behind a coupling, each by its own course.
  void add_loads(const std::vector<Effect<double>>& effects, const std::vector<double>& sizes,
                 const std::vector<std::size_t>& loads, unsigned threads, StopRequest* stop,
                 std::vector<double>& innovation) const {
    const std::vector<double>& net = force(stop);
    const ObserverLoop loop = loop_.heeding(stop);
    std::vector<CouplingParameters> couplings(effects.size());
    std::vector<std::size_t> springs, loose;
    for (const std::size_t effect : loads) {
      visit_law(effects[effect], [&](const HasCoupling auto& law) { couplings[effect] = law.coupling(); });
      if (!couplings[effect].rigid()) (has_play(couplings[effect]) ? loose : springs).push_back(effect);
    }
    const auto pass = [&]<std::size_t width>(std::integral_constant<std::size_t, width>, std::size_t first) {
      std::array<CouplingParameters, width> some;
      std::array<double*, width> out;
      for (std::size_t i = 0; i < width; ++i) {
        some[i] = couplings[springs[first + i]];
        out[i] = innovation.data() + springs[first + i] * rows();
      }
      pass_springs(some, plant_.axis, loop, along_.slope_velocity, net, out);
    };
    in_blocks(
        springs.size(), threads, stop,
        [&](std::size_t first) { pass(std::integral_constant<std::size_t, abreast>(), first); },
        [&](std::size_t one) { pass(std::integral_constant<std::size_t, 1>(), one); });
    run_batch(loose.size(), threads, stop, [&](std::size_t job) {
      double* out = innovation.data() + loose[job] * rows();
      pass_loose(couplings[loose[job]], plant_.axis, loop, along_.slope_velocity, net, out);
    });
    for (const std::size_t effect : loads)
      for (std::size_t k = 0; k < rows(); ++k) innovation[effect * rows() + k] /= sizes[effect];
  }

  Plant<double> plant_;
  const Prediction& along_;
  Recording log_;
  ObserverLoop loop_;
  mutable std::mutex mutex_;
  mutable std::optional<AddedForce> law_;
  mutable std::vector<double> force_;  // V, net
};

}  // namespace cogging
