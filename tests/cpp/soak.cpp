// Every controller as a drive would run it, built without exceptions and run-time types, for millions of samples with
// readings that are stuck, jump, are no numbers or are lost, and commands that are cut off, at random:
// `soak [STEPS [SEED]]`. A sample allocates nothing, commands stay numbers, samples that are no measurement are counted
// and the command held within the limit, and the axis comes back to its error before the fault; how soon, is printed.
// `soak refuse` makes a controller with a parameter that breaks its rule.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <vector>

#include "check.hpp"
#include "cogging/control/adaptive_robust.hpp"
#include "cogging/control/cascade.hpp"
#include "cogging/control/observer_based.hpp"
#include "cogging/control/output_feedback_adaptive_robust.hpp"
#include "cogging/control/pid.hpp"
#include "cogging/control/speed.hpp"

#if defined(__cpp_exceptions) && !defined(_MSC_VER)
#error "this program is to be built with -fno-exceptions"
#endif

namespace {

long allocations = 0;

}  // namespace

COGGING_NOINLINE void* operator new(std::size_t size) {
  ++allocations;
  void* memory = std::malloc(size);
  if (memory == nullptr) std::abort();
  return memory;
}
COGGING_NOINLINE void operator delete(void* memory) noexcept {
  std::free(memory);
}
COGGING_NOINLINE void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

#ifndef _MSC_VER
// Without exceptions the program itself decides what to do with parameters that break a rule.
void cogging::refused(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::exit(3);
}
#endif

namespace {

using namespace cogging;

// SplitMix64: numbers that are the same everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double operator()() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
  }
  int below(int count) { return static_cast<int>((*this)() * count); }

 private:
  std::uint64_t state_;
};

constexpr double mass = 0.12, viscous = 0.166, coulomb = 0.15, width = 1e-3, limit = 10.0, travel = 0.5;
enum Fault { none, stuck, jump, shifted, no_number, infinite, dropped, saturated, faults };
constexpr double patience = 8.0;  // s behind a fault in which the error is again what it was
constexpr const char* names[faults] = {"none",      "stuck",    "jump",    "shifted",
                                       "no number", "infinite", "dropped", "cut off"};

// An axis between two stops that take its speed.
struct Axis {
  double position = 0.0, velocity = 0.0;
  void step(double command, double time) {
    for (int i = 0; i < 4; ++i) {
      const double friction = coulomb * 0.636619772367581 * std::atan(velocity / width);
      // Friction is taken implicitly: at rest it holds, whatever the step.
      const double pushed = velocity + time / 4 * (command - viscous * velocity) / mass;
      const double braked = pushed - time / 4 * friction / mass;
      velocity = pushed * braked < 0.0 && std::abs(pushed) < width ? 0.0 : braked;
      position += time / 4 * velocity;
      if (std::abs(position) > travel) position = std::copysign(travel, position), velocity = 0.0;
    }
  }
};

template <class C>
double ask(C& controller, const ReferencePoint& now, const ReferencePoint& ahead, double reading) noexcept {
  if constexpr (LooksAhead<C>)
    return controller.command(now, ahead, reading);
  else
    return controller.command(now, reading);
}

struct Episode {
  Fault fault = none;
  long from = 0, until = 0;
  double size = 0.0;
};

