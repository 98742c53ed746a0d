#pragma once
// The runs of a batch as jobs: packs of those that share a course, and single runs.

#include <cstddef>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "../controller_state.hpp"
#include "../own_controller.hpp"
#include "cogging/simulation/packing.hpp"
#include "run_lanes.hpp"

/// The course of a run; none where it must run alone: a controller with a past, or one of the user's own.
inline std::optional<cogging::SharedCourse> course_of_run(const cogging::Plant<>& plant, const GivenController& given) {
  std::optional<cogging::SharedCourse> course;
  cogging::detail::at_place(given, [&]<std::size_t place>() {
    if constexpr (place < std::variant_size_v<cogging::AnyController<>>) {
      const auto& controller = std::get<place>(given);
      using C = std::variant_alternative_t<place, cogging::AnyController<>>;
      if (numbers_of(controller) == numbers_of(C(controller.parameters())))
        course = cogging::course_of<place>(plant, controller);
    }
  });
  return course;
}

using Jobs = std::vector<std::vector<std::size_t>>;

/// Packs of at most as many runs as the set has lanes, each of one course, and single runs, in the order of their first
/// runs. course(i) is that of run i, or none.
template <class CourseOf>
Jobs jobs_of(std::size_t runs, const std::optional<InstructionSet>& set, const CourseOf& course_of) {
  Jobs packs;
  std::unordered_map<std::string, std::size_t> open;  // the pack to which the next run of a course belongs
  for (std::size_t i = 0; i < runs; ++i) {
    const std::optional<cogging::SharedCourse> course = set ? course_of(i) : std::nullopt;
    if (course) {
      const auto [place, is_new] = open.try_emplace(course->text(), packs.size());
      if (!is_new && packs[place->second].size() < set->lanes) {
        packs[place->second].push_back(i);
        continue;
      }
      place->second = packs.size();
    }
    packs.push_back({i});
  }
  Jobs jobs;
  for (std::vector<std::size_t>& pack : packs) {
    if (set && pack.size() >= set->fewest)
      jobs.push_back(std::move(pack));
    else
      for (const std::size_t i : pack) jobs.push_back({i});
  }
  return jobs;
}
