// Batches on 1 to 16 threads: every controller on machines with all effects, in lanes and one by one, also runs that
// fail, batches that are stopped or begin at once on what they share, and predictions along one log. All give the bits
// of one thread. Built with a thread sanitizer it shows that no two threads meet: `python -m tests.attack.sanitized`.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
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
#include "cogging/simulation/lanes_loop.hpp"
#include "cogging/simulation/packing.hpp"
#include "cogging/simulation/run_record.hpp"
#include "cogging/simulation/shared_rows.hpp"
#include "machines.hpp"

namespace {

using namespace cogging;
using namespace drawn;

constexpr std::size_t width = 4;
using Four = Lanes<width>;
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

// All effects that may share a pack, or one that runs alone: a law of a user's own, shared by all runs; a load behind a
// coupling; friction that sticks. And a run that cannot be set up.
enum Kind { packed_run, own_law, flexible, sticking, refused, kinds };

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
  return plant;
}

template <class... C>
std::vector<AnyController<>> controllers(const std::variant<C...>*) {
  return {tuned<C>()...};
}

// Of each controller two packs, one with a lane that is pushed out of its travel, and two runs of each other kind.
std::vector<Run> drawn_runs() {
  std::mt19937_64 engine(1);
  Custom<double> own;
  own.label = "eddy_drag";
  own.force_law = std::make_shared<const EddyDrag>();
  std::vector<Run> runs;
  for (const auto& controller : controllers(static_cast<const AnyController<>*>(nullptr)))
    for (int kind = 0; kind < kinds; ++kind)
      for (std::size_t i = 0; i < (kind == packed_run ? 2 * width : 2); ++i) {
        runs.push_back({plant_of_kind(Kind(kind), engine, own), controller});
        if (kind == packed_run && i == width + 1)
          for_each_law(runs.back().plant.effects, [](ConstantForce<double>& force) { force.level = 1e5; });
      }
  return runs;
}

