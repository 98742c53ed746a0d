#include "instruction_sets.hpp"

#include "cogging/require.hpp"

// COGGING_SETS says SET(v3) SET(v4): for each, lanes.cpp was compiled.
#define SET(name) InstructionSet lanes_##name();
COGGING_SETS
#undef SET

// Whether the processor has the instructions; nothing that is compiled for them runs before this says so.
[[maybe_unused]] static bool is_there([[maybe_unused]] std::string_view set) {
#if defined(__x86_64__) && defined(__GNUC__)
  __builtin_cpu_init();
  const bool v2 = __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
  const bool v3 = v2 && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  return set == "v2" ? v2 : set == "v3" ? v3 : v4;
#else
  return true;
#endif
}

std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets;
#define SET(name_of)                   \
  if (is_there(#name_of)) {            \
    sets.push_back(lanes_##name_of()); \
    sets.back().name = #name_of;       \
  }
  COGGING_SETS
#undef SET
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
