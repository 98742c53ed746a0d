// Many runs, of each of which indexes and what else was asked for are kept.

#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "cogging/simulation/batch.hpp"
#include "cogging/simulation/closed_loop.hpp"
#include "cogging/simulation/run_record.hpp"
#include "cogging/simulation/shared_rows.hpp"
#include "own_controller.hpp"
#include "without_gil.hpp"

using namespace cogging;

namespace {

constexpr std::size_t index_count = 6;
using Failure = std::tuple<std::size_t, double, std::string>;  // run, time (s), reason
using AskedReduction = std::tuple<std::string, std::string, double>;

// What all runs of a batch have in common, and where each puts what it leaves behind.
struct RecordedBatch {
  const std::vector<Plant<>>& plants;
  const std::vector<GivenController>& controllers;
  const std::vector<const Reference*>& references;  // one a run, or one for all
  const std::vector<double>& durations;
  const std::vector<std::uint64_t>& seeds;
  const std::vector<int>& steps;
  RecordRequest request;
  bool keeps_refused;
  SharedRows rows;
  std::vector<double> values;  // (runs, indexes and reductions)
  std::vector<std::vector<std::vector<double>>> columns;
  std::vector<std::string> reasons;  // empty: the run came to its end
  std::vector<double> times;

  std::size_t width() const { return index_count + request.reductions.size(); }

  void make_room() {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    values.assign(plants.size() * width(), none);
    times.assign(plants.size(), none);
    reasons.resize(plants.size());
    columns.resize(request.columns.empty() ? 0 : plants.size());
  }

  template <class T>
  static const T& one_of(const std::vector<T>& list, std::size_t i) {
    return list[list.size() == 1 ? 0 : i];
  }

  template <class C>
  void run_with(const C& controller, std::size_t i, StopRequest* stop) {
    RunOptions options;
    options.seed = seeds.empty() ? 0 : seeds[i];
    options.steps_per_sample = one_of(steps, i);
    options.duration = one_of(durations, i);
    options.stop = stop;
    detail::require_options(options);
    RunRecord<double> record(request);
    const auto motion = rows.of(*one_of(references, i), options.duration, controller.sample_rate(), stop);
    closed_loop_into<double>(record, plants[i], controller, *motion, options);
    const Performance found = record.performance_of_lane(0);
    double* row = values.data() + i * width();
    for (double index : {found.error_max, found.error_rms, found.error_final_max, found.command_rms,
                         found.command_change_rms, found.command_chatter})
      *row++ = index;
    for (double reduction : record.reductions_of_lane(0)) *row++ = reduction;
    if (!columns.empty()) columns[i] = record.columns_of_lane(0);
  }

  void run(std::size_t i, StopRequest* stop) {
    const auto failed = [&](const std::exception& error, double time) {
      reasons[i] = error.what();
      times[i] = time;
    };
    try {
      close_with(controllers[i], stop, [&](const auto& c, StopRequest* turns) { run_with(c, i, turns); });
    } catch (const DivergedError& error) {
      failed(error, error.time);
    } catch (const ControllerError& error) {
      if (!keeps_refused) throw;
      failed(error, error.time);
    } catch (const std::invalid_argument& error) {
      if (!keeps_refused) throw std::invalid_argument("run " + std::to_string(i) + ": " + error.what());
      failed(error, std::numeric_limits<double>::quiet_NaN());
    }
  }
};

template <class T>
void require_one_for_each(const char* name, const std::vector<T>& list, std::size_t runs, bool one_will_do) {
  require(list.size() == runs || (one_will_do && list.size() == 1), name,
          one_will_do ? "must be one for all runs or one for each plant" : "must be one for each plant",
          static_cast<double>(list.size()));
}

py::dict kept_of(RecordedBatch&& batch) {
  const auto runs = static_cast<py::ssize_t>(batch.plants.size()), width = static_cast<py::ssize_t>(batch.width());
  std::vector<Failure> failures;
  for (std::size_t i = 0; i < batch.reasons.size(); ++i)
    if (!batch.reasons[i].empty()) failures.emplace_back(i, batch.times[i], std::move(batch.reasons[i]));
  py::list columns;
  for (std::size_t c = 0; c < batch.request.columns.size(); ++c) {
    py::list each;
    for (auto& run : batch.columns) each.append(to_array(run.empty() ? std::vector<double>{} : std::move(run[c])));
    columns.append(each);
  }
  py::dict kept;
  kept["values"] = to_array(std::move(batch.values), {runs, width});
  kept["failures"] = failures;
  kept["columns"] = columns;
  return kept;
}

}  // namespace

void bind_batch(py::module_& module) {
  module.def(
      "closed_loop_records",
      [](const std::vector<Plant<>>& plants, const std::vector<py::object>& controllers,
         const std::vector<const Reference*>& references, const std::vector<double>& durations,
         const std::vector<std::uint64_t>& seeds, const std::vector<int>& steps_per_sample, unsigned threads,
         double start, double stop, double final_window, const std::vector<AskedReduction>& reductions,
         const std::vector<std::string>& columns, std::size_t every, bool keeps_refused) {
        require_one_for_each("controllers", controllers, plants.size(), false);
        require_one_for_each("references", references, plants.size(), true);
        require_one_for_each("durations", durations, plants.size(), true);
        require_one_for_each("steps_per_sample", steps_per_sample, plants.size(), true);
        if (!seeds.empty()) require_one_for_each("seeds", seeds, plants.size(), false);
        // Where a plant asks Python, it holds a lock for which other threads would only wait.
        for (const Plant<>& plant : plants)
          if (is_serial(plant.effects)) threads = 1;
        std::vector<GivenController> given;
        for (const py::object& controller : controllers) given.push_back(take_controller(controller));
        for (const Reference* reference : references)
          if (reference == nullptr) throw py::type_error("references: must be motions, got None");
        RecordRequest request{{start, stop, final_window}, {}, columns, every};
        for (const auto& [quantity, kind, at] : reductions) request.reductions.push_back({quantity, kind, at});
        const RunRecord<double> refuses_what_is_wrong(request);
        RecordedBatch batch{plants, given, references, durations, seeds, steps_per_sample, request, keeps_refused,
                            {},     {},    {},         {},        {}};
        batch.make_room();
        without_gil([&](StopRequest* request_to_stop) {
          run_batch(plants.size(), threads, request_to_stop, [&](std::size_t i) { batch.run(i, request_to_stop); });
        });
        return kept_of(std::move(batch));
      },
      py::arg("plants"), py::arg("controllers"), py::arg("references"), py::kw_only(), py::arg("durations"),
      py::arg("seeds"), py::arg("steps_per_sample"), py::arg("threads"), py::arg("start"), py::arg("stop"),
      py::arg("final_window"), py::arg("reductions"), py::arg("columns"), py::arg("every"), py::arg("keeps_refused"),
      R"(Many runs on `threads` threads (0 = all cores) without their rows: what cogging.closed_loop_batch keeps.

`values` (runs, 6 + reductions): the fields of Performance in order, then the reductions (quantity, kind, at); NaN where a
run failed. `failures`: run, time (s), reason. `columns`: one list for each, an array a run, every so many rows.)");
}
