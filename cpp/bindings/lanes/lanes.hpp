#pragma once
// What packs of runs and of forces are given.

#include <span>

#include "cogging/control/list.hpp"
#include "cogging/estimation/prediction.hpp"
#include "cogging/simulation/lanes_loop.hpp"
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
