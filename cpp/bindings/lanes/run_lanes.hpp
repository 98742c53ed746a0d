#pragma once
// Packs of runs, compiled once for each instruction set of the processor; which one runs is chosen at run time.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cogging/control/list.hpp"
#include "cogging/estimation/prediction.hpp"
#include "cogging/simulation/lanes_loop.hpp"
#include "cogging/simulation/reference_rows.hpp"
#include "cogging/simulation/run_record.hpp"

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

/// Instructions for which this module was compiled and that this machine has.
struct InstructionSet {
  std::string name;
  std::size_t lanes;               // runs in a pack
  void (*run)(const PackOfRuns&);  // raises what a run raises before its first row
  void (*net_force)(const PackOfForces&);
};

/// The widest last.
std::vector<InstructionSet> instruction_sets();

/// The one in use: the widest, or what the environment variable COGGING_INSTRUCTIONS names; none where there is none,
/// or where it says `none`.
///
/// Raises std::invalid_argument for a name that is none of this machine's.
std::optional<InstructionSet> instruction_set();
