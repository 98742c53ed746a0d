// Compiled once for each instruction set, with COGGING_SET its name and COGGING_LANES the size of a pack. No inline
// function of it has a name outside of this object (-fno-weak): another may run on a machine that lacks its
// instructions.

#include "run_lanes.hpp"

#include <array>
#include <utility>
#include <variant>

using namespace cogging;

namespace {

constexpr std::size_t count = COGGING_LANES;
using Scalar = Lanes<count>;

// Each lane's rows into the log of its run, by blocks: a row at a time would write to some hundred places in turn.
class LogsInLanes {
 public:
  explicit LogsInLanes(std::span<Log<double>* const> logs) : logs_(logs) {}

  void begin(std::size_t rows, double, StopCheck& stop) {
    rows_ = rows;
    for (Log<double>* log : logs_)
      for (auto* column : {&log->time, &log->position, &log->command, &log->reference, &log->reference_velocity,
                           &log->reference_acceleration, &log->true_position, &log->true_velocity}) {
        stop.ask();
        column->resize(rows);
      }
  }

  void row(const RunRow<Scalar>& row) {
    const std::size_t k = row.index % block;
    time_[k] = row.time, reference_[k] = row.reference;
    rows_of_[k] = {row.position, row.command, row.true_position, row.true_velocity};
    if (k + 1 == block || row.index + 1 == rows_) write(row.index - k, k + 1);
  }

 private:
  static constexpr std::size_t block = 32;

  COGGING_NOINLINE void write(std::size_t first, std::size_t many) {
    for (std::size_t i = 0; i < logs_.size(); ++i) {
      Log<double>& log = *logs_[i];
      const auto copy = [&](std::vector<double>& column, const auto& value) {
        for (std::size_t k = 0; k < many; ++k) column[first + k] = value(k);
      };
      copy(log.time, [&](std::size_t k) { return time_[k]; });
      copy(log.reference, [&](std::size_t k) { return reference_[k].position; });
      copy(log.reference_velocity, [&](std::size_t k) { return reference_[k].velocity; });
      copy(log.reference_acceleration, [&](std::size_t k) { return reference_[k].acceleration; });
      copy(log.position, [&](std::size_t k) { return lane(rows_of_[k][0], i); });
      copy(log.command, [&](std::size_t k) { return lane(rows_of_[k][1], i); });
      copy(log.true_position, [&](std::size_t k) { return lane(rows_of_[k][2], i); });
      copy(log.true_velocity, [&](std::size_t k) { return lane(rows_of_[k][3], i); });
    }
  }

  std::span<Log<double>* const> logs_;
  std::size_t rows_ = 0;
  std::array<double, block> time_;
  std::array<ReferencePoint, block> reference_;
  std::array<std::array<Scalar, 4>, block> rows_of_;
};

template <std::size_t place>
void run_under(const PackOfRuns& pack) {
  using One = std::variant_alternative_t<place, AnyController<>>;
  using Many = std::variant_alternative_t<place, AnyController<Scalar>>;
  std::array<const typename One::Parameters*, count> parameters{};
  for (std::size_t i = 0; i < count; ++i)
    parameters[i] = &std::get<place>(*pack.controllers[std::min(i, pack.controllers.size() - 1)]).parameters();
  LogsInLanes recorder(pack.logs);
  closed_loop_in_lanes<count>(recorder, pack.runs, Many(packed<typename Many::Parameters>(parameters)), pack.reference,
                              pack.options);
}

}  // namespace

#define COGGING_JOINED(a, b) a##b
#define COGGING_NAMED(a, b) COGGING_JOINED(a, b)

void COGGING_NAMED(run_lanes_, COGGING_SET)(const PackOfRuns& pack) {
  detail::at_place(*pack.controllers[0], [&]<std::size_t place>() { run_under<place>(pack); });
}