// What a batch of the bindings is made of: jobs of one run or of one pack, rows and recorders.
class Batch {
 public:
  Batch(const std::vector<Run>& runs, SharedRows& rows, bool in_lanes) : runs_(runs), rows_(rows) {
    request_.reductions = {{"error", "max"},          {"error", "quantile", 0.9}, {"command", "final"},
                           {"command", "tone", 80.0}, {"error", "wave", 0.01},    {"true_error", "rms"}};
    request_.columns = {"position", "command"};
    request_.every = 3;
    request_.window.final_window = 0.01;
    std::string last;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const std::string course = in_lanes ? course_of_run(runs[i]) : "";
      if (course.empty() || course != last || jobs_.back().size() == width) jobs_.emplace_back();
      jobs_.back().push_back(i);
      last = course;
    }
  }

  // The bits of all runs, on so many threads.
  Bits run(unsigned threads, StopRequest* stop = nullptr) {
    kept_.assign(runs_.size(), KeptOfRun{});
    reasons_.assign(runs_.size(), "");
    run_batch(jobs_.size(), threads, stop, [&](std::size_t number) {
      const std::vector<std::size_t>& job = jobs_[number];
      if (job.size() > 1 && run_pack(job, stop)) return;
      for (const std::size_t i : job) run_alone(i, stop);
    });
    return bits();
  }

  std::size_t jobs() const { return jobs_.size(); }
  std::size_t failures() const {
    return std::size_t(std::count_if(reasons_.begin(), reasons_.end(), [](const auto& r) { return !r.empty(); }));
  }

 private:
  static std::string course_of_run(const Run& run) {
    std::string text;
    detail::at_place(run.controller, [&]<std::size_t place>() {
      if (const auto course = course_of<place>(run.plant, std::get<place>(run.controller))) text = course->text();
    });
    return text;
  }

  static RunOptions options_of(std::size_t i, StopRequest* stop) {
    RunOptions options;
    options.seed = i;
    options.duration = duration;
    options.stop = stop;
    return options;
  }

  template <class Work>
  void guard(std::size_t i, const Work& work) {
    try {
      work();
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& error) {
      reasons_[i] = error.what();
    }
  }

  void run_alone(std::size_t i, StopRequest* stop) {
    guard(i, [&] {
      std::visit(
          [&](const auto& controller) {
            const auto rows = rows_.of(motion, duration, controller.sample_rate(), stop);
            RunRecord<double> record(request_);
            closed_loop_into<double>(record, runs_[i].plant, controller, *rows, options_of(i, stop));
            kept_[i] = record.take_lane(0);
          },
          runs_[i].controller);
    });
  }

  // False where a pack cannot be set up: each of its runs alone then says why.
  bool run_pack(const std::vector<std::size_t>& job, StopRequest* stop) {
    try {
      pack(job, stop);
    } catch (const std::invalid_argument&) {
      return false;
    }
    return true;
  }

  void pack(const std::vector<std::size_t>& job, StopRequest* stop) {
    std::vector<RunInLane> lanes;
    for (const std::size_t i : job) lanes.push_back({&runs_[i].plant, i, std::nullopt});
    detail::at_place(runs_[job[0]].controller, [&]<std::size_t place>() {
      using Many = std::variant_alternative_t<place, AnyController<Four>>;
      std::array<const typename std::variant_alternative_t<place, AnyController<>>::Parameters*, width> parameters{};
      for (std::size_t i = 0; i < width; ++i)
        parameters[i] = &std::get<place>(runs_[job[std::min(i, job.size() - 1)]].controller).parameters();
      Many controller(packed<typename Many::Parameters>(parameters));
      const auto rows = rows_.of(motion, duration, controller.sample_rate(), stop);
      RunRecord<Four> record(request_);
      closed_loop_in_lanes<width>(record, lanes, controller, *rows, options_of(job[0], stop));
      for (std::size_t i = 0; i < job.size(); ++i)
        guard(job[i], [&] {
          if (lanes[i].ended) std::rethrow_exception(lanes[i].ended);
          kept_[job[i]] = record.take_lane(i);
        });
    });
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
  std::vector<std::vector<std::size_t>> jobs_;
  std::vector<KeptOfRun> kept_;
  std::vector<std::string> reasons_;
};

Bits same_on_all_threads(const std::vector<Run>& runs) {
  SharedRows rows;
  Batch alone(runs, rows, false), packs(runs, rows, true);
  const Bits expected = alone.run(1);
  const std::size_t controllers_count = std::variant_size_v<AnyController<>>;
  check::holds(alone.failures() == 3 * controllers_count,
               std::to_string(alone.failures()) + " of " + std::to_string(runs.size()) + " runs fail");
  check::holds(packs.jobs() + (2 * (width - 1) + 1) * controllers_count == alone.jobs(),
               std::to_string(packs.jobs()) + " jobs: runs that do not share packs");
  for (const unsigned threads : counts) {
    check::holds(alone.run(threads) == expected, std::to_string(threads) + " threads: other bits");
    check::holds(packs.run(threads) == expected, std::to_string(threads) + " threads, in packs: other bits");
  }
  std::printf("%zu runs, %zu jobs, %zu fail\n", runs.size(), packs.jobs(), packs.failures());
  return expected;
}

// Several callers at once, each with threads of its own, on the same plants, controllers and rows of the motion.
void several_batches_at_once(const std::vector<Run>& runs, const Bits& expected) {
  SharedRows rows;
  std::array<Bits, 4> found;
  std::vector<std::thread> callers;
  for (std::size_t i = 0; i < found.size(); ++i)
    callers.emplace_back([&, i] { found[i] = Batch(runs, rows, i % 2 == 0).run(3); });
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
  Batch batch(runs, rows, true);
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
  for (std::size_t i = 0; i <= width; ++i) plants.push_back(runs[i].plant);  // the next is pushed
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
