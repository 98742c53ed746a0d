#pragma once
// What a run writes into: a whole log, or something that keeps no rows.

#include <concepts>
#include <cstddef>
#include <span>

#include "cogging/interruption.hpp"
#include "cogging/reference/reference.hpp"

namespace cogging {

/// One sample of a run, or of as many runs as the scalar has lanes: they share time and reference.
template <class Scalar>
struct RunRow {
  std::size_t index;
  double time;               // s
  ReferencePoint reference;  // m, m/s, m/s^2
  Scalar position;           // m, encoder reading
  Scalar command;            // V, applied from `time` on
  Scalar true_position;      // m
  Scalar true_velocity;      // m/s
};

/// begin() is told once how many rows will come and at what rate; it may be called again, for a run anew. What
/// the recorder cannot use it refuses there.
template <class R, class Scalar>
concept RecordsRun =
    requires(R recorder, std::size_t rows, double sample_rate, StopCheck& stop, const RunRow<Scalar>& row) {
      recorder.begin(rows, sample_rate, stop);
      recorder.row(row);
    };

/// One that also keeps what the controller believes at the start of each row, where keeps_estimates() says so.
template <class R, class Scalar>
concept RecordsEstimates = requires(R recorder, const R& fixed, std::span<const Scalar> estimates) {
  { fixed.keeps_estimates() } -> std::same_as<bool>;
  recorder.estimates(estimates);
};

}  // namespace cogging