// Judges one controller: what its commands are, and how soon the error is again what it was before a fault.
class Judge {
 public:
  void command(double given, double before, bool refused) {
    if (!std::isfinite(given)) ++not_finite_;
    if (refused && given != std::clamp(before, -limit, limit)) ++moved_;
  }
  // Calm stretches say what the error is; behind a fault the time is taken until it is that again for 0.1 s.
  void error(double value, long step, const Episode& episode, double rate) {
    const double size = std::abs(value);
    if (step < 5.0 * rate) usual_ = step < 3.0 * rate ? 0.0 : std::max(usual_, size);
    if (episode.fault == none || step < episode.until || done_) return;
    within_ = size <= 2.0 * usual_ + 1e-6 ? within_ + 1 : 0;
    if (within_ < 0.1 * rate) return;
    done_ = true;
    times_[episode.fault].push_back(static_cast<double>(step - within_ + 1 - episode.until) / rate);
  }
  bool is_recovered() const { return done_; }
  void next(const Episode& last) {
    if (last.fault != none && !done_) ++unrecovered_[last.fault];
    done_ = false, within_ = 0;
  }
  void tell(const std::string& name, double refused, double expected) {
    check::holds(not_finite_ == 0, name + ": commands that are no numbers");
    check::holds(moved_ == 0, name + ": a command that is not held where a sample is no measurement");
    check::holds(refused == expected, name + ": samples counted as refused");
    for (int fault = stuck; fault < faults; ++fault) {
      std::vector<double>& times = times_[fault];
      std::sort(times.begin(), times.end());
      const auto at = [&](double share) {
        return times.empty() ? NAN : times[std::size_t(share * (times.size() - 1))];
      };
      std::printf("%s, %s: %zu times, back after %.4f s (half of them), %.4f s (the longest); %ld not within %.0f s\n",
                  name.c_str(), names[fault], times.size() + unrecovered_[fault], at(0.5), at(1.0), unrecovered_[fault],
                  patience);
      check::holds(unrecovered_[fault] == 0, name + " does not come back from a reading that is " + names[fault]);
      check::holds(!times.empty(), name + ": no " + names[fault]);
    }
  }

 private:
  long not_finite_ = 0, moved_ = 0, within_ = 0;
  long unrecovered_[faults] = {};
  double usual_ = 0.0;
  bool done_ = false;
  std::vector<double> times_[faults];
};

Episode drawn(Random& random, long step, double rate) {
  const Fault fault = static_cast<Fault>(1 + random.below(faults - 1));
  const double longest = fault == stuck || fault == shifted ? 0.005 : 0.04;  // s
  const long length = fault == jump ? 1 : 1 + random.below(static_cast<int>(longest * rate));
  const double size = std::pow(10.0, -6.0 + 5.0 * random()) * (random() < 0.5 ? -1.0 : 1.0);
  const long from = step + static_cast<long>(rate * (0.5 + random()));
  return {fault, from, from + length, size};
}

template <class C>
void soak(const std::string& name, const typename C::Parameters& parameters, long steps, std::uint64_t seed) {
  static_assert(Controller<C, double>);
  C controller(parameters);
  long allocated = 0;
  const double rate = parameters.sample_rate, period = 1.0 / rate;
  Random random(seed);
  Axis axis;
  Judge judge;
  Episode episode{none, 0, static_cast<long>(5.0 * rate), 0.0};
  double applied = 0.0, last_reading = 0.0, last_command = 0.0, expected = 0.0;
  const auto reference = [](double t) {
    const double w = 4.0, s = 0.1;
    return ReferencePoint{s * std::sin(w * t), s * w * std::cos(w * t), -s * w * w * std::sin(w * t)};
  };
  double ahead = 0.0;
  if constexpr (LooksAhead<C>) ahead = controller.preview();
  axis.velocity = reference(0.0).velocity;
  for (long step = 0; step < steps; ++step) {
    const bool is_over =
        episode.fault == none || judge.is_recovered() || step >= episode.until + static_cast<long>(patience * rate);
    if (step >= episode.until && is_over) {
      judge.next(episode);
      episode = drawn(random, step, rate);
    }
    const Fault fault = step >= episode.from && step < episode.until ? episode.fault : none;
    const double t = std::fmod(static_cast<double>(step) * period, 1000.0 * 1.5707963267948966);
    const double measured = std::round(axis.position / 1e-6) * 1e-6;
    double reading = fault == stuck ? last_reading : measured;
    if (fault == jump || fault == shifted) reading += episode.size;
    if (fault == no_number) reading = NAN;
    if (fault == infinite) reading = random() < 0.5 ? HUGE_VAL : -1e300;
    if (fault != stuck) last_reading = measured;
    if (fault != dropped) {
      const bool refused = fault == no_number || fault == infinite;
      const long before = allocations;
      const double command = ask(controller, reference(t), reference(t + ahead), reading);
      applied = fault == saturated ? std::clamp(command, -0.1, 0.1) : std::clamp(command, -limit, limit);
      controller.update(applied);
      allocated += allocations - before;
      judge.command(command, last_command, refused);
      expected += refused ? 1.0 : 0.0;
      last_command = command;
    }
    axis.step(applied, period);
    // A velocity loop alone answers for the velocity.
    const ReferencePoint next = reference(t + period);
    const bool of_velocity = std::same_as<C, Speed<>>;
    judge.error(of_velocity ? axis.velocity - next.velocity : axis.position - next.position, step, episode, rate);
  }
  check::holds(allocated == 0, name + " allocates in a sample");
  judge.tell(name, controller.samples_refused(), expected);
}

