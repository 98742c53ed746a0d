// Packs of runs, compiled once for each instruction set (this_set.hpp).

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "this_set.hpp"

using namespace cogging;

namespace {

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

void COGGING_NAMED(run_lanes_, COGGING_SET)(const PackOfRuns& pack) {
  detail::at_place(*pack.controllers[0], [&]<std::size_t place>() { run_under<place>(pack); });
}
