#pragma once
// What a plant is expected to do along a log, where one trajectory of it would not be what is expected.
//
// When a load with play strikes hangs on all that has pushed it since the last time, by forces that no model has.
// Single strikes cannot be foreseen; what they do on average can.

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "cogging/estimation/prediction.hpp"

namespace cogging {

/// Of the gap that is meant: the mean over them is what a load with play does.
inline constexpr std::array play_shares{1.0, 0.7, 0.85, 1.15, 1.3};

/// The prediction of a plant, of one with play the mean over play_shares.
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

}  // namespace cogging
