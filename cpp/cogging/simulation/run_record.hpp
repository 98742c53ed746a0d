#pragma once
// What a run of a batch leaves behind: indexes and other reductions, and those rows of a few columns that were asked
// for.

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cogging/require.hpp"
#include "cogging/simulation/performance.hpp"
#include "cogging/simulation/recorder.hpp"
#include "cogging/simulation/reductions.hpp"

namespace cogging {

/// What is kept of each run.
struct RecordRequest {
  TimeWindow window;  // of indexes and reductions
  std::vector<Reduction> reductions;
  std::vector<std::string> columns;  // of the log, by name
  std::size_t every = 1;             // of the rows, the first and each so many further on
};

/// A column of the log that a row tells.
template <class Scalar>
Scalar column_of(std::size_t which, const RunRow<Scalar>& row) {
  switch (which) {
    case 0:
      return Scalar(row.time);
    case 1:
      return row.position;
    case 2:
      return row.command;
    case 3:
      return Scalar(row.reference.position);
    case 4:
      return Scalar(row.reference.velocity);
    case 5:
      return Scalar(row.reference.acceleration);
    case 6:
      return row.true_position;
    default:
      return row.true_velocity;
  }
}

inline constexpr std::array<std::string_view, 8> column_names{
    "time",          "position",     "command", "reference", "reference_velocity", "reference_acceleration",
    "true_position", "true_velocity"};

inline std::size_t column_number(const std::string& name) {
  const auto* found = std::find(column_names.begin(), column_names.end(), name);
  if (found == column_names.end()) refuse("columns", "must be columns of a log", name);
  return static_cast<std::size_t>(found - column_names.begin());
}

/// The recorder that keeps it, for one run or for as many as the scalar has lanes.
template <class Scalar>
class RunRecord {
 public:
  explicit RunRecord(const RecordRequest& request) : request_(request) {
    require(request.every >= 1, "every", "must be at least 1", static_cast<double>(request.every));
    for (const Reduction& reduction : request.reductions) reduction.validate();
    for (const std::string& name : request.columns) which_.push_back(column_number(name));
  }

  void begin(std::size_t rows, double sample_rate, StopCheck&) {
    rows_ = rows_of(request_.window, rows, [&](std::size_t k) { return static_cast<double>(k) / sample_rate; });
    sums_ = PerformanceSums<Scalar>(rows_);
    reductions_.clear();
    for (const Reduction& one : request_.reductions)
      reductions_.push_back(Quantity{quantity_of(one.quantity), make_reduction<Scalar>(one, rows_.size())});
    columns_.assign(which_.size(), {});
    for (auto& column : columns_) column.reserve((rows - 1) / request_.every + 1);
    until_kept_ = 0;
  }

  void row(const RunRow<Scalar>& row) {
    if (rows_.holds(row.index)) reduce(row);
    if (columns_.empty()) return;
    if (until_kept_ == 0) {
      for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i].push_back(column_of(which_[i], row));
      until_kept_ = request_.every;
    }
    --until_kept_;
  }

  Performance performance_of_lane(std::size_t i) const { return sums_.of_lane(i); }

  /// In the order in which they were asked for.
  std::vector<double> reductions_of_lane(std::size_t i) const {
    std::vector<double> values;
    for (const Quantity& one : reductions_)
      values.push_back(std::visit([&](const auto& reduction) { return reduction.of_lane(i); }, one.reduction));
    return values;
  }

  /// One vector a column, in the order in which they were asked for.
  std::vector<std::vector<double>> columns_of_lane(std::size_t i) const {
    std::vector<std::vector<double>> columns(columns_.size());
    for (std::size_t c = 0; c < columns_.size(); ++c)
      for (const Scalar& value : columns_[c]) columns[c].push_back(lane(value, i));
    return columns;
  }

 private:
  struct Quantity {
    std::size_t quantity;
    AnyReduction<Scalar> reduction;
  };
  static std::size_t quantity_of(const std::string& name) { return name == "error" ? 0 : name == "command" ? 1 : 2; }

  void reduce(const RunRow<Scalar>& row) {
    const Scalar error = row.position - row.reference.position;
    sums_.row(row.index, error, row.command);
    if (reductions_.empty()) return;
    const std::array<Scalar, 3> quantities{error, row.command, row.true_position - row.reference.position};
    for (Quantity& one : reductions_)
      std::visit(
          [&](auto& reduction) { reduction.row(ReducedRow<Scalar>{row.time, row.position, quantities[one.quantity]}); },
          one.reduction);
  }

  RecordRequest request_;
  std::vector<std::size_t> which_;
  RowsOfWindow rows_;
  PerformanceSums<Scalar> sums_;
  std::vector<Quantity> reductions_;
  std::vector<std::vector<Scalar>> columns_;
  std::size_t until_kept_ = 0;
};

}  // namespace cogging
