#pragma once
// What a plant is expected to do along a log, where one trajectory of it would not be what is expected.
//
// When a load with play strikes hangs on all that has pushed it since the last time, by forces that no model has.
// Single strikes cannot be foreseen; what they do on average can. The mean is taken over gaps around the one that is
// meant.

#include <algorithm>
#include <cstddef>
#include <variant>
#include <vector>

#include "cogging/estimation/added_effect.hpp"
#include "cogging/estimation/prediction.hpp"

namespace cogging {

/// The prediction of a plant, of one with play the mean over play_shares. A load that is light is added to the
/// prediction of the rest; its own motion is then that of the rest, which it hardly changes.
inline Prediction expected_prediction(const Plant<double>& plant, const Recording& log,
                                      const PredictionOptions& options, bool with_slopes) {
  const auto has_play = [](const Effect<double>& effect) {
    bool loose = false;
    visit_law(effect, [&](const HasPlay auto& law) { loose = !law.coupling().rigid(); });
    return loose;
  };
  const auto loose = std::find_if(plant.effects.begin(), plant.effects.end(), has_play);
  if (loose == plant.effects.end()) return predict(plant, log, options, with_slopes);
  const auto place = loose - plant.effects.begin();

  Plant<double> rest = plant;
  rest.effects.erase(rest.effects.begin() + place);
  if (is_addable(rest, *loose)) {
    Prediction result = predict(rest, log, options, true);
    const std::vector<double> added = PlantAlong(rest, result, log, options).added({*loose}, {1.0}, 1, options.stop);
    for (std::size_t k = 0; k < added.size(); ++k) result.innovation[k] += added[k];
    return result;
  }
  Prediction result;
  for (const double share : play_shares) {
    Plant<double> other = plant;
    visit_law(other.effects[static_cast<std::size_t>(place)], [share](HasPlay auto& law) { law.gap *= share; });
    const bool first = result.innovation.empty();
    Prediction one = predict(other, log, options, with_slopes && first);
    if (first) {
      result = std::move(one);
      continue;
    }
    for (auto column : {&Prediction::innovation, &Prediction::position, &Prediction::velocity})
      for (std::size_t k = 0; k < log.time.size(); ++k) (result.*column)[k] += (one.*column)[k];
  }
  for (auto column : {&Prediction::innovation, &Prediction::position, &Prediction::velocity})
    for (double& value : result.*column) value /= static_cast<double>(play_shares.size());
  return result;
}

}  // namespace cogging
