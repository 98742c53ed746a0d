// Net forces of a pack of plants, compiled once for each instruction set (this_set.hpp).

#include <algorithm>
#include <array>
#include <vector>

#include "cogging/simulation/packing.hpp"
#include "this_set.hpp"

using namespace cogging;

namespace {

// One for each plant, or one for all where no effect changes what the amplifier puts out.
std::vector<RecordedAmplifier> amplifiers_of(const PackOfForces& pack) {
  bool alike = true;
  for_each_law(pack.plants[0]->effects, [&]<class E>(const E&) {
    if constexpr (HasShapeCommand<E, double> || HasCommandDelay<E> || HasLag<E>) alike = false;
  });
  std::vector<RecordedAmplifier> amplifiers;
  for (const Plant<>* plant : pack.plants.first(alike ? 1 : pack.plants.size()))
    amplifiers.emplace_back(plant->effects, pack.log.time, pack.log.command);
  return amplifiers;
}

}  // namespace

void COGGING_NAMED(force_lanes_, COGGING_SET)(const PackOfForces& pack) {
  std::array<const Plant<>*, count> plants{};
  for (std::size_t i = 0; i < count; ++i) plants[i] = pack.plants[std::min(i, pack.plants.size() - 1)];
  const Plant<Scalar> together = packed_plant<count>(plants);
  const Axis<Scalar> axis(together.axis, together.cogging, together.effects);
  std::vector<RecordedAmplifier> amplifiers = amplifiers_of(pack);
  const std::size_t rows = pack.log.time.size();
  StopCheck stop(pack.stop);
  for (std::size_t k = 0; k + 1 < rows; ++k) {
    stop.row();
    const double start = pack.log.time[k], end = pack.log.time[k + 1];
    Scalar command = amplifiers[0].mean(start, end);
    for (std::size_t i = 1; i < amplifiers.size(); ++i) set_lane(command, i, amplifiers[i].mean(start, end));
    const Scalar force = together.axis.mass * axis.acceleration(pack.middle_position[k], pack.middle_velocity[k],
                                                                command, 0.5 * (start + end));
    for (std::size_t i = 0; i < pack.rows.size(); ++i) pack.rows[i][k] = lane(force, i);
  }
  for (double* row : pack.rows) row[rows - 1] = row[rows - 2];
}
