// Many runs, of each of which indexes and what else was asked for are kept.

#include <map>

#include "../bindings.hpp"
#include "../controller_state.hpp"
#include "../gil.hpp"
#include "../own_controller.hpp"
#include "cogging/memory.hpp"
#include "cogging/simulation/batch.hpp"
#include "cogging/simulation/reference_rows.hpp"
#include "instantiated.hpp"
#include "lanes.hpp"

using namespace cogging;

namespace {

constexpr std::size_t index_count = std::tuple_size_v<decltype(Performance::fields())>;
using Failure = std::tuple<std::size_t, double, std::string>;  // run, time (s), reason
using AskedReduction = std::tuple<std::string, std::string, double>;

// The course of a run; none where it must run alone: a controller with a past, or one of the user's own.
std::optional<SharedCourse> course_of_run(const Plant<>& plant, const GivenController& given) {
  std::optional<SharedCourse> course;
  detail::at_place(given, [&]<std::size_t place>() {
    if constexpr (place < std::variant_size_v<AnyController<>>) {
      const auto& controller = std::get<place>(given);
      using C = std::variant_alternative_t<place, AnyController<>>;
      if (numbers_of(controller) == numbers_of(C(controller.parameters())))
        course = course_of<place>(plant, controller);
    }
  });
  return course;
}

// What all runs of a batch have in common, and where each puts what it leaves behind.
struct RecordedBatch {
  const std::vector<Plant<>>& plants;
  const std::vector<GivenController>& controllers;
  const std::vector<const Reference*>& references;
  const std::vector<RunOptions>& options;  // of each run, but for what all have in common:
  const std::vector<double>& added_command;
  RecordRequest request;
  bool keeps_refused = false;
  SharedRows rows{};
  std::vector<double> values{};  // (runs, indexes and reductions)
  std::vector<std::vector<std::vector<double>>> columns{};
  std::vector<std::string> reasons{};  // empty: the run came to its end
  std::vector<double> times{};
  std::vector<char> in_lanes{};

  std::size_t width() const { return index_count + request.reductions.size(); }

  void make_room() {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    values.assign(plants.size() * width(), none);
    times.assign(plants.size(), none);
    reasons.resize(plants.size());
    in_lanes.assign(plants.size(), 0);
    columns.resize(request.columns.empty() ? 0 : plants.size());
  }

  /// How many rows run i keeps of each column; none where it cannot begin, which it says itself.
  double rows_kept(std::size_t i) const {
    const double rate = std::visit([](const auto& c) { return c.sample_rate(); }, controllers[i]);
    try {
      return std::ceil(static_cast<double>(ReferenceRows::count(*references[i], options[i].duration, rate)) /
                       static_cast<double>(request.every));
    } catch (const std::invalid_argument&) {
      return 0.0;
    }
  }

  /// Refuses rows that do not fit into memory, of these runs and as many more like them as make `runs_in_all`.
  void require_room(std::size_t runs_in_all) const {
    if (plants.empty()) return;
    const auto runs = static_cast<double>(plants.size()), all = std::max(runs, static_cast<double>(runs_in_all));
    const auto kept = static_cast<double>(request.columns.size());
    double in_all = 0.0;  // rows
    for (std::size_t i = 0; kept > 0.0 && i < plants.size(); ++i) in_all += rows_kept(i);
    const double bytes = 8.0 * all / runs * (in_all * kept + runs * static_cast<double>(width()));
    if (bytes <= memory_unasked) return;
    require_memory(
        "duration", bytes,
        format(all) + " runs of " + format(std::floor(in_all / runs)) + " rows of " + format(kept) + " columns",
        format(ReferenceRows::length(*references[0], options[0].duration)));
  }

  RunOptions options_of(std::size_t i, StopRequest* stop) const {
    RunOptions one = options[i];
    one.added_command = added_command;
    one.stop = stop;
    detail::require_options(one);
    return one;
  }

