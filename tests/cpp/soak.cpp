// Every controller as a drive would run it, built without exceptions and run-time types, for millions of samples with
// readings that are stuck, jump, are no numbers or are lost, and commands that are cut off: `soak [STEPS [SEED]]`. A
// sample allocates nothing, commands stay numbers, samples that are no measurement are counted and the command held
// within the limit, and the axis comes back to its error before the fault. `soak refuse` makes a controller with a
// parameter that breaks its rule.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <random>
#include <string>

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

constexpr double mass = 0.12, viscous = 0.166, coulomb = 0.15, width = 1e-3, limit = 10.0, travel = 0.5;
constexpr double patience = 8.0;  // s behind a fault in which the error is again what it was
enum Fault { none, stuck, jump, shifted, no_number, infinite, dropped, saturated, faults };
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

/// The motion that all follow.
ReferencePoint reference(double t) {
  const double w = 4.0, s = 0.1;
  return {s * std::sin(w * t), s * w * std::cos(w * t), -s * w * w * std::sin(w * t)};
}

template <class C>
void soak(const typename C::Parameters& parameters, long steps, std::uint64_t seed) {
  static_assert(Controller<C, double>);
  const std::string name(C::name);
  C controller(parameters);
  std::mt19937_64 engine(seed);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1.0p-53; };
  const double rate = parameters.sample_rate, period = 1.0 / rate;
  Axis axis;
  axis.velocity = reference(0.0).velocity;
  long step = 0, allocated = 0, refused = 0, wrong = 0;
  double applied = 0.0, last_reading = 0.0, last_command = 0.0;

  // One sample with a fault or none; the size of its error: of the velocity where the controller knows no position.
  const auto error_of_sample = [&](Fault fault, double size) {
    const double t = std::fmod(static_cast<double>(step++) * period, 1000.0 * 1.5707963267948966);
    const double measured = std::round(axis.position / 1e-6) * 1e-6;
    double reading = fault == stuck ? last_reading : measured;
    if (fault == jump || fault == shifted) reading += size;
    if (fault == no_number) reading = NAN;
    if (fault == infinite) reading = uniform() < 0.5 ? HUGE_VAL : -1e300;
    if (fault != stuck) last_reading = measured;
    if (fault != dropped) {
      const bool is_refused = fault == no_number || fault == infinite;
      const long before = allocations;
      double command;
      if constexpr (LooksAhead<C>)
        command = controller.command(reference(t), reference(t + controller.preview()), reading);
      else
        command = controller.command(reference(t), reading);
      const double most = fault == saturated ? 0.1 : limit;
      applied = std::clamp(command, -most, most);
      controller.update(applied);
      allocated += allocations - before;
      wrong += !std::isfinite(command) || (is_refused && command != std::clamp(last_command, -limit, limit));
      refused += is_refused;
      last_command = command;
    }
    axis.step(applied, period);
    const ReferencePoint next = reference(t + period);
    return std::abs(std::same_as<C, Speed<>> ? axis.velocity - next.velocity : axis.position - next.position);
  };

  double usual = 0.0;
  while (step < 5.0 * rate) {
    const double error = error_of_sample(none, 0.0);
    if (step > 3.0 * rate) usual = std::max(usual, error);
  }
  while (step < steps)
    for (int fault = stuck; fault < faults; ++fault) {
      for (long calm = static_cast<long>(rate * (0.5 + uniform())); calm > 0; --calm) error_of_sample(none, 0.0);
      const double time = fault == jump ? 0.0 : uniform() * (fault == stuck || fault == shifted ? 0.005 : 0.04);
      const double size = std::pow(10.0, -6.0 + 5.0 * uniform()) * (uniform() < 0.5 ? -1.0 : 1.0);
      for (long left = 1 + static_cast<long>(time * rate); left > 0; --left) error_of_sample(Fault(fault), size);
      long within = 0, waited = 0;  // until the error is what it was for 0.1 s
      for (; within < 0.1 * rate && waited < patience * rate; ++waited)
        within = error_of_sample(none, 0.0) <= 2.0 * usual + 1e-6 ? within + 1 : 0;
      check::holds(within >= 0.1 * rate, name + " does not come back from a reading that is " + names[fault]);
    }
  check::holds(allocated == 0, name + " allocates in a sample");
  check::holds(wrong == 0, name + ": commands that are no numbers, or not held where a sample is no measurement");
  check::holds(controller.samples_refused() == static_cast<double>(refused), name + ": samples counted as refused");
}

void soak_all(long steps, std::uint64_t seed) {
  const auto of_axis = [](auto q) {
    q.sample_rate = 5000.0, q.command_limit = limit;
    if constexpr (requires { q.mass; }) q.mass = mass, q.viscous = viscous;
    if constexpr (requires { q.coulomb; }) q.coulomb = coulomb, q.coulomb_width = width;
    return q;
  };
  auto pid = of_axis(PidParameters<>{});
  pid.kp = 9600.0, pid.ki = 1e5, pid.kd = 48.0;
  auto cascade = of_axis(CascadeParameters<>{});
  cascade.kp = 150.0, cascade.kv = 40.0;
  auto speed = of_axis(SpeedParameters<>{});
  speed.kp = 20.0;
  // Lu, Chen, Yao, Wang 2008, X axis.
  auto adaptive = of_axis(AdaptiveRobustParameters<>{});
  adaptive.error_gain = 200.0, adaptive.feedback_gain = 48.0;
  adaptive.mass_bounds = {0.1, 0.2}, adaptive.viscous_bounds = {0.15, 0.35}, adaptive.coulomb_bounds = {0.1, 0.3};
  adaptive.disturbance_bounds = {-0.5, 0.5}, adaptive.mass_adaptation = 1.0, adaptive.viscous_adaptation = 10.0;
  adaptive.coulomb_adaptation = 10.0, adaptive.disturbance_adaptation = 1000.0, adaptive.cogging_adaptation = 100.0;
  adaptive.cogging_harmonics = {1, 2, 3}, adaptive.cogging_bounds = {-0.1, 0.1};
  // Xu and Yao 2001, with the parameters of this axis.
  auto output = of_axis(OutputFeedbackArcParameters{});
  output.theta = {1.0 / mass, viscous / mass, 0.0}, output.theta_min = {5.0, 0.7, -5.0};
  output.theta_max = {10.0, 3.5, 5.0};
  // Malaize and Levine 2009, as `cogging reproduce --compare` has it.
  auto observer = of_axis(ObserverBasedParameters{});
  observer.periods = {0.05, 0.025, 0.05 / 3.0}, observer.viscous = viscous / mass, observer.velocity_min = 5e-3;
  observer.observer_gain = {875.271,    406594.0,   16382100.0, 54587200.0, 9999140.0,
                            39986800.0, 41501700.0, -5471680.0, 51261100.0};
  observer.position_gain = 9e4, observer.velocity_gain = 600.0 - viscous / mass;
  soak<Pid<>>(pid, steps, seed);
  soak<Cascade<>>(cascade, steps, seed);
  soak<Speed<>>(speed, steps, seed);
  soak<Arc<>>(adaptive, steps, seed);
  soak<Dcarc<>>(adaptive, steps, seed);
  soak<OutputFeedbackArc<>>(output, steps, seed);
  soak<ObserverBased<>>(observer, steps, seed);
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
