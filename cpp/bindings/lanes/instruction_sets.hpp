#pragma once
// The instruction sets for which packs of runs are compiled; which one runs is chosen at run time.

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

struct PackOfRuns;
struct PackOfForces;

/// Instructions for which this module was compiled and that this machine has.
struct InstructionSet {
  std::size_t lanes;               // runs in a pack
  void (*run)(const PackOfRuns&);  // raises what a run raises before its first row
  void (*net_force)(const PackOfForces&);
  std::string_view name = {};
};

/// The widest last.
std::vector<InstructionSet> instruction_sets();

/// The one in use: the widest, or what the environment variable COGGING_INSTRUCTIONS names; none where there is none,
/// or where it says `none`.
///
/// Raises std::invalid_argument for a name that is none of this machine's.
std::optional<InstructionSet> instruction_set();