  void keep(std::size_t i, KeptOfRun&& kept) {
    double* row = values.data() + i * width();
    for_each_field<Performance>([&](const auto& field) { *row++ = kept.performance.*(field.member); });
    for (double reduction : kept.reductions) *row++ = reduction;
    if (!columns.empty()) columns[i] = std::move(kept.columns);
  }

  /// What ended run i stands in its row, unless it ends the batch.
  template <class Run>
  void guard(std::size_t i, const Run& run) {
    const auto failed = [&](const std::exception& error, double time) {
      reasons[i] = error.what();
      times[i] = time;
    };
    try {
      run();
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

  void run_alone(std::size_t i, StopRequest* stop) {
    guard(i, [&] {
      close_with(controllers[i], stop, [&](const auto& controller, StopRequest* turns) {
        const RunOptions own = options_of(i, turns);
        RunRecord<double> record(request);
        const auto motion = rows.of(*references[i], own.duration, controller.sample_rate(), turns);
        closed_loop_into<double>(record, plants[i], controller, *motion, own);
        keep(i, record.take_lane(0));
      });
    });
  }

  /// Those of the machine and its controller, and that the motion is the same.
  std::optional<SharedCourse> course_of(std::size_t i) const {
    std::optional<SharedCourse> course = course_of_run(plants[i], controllers[i]);
    if (!course) return course;
    course->add(reinterpret_cast<std::uintptr_t>(references[i]));
    course->add(options[i].duration), course->add(options[i].steps_per_sample);
    return course;
  }

  /// Runs a pack; false where it cannot be set up: each of its runs alone then says why.
  bool run_pack(const std::vector<std::size_t>& job, const InstructionSet& set, StopRequest* stop) {
    std::vector<RunInLane> runs;
    std::vector<AnyController<>> own;
    std::vector<const AnyController<>*> own_places;
    std::vector<KeptOfRun> kept(job.size());
    for (const std::size_t i : job) {
      runs.push_back({&plants[i], options[i].seed, options[i].initial_position});
      std::visit(
          [&]<class C>(const C& c) {
            if constexpr (std::is_constructible_v<AnyController<>, const C&>) own.emplace_back(c);
          },
          controllers[i]);
    }
    for (const auto& controller : own) own_places.push_back(&controller);
    try {
      const RunOptions of_all = options_of(job[0], stop);
      const double rate = std::visit([](const auto& c) { return c.sample_rate(); }, own[0]);
      const auto motion = rows.of(*references[job[0]], of_all.duration, rate, stop);
      set.run({runs, own_places, kept, request, *motion, of_all});
    } catch (const std::invalid_argument&) {
      return false;
    }
    for (std::size_t place = 0; place < job.size(); ++place)
      guard(job[place], [&] {
        in_lanes[job[place]] = 1;
        if (runs[place].ended) std::rethrow_exception(runs[place].ended);
        keep(job[place], std::move(kept[place]));
      });
    return true;
  }

  void run(unsigned threads, StopRequest* stop) {
    std::optional<InstructionSet> set = instruction_set();
    if (plants.size() < fewest_in_pack) set.reset();
    const Jobs jobs = jobs_of(plants.size(), set, threads_of(threads), [&](std::size_t i) { return course_of(i); });
    run_batch(jobs.size(), threads, stop, [&](std::size_t number) {
      const std::vector<std::size_t>& job = jobs[number];
      if (job.size() > 1 && run_pack(job, *set, stop)) return;
      for (const std::size_t i : job) run_alone(i, stop);
    });
  }
};

// One entry for each run, of a list of one for each or, if that will do, of one for all.
template <class T>
std::vector<T> for_each_run(const char* name, std::vector<T> list, std::size_t runs, bool one_will_do = true) {
  require(list.size() == runs || (one_will_do && list.size() == 1), name,
          one_will_do ? "must be one for all runs or one for each plant" : "must be one for each plant", list.size());
  const T first = list.empty() ? T{} : list[0];
  list.resize(runs, first);
  return list;
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
  kept["in_lanes"] = std::vector<bool>(batch.in_lanes.begin(), batch.in_lanes.end());
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
         const std::vector<std::string>& columns, std::size_t every, bool keeps_refused,
         const std::vector<double>& initial_positions, double initial_velocity,
         const std::vector<double>& added_command, std::size_t runs_in_all) {
        const std::size_t runs = plants.size();
        std::vector<GivenController> given;
        for (const py::object& controller : for_each_run("controllers", controllers, runs, false))
          given.push_back(take_controller(controller));
        const auto motions = for_each_run("references", references, runs);
        for (const Reference* motion : motions)
          if (motion == nullptr) throw py::type_error("references: must be motions, got None");
        const auto times = for_each_run("durations", durations, runs);
        const auto steps = for_each_run("steps_per_sample", steps_per_sample, runs);
        const auto draws = seeds.empty() ? std::vector<std::uint64_t>(runs) : for_each_run("seeds", seeds, runs, false);
        std::vector<std::optional<double>> starts(initial_positions.begin(), initial_positions.end());
        starts =
            starts.empty() ? std::vector<std::optional<double>>(runs) : for_each_run("initial_positions", starts, runs);
        for (const double position : initial_positions) require_finite("initial_positions", position);
        std::vector<RunOptions> options;
        for (std::size_t i = 0; i < runs; ++i)
          options.push_back({times[i], draws[i], steps[i], false, starts[i], initial_velocity, {}, nullptr});
        for (const double added : added_command) require_finite("added_command", added);
        // Where a plant asks Python, it holds a lock for which other threads would only wait.
        for (const Plant<>& plant : plants)
          if (is_serial(plant.effects)) threads = 1;
        RecordRequest request{{start, stop, final_window}, {}, columns, every};
        for (const auto& [quantity, kind, at] : reductions) request.reductions.push_back({quantity, kind, at});
        const RunRecord<double> refuses_what_is_wrong(request);
        RecordedBatch batch{plants, given, motions, options, added_command, request, keeps_refused};
        batch.require_room(runs_in_all);
        batch.make_room();
        without_gil([&](StopRequest* request_to_stop) { batch.run(threads, request_to_stop); });
        return kept_of(std::move(batch));
      },
      py::arg("plants"), py::arg("controllers"), py::arg("references"), py::kw_only(), py::arg("durations"),
      py::arg("seeds"), py::arg("steps_per_sample"), py::arg("threads"), py::arg("start"), py::arg("stop"),
      py::arg("final_window"), py::arg("reductions"), py::arg("columns"), py::arg("every"), py::arg("keeps_refused"),
      py::arg("initial_positions") = std::vector<double>{}, py::arg("initial_velocity") = 0.0,
      py::arg("added_command") = std::vector<double>{}, py::arg("runs_in_all") = 0,
      R"(Many runs on `threads` threads (0 = all cores) without their rows: what cogging.closed_loop_batch keeps.

`values` (runs, 6 + reductions): the fields of Performance in order, then the reductions (quantity, kind, at); NaN where a
run failed. `failures`: run, time (s), reason. `columns`: one list for each, an array a run, every so many rows.
There must be room in memory for as much of `runs_in_all` runs.)");

  module.def(
      "instruction_sets",
      [] {
        std::map<std::string, std::size_t> sets;
        for (const InstructionSet& set : instruction_sets()) sets[std::string(set.name)] = set.lanes;
        return sets;
      },
      "Instruction sets of this machine for which runs in packs were compiled, and how many runs a pack holds.");
  module.def(
      "instruction_set", [] { return instruction_set().value_or(InstructionSet{1, nullptr, nullptr, "none"}).name; },
      R"(The instruction set that closed_loop_batch uses: the widest of instruction_sets, or what the environment variable
COGGING_INSTRUCTIONS names; "none": each run alone.

Raises:
    ValueError: COGGING_INSTRUCTIONS names one that this machine lacks.)");
}
