#pragma once
// What a run of a batch leaves behind: indexes and other reductions, and those rows of a few columns that were asked
// for.

#include <utility>

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

/// A column of the log, by name, and what a row says of it.
template <class Scalar>
struct RunColumn {
  std::string_view name;
  Scalar (*of)(const RunRow<Scalar>& row);
};

template <class Scalar>
RunColumn<Scalar> column_named(const std::string& name) {
  using Row = const RunRow<Scalar>&;
  constexpr RunColumn<Scalar> columns[] = {
      {"time", [](Row row) { return Scalar(row.time); }},
      {"position", [](Row row) { return row.position; }},
      {"command", [](Row row) { return row.command; }},
      {"reference", [](Row row) { return Scalar(row.reference.position); }},
      {"reference_velocity", [](Row row) { return Scalar(row.reference.velocity); }},
      {"reference_acceleration", [](Row row) { return Scalar(row.reference.acceleration); }},
      {"true_position", [](Row row) { return row.true_position; }},
      {"true_velocity", [](Row row) { return row.true_velocity; }}};
  for (const RunColumn<Scalar>& column : columns)
    if (column.name == name) return column;
  refuse("columns", "must be columns of a log", name);
}

/// What is left of one run.
struct KeptOfRun {
  Performance performance;
  std::vector<double> reductions;            // in the order in which they were asked for
  std::vector<std::vector<double>> columns;  // likewise
};

/// The recorder that keeps it, for one run or for as many as the scalar has lanes.
template <class Scalar>
class RunRecord final : public Recorder<Scalar> {
 public:
  explicit RunRecord(const RecordRequest& request) : request_(request) {
    require(request.every >= 1, "every", "must be at least 1", request.every);
    for (const Reduction& reduction : request.reductions) reduction.validate();
    for (const std::string& name : request.columns) which_.push_back(column_named<Scalar>(name));
  }

  void begin(std::size_t rows, double sample_rate, StopCheck&) override {
    rows_ = rows_of(request_.window, rows, [&](std::size_t k) { return static_cast<double>(k) / sample_rate; });
    sums_ = PerformanceSums<Scalar>(rows_);
    reductions_.clear();
    for (const Reduction& one : request_.reductions)
      reductions_.push_back(Quantity{quantity_of(one.quantity), make_reduction<Scalar>(one, rows_.size())});
    columns_.assign(which_.size() * lanes_of<Scalar>, {});
    for (auto& column : columns_) column.reserve((rows - 1) / request_.every + 1);
    waiting_.resize(which_.size() * block);
    until_kept_ = waiting_rows_ = 0;
    last_ = rows - 1;
  }

  void row(const RunRow<Scalar>& row) override {
    if (rows_.holds(row.index)) reduce(row);
    if (which_.empty()) return;
    if (until_kept_ == 0) {
      for (std::size_t c = 0; c < which_.size(); ++c) waiting_[c * block + waiting_rows_] = which_[c].of(row);
      ++waiting_rows_;
      until_kept_ = request_.every;
    }
    --until_kept_;
    if (waiting_rows_ == block || row.index == last_) write_waiting();
  }

  /// Of a run that came to its end; its columns are given away.
  KeptOfRun take_lane(std::size_t i) {
    KeptOfRun kept{sums_.of_lane(i), {}, {}};
    for (const Quantity& one : reductions_)
      kept.reductions.push_back(std::visit([&](const auto& reduction) { return reduction.of_lane(i); }, one.reduction));
    for (std::size_t c = 0; c < which_.size(); ++c)
      kept.columns.push_back(std::move(columns_[c * lanes_of<Scalar> + i]));
    return kept;
  }

 private:
  // Rows wait until there are so many of them: each lane's columns lie far from those of the next.
  static constexpr std::size_t block = 32;

  COGGING_NOINLINE void write_waiting() {
    for (std::size_t c = 0; c < which_.size(); ++c)
      for (std::size_t i = 0; i < lanes_of<Scalar>; ++i) {
        std::vector<double>& column = columns_[c * lanes_of<Scalar> + i];
        for (std::size_t k = 0; k < waiting_rows_; ++k) column.push_back(lane(waiting_[c * block + k], i));
      }
    waiting_rows_ = 0;
  }

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
  std::vector<RunColumn<Scalar>> which_;
  RowsOfWindow rows_;
  PerformanceSums<Scalar> sums_;
  std::vector<Quantity> reductions_;
  std::vector<std::vector<double>> columns_;  // column by column, in each lane by lane
  std::vector<Scalar> waiting_;               // the last rows of each column
  std::size_t until_kept_ = 0, waiting_rows_ = 0, last_ = 0;
};

}  // namespace cogging
