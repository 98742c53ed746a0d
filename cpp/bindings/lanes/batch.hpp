#pragma once
// A batch of runs: in packs where they share a course, alone where they do not.

#include <algorithm>
#include <cstddef>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../controller_state.hpp"
#include "../own_controller.hpp"
#include "cogging/simulation/batch.hpp"
#include "run_lanes.hpp"

/// What a batch runs: plant i under controller i, with the noise of seed i.
struct BatchOfRuns {
  const std::vector<cogging::Plant<>>& plants;
  const std::vector<GivenController>& controllers;
  const std::vector<std::uint64_t>& seeds;  // empty: 0 for all
  const cogging::Reference& reference;
  const cogging::RunOptions& options;  // of all; the seed apart

  std::uint64_t seed(std::size_t i) const { return seeds.empty() ? 0 : seeds[i]; }
};

/// The course of run i; none where it must run alone: a controller with a past, or one of the user's own.
inline std::optional<cogging::SharedCourse> course_of_run(const BatchOfRuns& batch, std::size_t i) {
  std::optional<cogging::SharedCourse> course;
  cogging::detail::at_place(batch.controllers[i], [&]<std::size_t place>() {
    if constexpr (place < std::variant_size_v<cogging::AnyController<>>) {
      const auto& controller = std::get<place>(batch.controllers[i]);
      using C = std::variant_alternative_t<place, cogging::AnyController<>>;
      if (numbers_of(controller) == numbers_of(C(controller.parameters())))
        course = cogging::course_of<place>(batch.plants[i], controller);
    }
  });
  return course;
}

/// The runs by their jobs: packs of at most `lanes` of one course, and single ones, in the order of their first runs.
inline std::vector<std::vector<std::size_t>> jobs_of(const BatchOfRuns& batch, std::size_t lanes) {
  std::vector<std::vector<std::size_t>> jobs;
  std::unordered_map<std::string, std::size_t> open;  // the job to which the next run of a course belongs
  for (std::size_t i = 0; i < batch.plants.size(); ++i) {
    const std::optional<cogging::SharedCourse> course = lanes > 1 ? course_of_run(batch, i) : std::nullopt;
    if (course) {
      const auto [place, is_new] = open.try_emplace(course->text(), jobs.size());
      if (!is_new && jobs[place->second].size() < lanes) {
        jobs[place->second].push_back(i);
        continue;
      }
      place->second = jobs.size();
    }
    jobs.push_back({i});
  }
  return jobs;
}

/// The rows of the reference at each rate of a batch; without those that cannot be made: a run alone says why.
class RowsByRate {
 public:
  RowsByRate(const BatchOfRuns& batch, cogging::StopRequest* request) {
    cogging::StopCheck stop(request);
    for (const GivenController& given : batch.controllers) {
      const double rate = std::visit([](const auto& c) { return c.sample_rate(); }, given);
      if (rows_.count(rate)) continue;
      auto& made = rows_[rate];
      try {
        made = std::make_unique<cogging::ReferenceRows>(batch.reference, batch.options.duration, rate, stop);
      } catch (const std::invalid_argument&) {
      }
    }
  }

  const cogging::ReferenceRows* of(const GivenController& given) const {
    return rows_.at(std::visit([](const auto& c) { return c.sample_rate(); }, given)).get();
  }

 private:
  std::map<double, std::unique_ptr<cogging::ReferenceRows>> rows_;
};

/// Runs a pack; false where it cannot be set up: each of its runs alone then says why.
inline bool run_pack(const BatchOfRuns& batch, const std::vector<std::size_t>& job, const InstructionSet& set,
                     const cogging::ReferenceRows& rows, cogging::StopRequest* stop, std::vector<cogging::Log<>>& logs,
                     std::vector<std::exception_ptr>& ended) {
  std::vector<cogging::RunInLane> runs;
  std::vector<cogging::AnyController<>> controllers;
  std::vector<const cogging::AnyController<>*> controllers_of;
  std::vector<cogging::Log<>*> logs_of;
  for (const std::size_t i : job) {
    runs.push_back({&batch.plants[i], batch.seed(i)});
    logs_of.push_back(&logs[i]);
    std::visit(
        [&]<class C>(const C& c) {
          if constexpr (std::is_constructible_v<cogging::AnyController<>, const C&>) controllers.emplace_back(c);
        },
        batch.controllers[i]);
  }
  for (const auto& controller : controllers) controllers_of.push_back(&controller);
  cogging::RunOptions options = batch.options;
  options.stop = stop;
  try {
    set.run({runs, controllers_of, logs_of, rows, options});
  } catch (const cogging::Interrupted&) {
    throw;
  } catch (const std::invalid_argument&) {
    return false;
  }
  for (std::size_t place = 0; place < job.size(); ++place) ended[job[place]] = runs[place].ended;
  return true;
}

/// Logs of all runs, and of each whether it ran in a pack. run_alone(i) gives the log of a run by itself.
///
/// Throws what ended the run with the lowest number of those that did not come to their end.
template <class RunAlone>
std::pair<std::vector<cogging::Log<>>, std::vector<bool>> run_in_packs(const BatchOfRuns& batch, unsigned threads,
                                                                       cogging::StopRequest* stop,
                                                                       const RunAlone& run_alone) {
  const std::optional<InstructionSet> set = instruction_set();
  const std::vector<std::vector<std::size_t>> jobs = jobs_of(batch, set ? set->lanes : 1);
  const RowsByRate rows(batch, stop);
  std::vector<cogging::Log<>> logs(batch.plants.size());
  std::vector<std::exception_ptr> ended(batch.plants.size());
  std::vector<char> packed(batch.plants.size(), 0);
  cogging::run_batch(jobs.size(), threads, stop, [&](std::size_t number) {
    const std::vector<std::size_t>& job = jobs[number];
    const cogging::ReferenceRows* motion = rows.of(batch.controllers[job[0]]);
    if (job.size() > 1 && motion != nullptr && run_pack(batch, job, *set, *motion, stop, logs, ended)) {
      for (const std::size_t i : job) packed[i] = 1;
      return;
    }
    for (const std::size_t i : job) try {
        logs[i] = run_alone(i);
      } catch (const cogging::Interrupted&) {
        throw;
      } catch (...) {
        ended[i] = std::current_exception();
      }
  });
  for (const std::exception_ptr& reason : ended)
    if (reason) std::rethrow_exception(reason);
  return {std::move(logs), std::vector<bool>(packed.begin(), packed.end())};
}
