// Packs of runs and of forces, compiled once for each instruction set, COGGING_SET. No inline function of it has a name
// outside of its object (-fno-weak): another may run on a machine that lacks its instructions. What is stepped alone
// is stepped by the code of single runs (instantiated.hpp), which every machine can run.

#include "lanes.hpp"

#include <array>
#include <variant>

#include "instantiated.hpp"

using namespace cogging;

namespace {

constexpr std::size_t count = register_width;
using Scalar = Lanes<count>;

template <std::size_t place>
void run_under(const PackOfRuns& pack) {
  using One = std::variant_alternative_t<place, AnyController<>>;
  using Many = std::variant_alternative_t<place, AnyController<Scalar>>;
  std::array<const typename One::Parameters*, count> parameters{};
  for (std::size_t i = 0; i < count; ++i)
    parameters[i] = &std::get<place>(*pack.controllers[std::min(i, pack.controllers.size() - 1)]).parameters();
  RunRecord<Scalar> record(pack.request);
  closed_loop_in_lanes<count>(record, pack.runs, Many(packed<typename Many::Parameters>(parameters)), pack.reference,
                              pack.options);
  for (std::size_t i = 0; i < pack.runs.size(); ++i)
    if (!pack.runs[i].ended) pack.kept[i] = record.take_lane(i);
}

void run(const PackOfRuns& pack) {
  detail::at_place(*pack.controllers[0], [&]<std::size_t place>() { run_under<place>(pack); });
}

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

void net_force(const PackOfForces& pack) {
  std::array<const Plant<>*, count> plants{};
  for (std::size_t i = 0; i < count; ++i) plants[i] = pack.plants[std::min(i, pack.plants.size() - 1)];
  const Plant<Scalar> together = packed_plant<count>(plants);
  write_net_force(together, amplifiers_of(pack), pack.log, pack.middle_position, pack.middle_velocity, pack.rows,
                  pack.stop);
}

}  // namespace

#define COGGING_JOINED(a, b) a##b
#define COGGING_LANES(set) COGGING_JOINED(lanes_, set)
InstructionSet COGGING_LANES(COGGING_SET)() {
  return {count, run, net_force};
}
