#pragma once
// A log held for many predictions along it: innovations of plants, and what small changes add to them.

#include <string_view>
#include <utility>

#include "cogging/estimation/observer_loop.hpp"
#include "cogging/estimation/prediction.hpp"
#include "cogging/simulation/batch.hpp"

namespace cogging {

/// Of the gap that is meant: the mean over them is what a load with play does.
inline constexpr std::array play_shares{1.0, 0.7, 0.85, 1.15, 1.3};

/// The prediction of a plant; of one with play, the mean over play_shares: when a load with play strikes hangs on all
/// that has pushed it since the last time, by forces that no model has, so that single strikes cannot be foreseen.
inline Prediction expected_prediction(const Plant<double>& plant, const Recording& log,
                                      const PredictionOptions& options, bool with_slopes) {
  const auto has_play = [](const Effect<double>& effect) {
    bool loose = false;
    visit_law(effect, [&](const HasPlay auto& law) { loose = !law.coupling().rigid(); });
    return loose;
  };
  const auto loose = std::find_if(plant.effects.begin(), plant.effects.end(), has_play);
  if (loose == plant.effects.end()) return predict(plant, log, options, with_slopes);
  const auto place = static_cast<std::size_t>(loose - plant.effects.begin());
  constexpr std::array averaged{&Prediction::innovation, &Prediction::position, &Prediction::velocity};
  Prediction result;
  for (const double share : play_shares) {
    Plant<double> other = plant;
    visit_law(other.effects[place], [share](HasPlay auto& law) { law.gap *= share; });
    const bool first = result.innovation.empty();
    Prediction one = predict(other, log, options, with_slopes && first);
    if (first) {
      result = std::move(one);
      continue;
    }
    for (auto column : averaged)
      for (std::size_t k = 0; k < log.time.size(); ++k) (result.*column)[k] += (one.*column)[k];
  }
  for (auto column : averaged)
    for (double& value : result.*column) value /= static_cast<double>(play_shares.size());
  return result;
}

/// One step ahead along a log: a plant is driven by the recorded command and held to the recorded position by an
/// observer; the innovation (m) is what the plant did not foresee.
///
/// Tables have one row for each plant or force and one entry a row of the log. Each call may be given a stop
/// request; it then throws Interrupted where that asks for it. `threads` as in run_batch.
class Predictor {
 public:
  /// time (s, strictly increasing), position (m) and command (V) of every row.
  ///
  /// Raises std::invalid_argument for columns of different lengths, time that does not increase, a NaN or an infinity
  /// in one of them, options that are out of range.
  Predictor(std::vector<double> time, std::vector<double> position, std::vector<double> command,
            const PredictionOptions& options = {})
      : time_(std::move(time)), position_(std::move(position)), command_(std::move(command)), options_(options) {
    require(position_.size() == rows(), "position", "must be as long as time", position_.size());
    require(command_.size() == rows(), "command", "must be as long as time", command_.size());
    require(rows() >= 2, "time", "must have at least 2 rows", rows());
    require_positive("bandwidth", options.bandwidth);
    require_positive("gap", options.gap);
    require_finite("initial_velocity", options.initial_velocity);
    require(options.steps_per_sample >= 1 && options.steps_per_sample <= 1000, "steps_per_sample",
            "must be from 1 to 1000", options.steps_per_sample);
    require_finite("time", time_);
    require_finite("position", position_);
    require_finite("command", command_);
    for (std::size_t k = 1; k < rows(); ++k)
      require(time_[k] > time_[k - 1], "time", "must be strictly increasing", time_[k]);
    median_step_ = median_step(time_);
  }

  /// As many threads as plants can use: where one needs a lock, others would only wait for it.
  static unsigned useful(const std::vector<Plant<double>>& plants, unsigned threads) {
    const auto serial = [](const Plant<double>& plant) { return is_serial(plant.effects); };
    return std::any_of(plants.begin(), plants.end(), serial) ? 1 : threads;
  }

  std::size_t rows() const { return time_.size(); }
  Recording log() const { return {time_, position_, command_, median_step_}; }

  /// The prediction along the log, with slopes.
  Prediction predict(const Plant<double>& plant, StopRequest* stop = nullptr) const {
    return expected_prediction(plant, log(), options(stop), true);
  }

  /// Innovations of many plants, m: (plants, rows).
  std::vector<double> innovations(const std::vector<Plant<double>>& plants, unsigned threads,
                                  StopRequest* stop = nullptr) const {
    std::vector<double> values(plants.size() * rows());
    run_batch(plants.size(), useful(plants, threads), stop, [&](std::size_t i) {
      const std::vector<double> made = expected_prediction(plants[i], log(), options(stop), false).innovation;
      std::copy(made.begin(), made.end(), values.begin() + static_cast<std::ptrdiff_t>(i * rows()));
    });
    return values;
  }

  /// What small forces (V, (count, rows)) and errors of the reading (m, the same shape, or empty: none) add to the
  /// innovations along a prediction of this log, m: (count, rows). `mass` in V/(m/s^2).
  std::vector<double> propagate(const Prediction& along, double mass, std::size_t count, std::span<const double> forces,
                                std::span<const double> reading_errors, unsigned threads,
                                StopRequest* stop = nullptr) const {
    require(forces.size() == count * rows(), "forces", "must be (count, rows)", forces.size());
    require(reading_errors.empty() || reading_errors.size() == forces.size(), "reading_errors",
            "must have the shape of forces", reading_errors.size());
    require_positive("mass", mass);
    const double* errors = reading_errors.empty() ? nullptr : reading_errors.data();
    return propagated(along, log(), options(stop), mass, count, forces.data(), errors, threads);
  }

  /// Raises std::invalid_argument for a column that is not as long as the log.
  void require_length(std::string_view name, std::span<const double> column) const {
    require(column.size() == rows(), name, "must be as long as the log", column.size());
  }

 private:
  PredictionOptions options(StopRequest* stop) const {
    PredictionOptions options = options_;
    options.stop = stop;
    return options;
  }

  std::vector<double> time_, position_, command_;
  PredictionOptions options_;
  double median_step_ = 0.0;  // s, found once
};

}  // namespace cogging
