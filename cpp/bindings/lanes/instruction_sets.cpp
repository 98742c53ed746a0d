#include <cstdlib>
#include <string_view>
#include <utility>

#include "run_lanes.hpp"

// Defined where run_lanes.cpp and force_lanes.cpp are compiled for them; the value is the size of a pack.
#define COGGING_DECLARED(set)              \
  void run_lanes_##set(const PackOfRuns&); \
  void force_lanes_##set(const PackOfForces&);
#ifdef COGGING_LANES_v2
COGGING_DECLARED(v2)
#endif
#ifdef COGGING_LANES_v3
COGGING_DECLARED(v3)
#endif
#ifdef COGGING_LANES_v4
COGGING_DECLARED(v4)
#endif
#ifdef COGGING_LANES_neon
COGGING_DECLARED(neon)
#endif

std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets;
#if defined(COGGING_LANES_v2) || defined(COGGING_LANES_v3) || defined(COGGING_LANES_v4)
  __builtin_cpu_init();
  const bool v2 = __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
  const bool v3 = v2 && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  [[maybe_unused]] const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                                   __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                                   __builtin_cpu_supports("avx512vl");
  const auto add = [&sets](bool is_there, InstructionSet set) {
    if (is_there) sets.push_back(std::move(set));
  };
#endif
#ifdef COGGING_LANES_v2
  add(v2, {"v2", COGGING_LANES_v2, run_lanes_v2, force_lanes_v2});
#endif
#ifdef COGGING_LANES_v3
  add(v3, {"v3", COGGING_LANES_v3, run_lanes_v3, force_lanes_v3});
#endif
#ifdef COGGING_LANES_v4
  add(v4, {"v4", COGGING_LANES_v4, run_lanes_v4, force_lanes_v4});
#endif
#ifdef COGGING_LANES_neon
  sets.push_back({"neon", COGGING_LANES_neon, run_lanes_neon, force_lanes_neon});
#endif
  return sets;
}

std::optional<InstructionSet> instruction_set() {
  const std::vector<InstructionSet> sets = instruction_sets();
  const char* asked = std::getenv("COGGING_INSTRUCTIONS");
  if (asked == nullptr || *asked == '\0') return sets.empty() ? std::nullopt : std::optional(sets.back());
  const std::string_view name = asked;
  if (name == "none") return std::nullopt;
  std::string known;
  for (const InstructionSet& set : sets) {
    if (name == set.name) return set;
    known += std::string(set.name) + ", ";
  }
  cogging::refuse("COGGING_INSTRUCTIONS", "must be one that this machine has: " + known + "or none",
                  "\"" + std::string(name) + "\"");
}
