// Batches on 1 to 16 threads: every controller on machines with all effects, also runs that fail, batches that are
// stopped or begin at once on what they share, and predictions along one log. All give the bits of one thread (that
// runs in lanes do: tests/simulation/test_lanes.py). Built with a thread sanitizer it shows that no two threads meet:
// `python -m tests.attack.sanitized`.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "check.hpp"
#include "cogging/control/list.hpp"
#include "cogging/estimation/predictor.hpp"
#include "cogging/reference/point_to_point.hpp"
#include "cogging/simulation/batch.hpp"
#include "cogging/simulation/closed_loop.hpp"
#include "cogging/simulation/run_record.hpp"
#include "machines.hpp"

namespace {

using namespace cogging;
using namespace drawn;

using Bits = std::vector<std::uint64_t>;
constexpr unsigned counts[] = {1, 2, 3, 7, 16};  // threads

const PointToPoint motion(PointToPointParameters{
    .start = 0.05, .distance = 0.3, .velocity = 0.5, .acceleration = 10.0, .jerk = 1000.0, .dwell = 0.05});
constexpr double duration = 0.03;  // s

void add_bits(Bits& bits, double value) {
  bits.push_back(std::bit_cast<std::uint64_t>(value));
}
void add_bits(Bits& bits, const std::vector<double>& values) {
  for (const double value : values) add_bits(bits, value);
}

struct Run {
  Plant<> plant;
  AnyController<> controller;
};

// Drag of a user's own, which falls again beyond a speed.
class EddyDrag final : public OwnLaw {
 public:
  double at(double, double velocity, double) const override {
    return -0.05 * velocity / (1.0 + 16.0 * velocity * velocity);
  }
};

// All effects that have no load behind them, and one that is pushed out of its travel; a law of a user's own, shared by
// all runs; a load behind a coupling; friction that sticks. And a run that cannot be set up.
enum Kind { usual, pushed, own_law, flexible, sticking, refused, kinds };

bool has_state(const Effect<>& effect) {
  return std::holds_alternative<PreslidingFriction<>>(effect) || std::holds_alternative<Backlash<>>(effect) ||
         std::holds_alternative<FlexibleMode<>>(effect);
}

Plant<> plant_of_kind(Kind kind, std::mt19937_64& engine, const Custom<double>& own) {
  std::vector<Effect<>> effects = every_effect(uniform(engine, 0.9, 1.1));
  std::erase_if(effects, has_state);
  if (kind == own_law) effects.emplace_back(own);
  if (kind == flexible) effects = {FlexibleMode<double>{80.0, 0.02, 0.1}};
  Plant<> plant = machine(engine, kind == sticking ? 0.0 : uniform(engine, 1e-3, 1e-2), std::move(effects));
  if (kind == refused) plant.axis.mass = -1.0;
  if (kind == pushed) for_each_law(plant.effects, [](ConstantForce<double>& force) { force.level = 1e5; });
  return plant;
}

template <class... C>
std::vector<AnyController<>> controllers(const std::variant<C...>*) {
  return {tuned<C>()...};
}

// Of each controller two runs of each kind.
std::vector<Run> drawn_runs() {
  std::mt19937_64 engine(1);
  Custom<double> own;
  own.label = "eddy_drag";
  own.laws[static_cast<std::size_t>(cogging::Hook::force)] = std::make_shared<const EddyDrag>();
  std::vector<Run> runs;
  for (const auto& controller : controllers(static_cast<const AnyController<>*>(nullptr)))
    for (int kind = 0; kind < 2 * kinds; ++kind)
      runs.push_back({plant_of_kind(Kind(kind % kinds), engine, own), controller});
  return runs;
}

// A batch of runs, as the bindings make it: rows of the motion that all share, and a recorder for each run.
class Batch {
 public:
  Batch(const std::vector<Run>& runs, SharedRows& rows) : runs_(runs), rows_(rows) {
    request_.reductions = {{"error", "max"},          {"error", "quantile", 0.9}, {"command", "final"},
                           {"command", "tone", 80.0}, {"error", "wave", 0.01},    {"true_error", "rms"}};
    request_.columns = {"position", "command"};
    request_.every = 3;
    request_.window.final_window = 0.01;
  }

  // The bits of all runs, on so many threads.
  Bits run(unsigned threads, StopRequest* stop = nullptr) {
    kept_.assign(runs_.size(), KeptOfRun{});
    reasons_.assign(runs_.size(), "");
    run_batch(runs_.size(), threads, stop, [&](std::size_t i) {
      try {
        run_alone(i, stop);
      } catch (const Interrupted&) {
        throw;
      } catch (const std::exception& error) {
        reasons_[i] = error.what();
      }
    });
    return bits();
  }

  std::size_t failures() const {
    return std::size_t(std::count_if(reasons_.begin(), reasons_.end(), [](const auto& r) { return !r.empty(); }));
  }

 private:
  void run_alone(std::size_t i, StopRequest* stop) {
    RunOptions options;
    options.seed = i;
    options.duration = duration;
    options.stop = stop;
    std::visit(
        [&](const auto& controller) {
          const auto rows = rows_.of(motion, duration, controller.sample_rate(), stop);
          RunRecord<double> record(request_);
          closed_loop_into<double>(record, runs_[i].plant, controller, *rows, options);
          kept_[i] = record.take_lane(0);
        },
        runs_[i].controller);
  }

