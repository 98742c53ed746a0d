#pragma once
// What a run writes into: a whole log, or (run_record.hpp) something that keeps few rows or none.

#include <cstddef>
#include <span>
#include <vector>

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

/// What receives every row of a run.
template <class Scalar>
class Recorder {
 public:
  virtual ~Recorder() = default;
  /// Announces the number of rows and their rate; called again where a run starts anew. A recorder refuses here what it
  /// cannot use.
  virtual void begin(std::size_t rows, double sample_rate, StopCheck& stop) = 0;
  virtual void row(const RunRow<Scalar>& row) = 0;
  /// Whether it also keeps what the controller believes at the start of each row.
  virtual bool keeps_estimates() const { return false; }
  virtual void estimates(std::span<const Scalar>) {}
};

inline constexpr std::size_t log_columns = 8;  // of a log without estimates

/// Columns of a run, one entry a sample. The true position and velocity are the plant's own, not the
/// encoder's.
template <class Scalar = double>
struct Log {
  std::vector<double> time;                    // s
  std::vector<Scalar> position;                // m, encoder reading
  std::vector<Scalar> command;                 // V, applied from `time` on
  std::vector<double> reference;               // m
  std::vector<double> reference_velocity;      // m/s
  std::vector<double> reference_acceleration;  // m/s^2
  std::vector<Scalar> true_position;           // m
  std::vector<Scalar> true_velocity;           // m/s
  std::vector<Scalar> estimates;               // the controller's, one row a sample; empty unless asked for
  int estimate_count = 0;
};

/// Writes each row of a run into a log, but for the reference, whose columns the caller has already.
template <class Scalar>
class LogRecorder final : public Recorder<Scalar> {
 public:
  explicit LogRecorder(bool keeps_estimates) : keeps_estimates_(keeps_estimates) {}

  void begin(std::size_t rows, double, StopCheck& stop) override {
    const auto make = [&](auto& column) {
      stop.ask();  // a column of a long run takes long to clear
      column.resize(rows);
    };
    make(log.time);
    for (auto* column : {&log.position, &log.command, &log.true_position, &log.true_velocity}) make(*column);
  }

  void row(const RunRow<Scalar>& row) override {
    log.time[row.index] = row.time;
    log.position[row.index] = row.position;
    log.command[row.index] = row.command;
    log.true_position[row.index] = row.true_position;
    log.true_velocity[row.index] = row.true_velocity;
  }

  bool keeps_estimates() const override { return keeps_estimates_; }
  void estimates(std::span<const Scalar> estimates) override {
    if (log.estimate_count == 0) {
      log.estimate_count = static_cast<int>(estimates.size());
      log.estimates.reserve(log.time.size() * estimates.size());
    }
    log.estimates.insert(log.estimates.end(), estimates.begin(), estimates.end());
  }

  Log<Scalar> log;

 private:
  bool keeps_estimates_;
};

}  // namespace cogging
