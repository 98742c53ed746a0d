// Compiled once for each instruction set, with COGGING_SET its name and COGGING_LANES the size of a pack. No inline
// function of it has a name outside of this object (-fno-weak): another may run on a machine that lacks its
// instructions.

#include "run_lanes.hpp"

#include <array>
#include <utility>
#include <variant>

using namespace cogging;

namespace {

constexpr std::size_t count = COGGING_LANES;
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

}  // namespace

#define COGGING_JOINED(a, b) a##b
#define COGGING_NAMED(a, b) COGGING_JOINED(a, b)

void COGGING_NAMED(run_lanes_, COGGING_SET)(const PackOfRuns& pack) {
  detail::at_place(*pack.controllers[0], [&]<std::size_t place>() { run_under<place>(pack); });
}