void soak_all(long steps, std::uint64_t seed) {
  const auto loop = [](auto q) {
    q.sample_rate = 5000.0;
    q.mass = mass, q.viscous = viscous, q.coulomb = coulomb, q.coulomb_width = width, q.command_limit = limit;
    return q;
  };
  PidParameters<> pid = loop(PidParameters<>{});
  pid.kp = 9600.0, pid.ki = 1e5, pid.kd = 48.0;
  CascadeParameters<> cascade = loop(CascadeParameters<>{});
  cascade.kp = 150.0, cascade.kv = 40.0;
  SpeedParameters<> speed = loop(SpeedParameters<>{});
  speed.kp = 20.0;
  // Lu, Chen, Yao, Wang 2008, X axis.
  AdaptiveRobustParameters<> adaptive;
  adaptive.sample_rate = 5000.0, adaptive.error_gain = 200.0, adaptive.feedback_gain = 48.0;
  adaptive.mass = mass, adaptive.viscous = viscous, adaptive.coulomb = coulomb, adaptive.coulomb_width = width;
  adaptive.mass_bounds = {0.1, 0.2}, adaptive.viscous_bounds = {0.15, 0.35}, adaptive.coulomb_bounds = {0.1, 0.3};
  adaptive.disturbance_bounds = {-0.5, 0.5}, adaptive.mass_adaptation = 1.0, adaptive.viscous_adaptation = 10.0;
  adaptive.coulomb_adaptation = 10.0, adaptive.disturbance_adaptation = 1000.0, adaptive.cogging_adaptation = 100.0;
  adaptive.cogging_harmonics = {1, 2, 3}, adaptive.cogging_bounds = {-0.1, 0.1};
  adaptive.command_limit = limit;
  // Xu and Yao 2001, with the parameters of this axis.
  OutputFeedbackArcParameters output;
  output.sample_rate = 5000.0, output.command_limit = limit;
  output.theta = {1.0 / mass, viscous / mass, 0.0}, output.theta_min = {5.0, 0.7, -5.0};
  output.theta_max = {10.0, 3.5, 5.0}, output.coulomb = coulomb, output.coulomb_width = width;
  // Malaize and Levine 2009, as `cogging reproduce --compare` has it.
  ObserverBasedParameters observer;
  observer.sample_rate = 5000.0, observer.command_limit = limit, observer.periods = {0.05, 0.025, 0.05 / 3.0};
  observer.observer_gain = {875.271,    406594.0,   16382100.0, 54587200.0, 9999140.0,
                            39986800.0, 41501700.0, -5471680.0, 51261100.0};
  observer.position_gain = 9e4, observer.velocity_gain = 600.0 - viscous / mass, observer.mass = mass;
  observer.viscous = viscous / mass, observer.velocity_min = 5e-3;
  soak<Pid<>>("pid", pid, steps, seed);
  soak<Cascade<>>("cascade", cascade, steps, seed);
  soak<Speed<>>("speed", speed, steps, seed);
  soak<Arc<>>("arc", adaptive, steps, seed);
  soak<Dcarc<>>("dcarc", adaptive, steps, seed);
  soak<OutputFeedbackArc<>>("output_feedback_arc", output, steps, seed);
  soak<ObserverBased<>>("observer_based", observer, steps, seed);
}

}  // namespace

int main(int count, char** arguments) {
  if (count > 1 && std::strcmp(arguments[1], "refuse") == 0) {
    PidParameters<> wrong;
    wrong.kp = NAN;
    std::printf("taken: kp = %g\n", Pid<>(wrong).parameters().kp);
    return 0;
  }
  const long steps = count > 1 ? std::atol(arguments[1]) : 1'000'000;
  const std::uint64_t seed = count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1;
  soak_all(steps, seed);
  return check::status();
}