  Bits bits() const {
    Bits all;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      const Performance& p = kept_[i].performance;
      for (const double value : {p.error_max, p.error_rms, p.error_final_max, p.command_rms, p.command_change_rms})
        add_bits(all, value);
      add_bits(all, kept_[i].reductions);
      for (const auto& column : kept_[i].columns) add_bits(all, column);
      for (const char letter : reasons_[i]) all.push_back(static_cast<unsigned char>(letter));
    }
    return all;
  }

  const std::vector<Run>& runs_;
  SharedRows& rows_;
  RecordRequest request_;
  std::vector<KeptOfRun> kept_;
  std::vector<std::string> reasons_;
};

Bits same_on_all_threads(const std::vector<Run>& runs) {
  SharedRows rows;
  Batch batch(runs, rows);
  const Bits expected = batch.run(1);
  check::holds(batch.failures() == 4 * std::variant_size_v<AnyController<>>,
               std::to_string(batch.failures()) + " of " + std::to_string(runs.size()) + " runs fail");
  for (const unsigned threads : counts)
    check::holds(batch.run(threads) == expected, std::to_string(threads) + " threads: other bits");
  std::printf("%zu runs, %zu fail\n", runs.size(), batch.failures());
  return expected;
}

// Several callers at once, each with threads of its own, on the same plants, controllers and rows of the motion.
void several_batches_at_once(const std::vector<Run>& runs, const Bits& expected) {
  SharedRows rows;
  std::array<Bits, 4> found;
  std::vector<std::thread> callers;
  for (std::size_t i = 0; i < found.size(); ++i) callers.emplace_back([&, i] { found[i] = Batch(runs, rows).run(3); });
  for (std::thread& caller : callers) caller.join();
  for (const Bits& bits : found) check::holds(bits == expected, "batches at once: other bits");
}

// Set by another thread once the batch is at work.
class SetFromOutside final : public StopRequest {
 public:
  bool requested(std::chrono::steady_clock::time_point) override {
    asked_.fetch_add(1, std::memory_order_relaxed);
    return stopped_.load(std::memory_order_relaxed);
  }
  void set_when_asked(long times) {
    while (asked_.load(std::memory_order_relaxed) < times) std::this_thread::yield();
    stopped_.store(true, std::memory_order_relaxed);
  }

 private:
  std::atomic<long> asked_{0};
  std::atomic<bool> stopped_{false};
};

// As Python's signals: the caller's thread alone learns of it.
class SeenByCaller final : public StopRequest {
 public:
  bool requested(std::chrono::steady_clock::time_point) override {
    return std::this_thread::get_id() == caller_ && ++asked_ > 20;
  }

 private:
  std::thread::id caller_ = std::this_thread::get_id();
  int asked_ = 0;
};

bool is_interrupted(Batch& batch, unsigned threads, StopRequest& stop) {
  try {
    batch.run(threads, &stop);
  } catch (const Interrupted&) {
    return true;
  }
  return false;
}

void batches_that_are_stopped(const std::vector<Run>& runs, const Bits& expected) {
  SharedRows rows;
  Batch batch(runs, rows);
  for (const unsigned threads : counts) {
    SetFromOutside outside;
    std::thread other([&] { outside.set_when_asked(30); });
    check::holds(is_interrupted(batch, threads, outside), "a batch does not end where another thread says so");
    other.join();
    SeenByCaller caller;
    check::holds(is_interrupted(batch, threads, caller), "a batch does not end where its caller says so");
  }
  check::holds(batch.run(7) == expected, "behind a stopped batch: other bits");
}

// What jobs throw: the one with the lowest number counts, and all others are done.
void jobs_that_throw() {
  for (const unsigned threads : counts) {
    std::vector<int> done(100, 0);
    std::string said;
    try {
      run_batch(done.size(), threads, nullptr, [&](std::size_t i) {
        done[i] = 1;
        if (i % 10 == 7) throw std::runtime_error(std::to_string(i));
      });
    } catch (const std::runtime_error& error) {
      said = error.what();
    }
    check::holds(said == "7", "a batch throws what job " + said + " threw");
    check::holds(std::count(done.begin(), done.end(), 1) == 100, "jobs that are not done");
  }
}

// Along one log: innovations of several plants, and what small forces add.
void predictions_on_all_threads(const std::vector<Run>& runs) {
  RunOptions options;
  options.duration = 10.0 * duration;
  const Log<> log = std::visit([&](const auto& c) { return closed_loop<double>(runs[0].plant, c, motion, options); },
                               runs[0].controller);
  const Predictor predictor(log.time, log.position, log.command);
  std::vector<Plant<>> plants;
  for (std::size_t i = 0; i < 5; ++i) plants.push_back(runs[kinds * 2 * i].plant);  // usual ones
  const Prediction along = predictor.predict(plants[0]);
  std::vector<double> forces;
  for (int i = 0; i < 21; ++i) forces.insert(forces.end(), log.command.begin(), log.command.end());
  const auto bits_on = [&](unsigned threads) {
    Bits bits;
    add_bits(bits, predictor.innovations(plants, threads));
    add_bits(bits, predictor.propagate(along, plants[0].axis.mass, 21, forces, {}, threads));
    return bits;
  };
  const Bits expected = bits_on(1);
  check::holds(expected.size() > 1000, "predictions of no rows");
  for (const unsigned threads : counts)
    check::holds(bits_on(threads) == expected, std::to_string(threads) + " threads: other predictions");
}

}  // namespace

int main() {
  const std::vector<Run> runs = drawn_runs();
  const Bits expected = same_on_all_threads(runs);
  several_batches_at_once(runs, expected);
  batches_that_are_stopped(runs, expected);
  jobs_that_throw();
  predictions_on_all_threads(runs);
  return check::status();
}
