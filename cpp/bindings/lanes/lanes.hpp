#pragma once
// What packs of runs and of forces are given, and which runs share one.

#include <unordered_map>

#include "cogging/control/list.hpp"
#include "cogging/estimation/prediction.hpp"
#include "cogging/simulation/lanes_loop.hpp"
#include "cogging/simulation/packing.hpp"
#include "cogging/simulation/reference_rows.hpp"
#include "cogging/simulation/run_record.hpp"
#include "instruction_sets.hpp"

/// Runs of one course (see SharedCourse), as many as an instruction set has lanes or fewer, and what is left of each.
struct PackOfRuns {
  std::span<cogging::RunInLane> runs;
  std::span<const cogging::AnyController<>* const> controllers;
  std::span<cogging::KeptOfRun> kept;
  const cogging::RecordRequest& request;
  const cogging::ReferenceRows& reference;
  const cogging::RunOptions& options;
};

/// Plants of one course (see course_of_forces), as many or fewer, and where the net force of each along one motion
/// goes.
struct PackOfForces {
  std::span<const cogging::Plant<>* const> plants;
  std::span<double* const> rows;
  const cogging::Recording& log;
  std::span<const double> middle_position, middle_velocity;  // m, m/s
  cogging::StopRequest* stop = nullptr;
};

/// The runs of a batch as jobs: packs of those that share a course, and single runs.
using Jobs = std::vector<std::vector<std::size_t>>;

/// Packs with fewer runs take as long as these one after the other: 1.2 to 1.9 runs' time, as measured.
inline constexpr std::size_t fewest_in_pack = 2;

/// Whether runs of one course on so many threads end sooner in packs than one after the other.
inline bool packs_pay(std::size_t runs, const InstructionSet& set, std::size_t threads) {
  const auto rounds = [&](std::size_t jobs) { return (jobs + threads - 1) / threads; };
  return runs >= fewest_in_pack && rounds((runs + set.lanes - 1) / set.lanes) * fewest_in_pack <= rounds(runs);
}

/// Packs of at most as many runs as the set has lanes, each of one course, and single runs, in the order of their first
/// runs. course(i) is that of run i, or none.
template <class CourseOf>
Jobs jobs_of(std::size_t runs, const std::optional<InstructionSet>& set, std::size_t threads,
             const CourseOf& course_of) {
  if (!set) {
    Jobs jobs(runs);
    for (std::size_t i = 0; i < runs; ++i) jobs[i] = {i};
    return jobs;
  }
  Jobs courses;  // the runs of each, those that run alone by themselves
  std::unordered_map<std::string, std::size_t> known;
  for (std::size_t i = 0; i < runs; ++i) {
    const std::optional<cogging::SharedCourse> course = course_of(i);
    const std::size_t place = course ? known.try_emplace(course->text(), courses.size()).first->second : courses.size();
    if (place == courses.size()) courses.emplace_back();
    courses[place].push_back(i);
  }
  Jobs jobs;
  for (const std::vector<std::size_t>& of_course : courses) {
    const std::size_t packed = packs_pay(of_course.size(), *set, threads) ? of_course.size() : 0;
    for (auto first = of_course.begin(); first != of_course.end();) {
      const auto left = static_cast<std::size_t>(of_course.end() - first);
      const std::size_t many = packed == 0 || left < fewest_in_pack ? 1 : std::min(left, set->lanes);
      jobs.emplace_back(first, first + static_cast<std::ptrdiff_t>(many));
      first += static_cast<std::ptrdiff_t>(many);
    }
  }
  std::sort(jobs.begin(), jobs.end());
  return jobs;
}
