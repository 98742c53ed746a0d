// Every controller as a drive would run it: built without exceptions and run-time types; a sample allocates nothing.

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
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
// What becomes of parameters that break a rule is the program's own to say where there are no exceptions.
void cogging::refused(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::exit(3);
}
#endif

namespace {

using namespace cogging;

template <class C>
double ask(C& controller, const ReferencePoint& now, double reading) noexcept {
  if constexpr (LooksAhead<C>)
    return controller.command(now, now, reading);
  else
    return controller.command(now, reading);
}

// A second of a motion to and fro; some readings are lost.
template <class C>
void run(const std::string& name, const typename C::Parameters& parameters) {
  static_assert(Controller<C, double>);
  C controller(parameters);
  const long before = allocations;
  double largest = 0.0, change = 0.0, last = 0.0;
  bool finite = true;
  for (int k = 0; k < 5000; ++k) {
    const double t = k / 5000.0, w = 12.0;
    const ReferencePoint now{0.2 + 0.05 * std::sin(w * t), 0.05 * w * std::cos(w * t), -0.05 * w * w * std::sin(w * t)};
    const double reading = k % 700 == 9 ? NAN : now.position + 1e-6 * std::sin(1000.0 * t);
    const double command = ask(controller, now, reading);
    controller.update(std::fmin(std::fmax(command, -10.0), 10.0));
    finite = finite && std::isfinite(command);
    largest = std::fmax(largest, std::abs(command));
    change += std::abs(command - last);
    last = command;
  }
  const long allocated = allocations - before;
  check::holds(allocated == 0, name + " allocates in a sample");
  check::holds(finite, name + " gives a command that is no number");
  check::holds(largest > 1e-3 && change > 1e-3, name + " does nothing");
  check::holds(controller.samples_refused() == 8.0, name + " takes lost readings");
}

// Against the law as it is written: u = mass a + viscous v - kp e - ki sum - kd (e - e_prev) / Ts.
void pid_follows_its_law() {
  PidParameters<> q;
  q.sample_rate = 4000.0;
  q.kp = 9600.0, q.ki = 1e5, q.kd = 48.0, q.mass = 0.12, q.viscous = 0.166;
  Pid<> pid(q);
  double sum = 0.0, last = 0.0, worst = 0.0;
  for (int k = 0; k < 1000; ++k) {
    const ReferencePoint now{1e-3 * k, 0.1 * std::cos(0.01 * k), std::sin(0.02 * k)};
    const double error = 1e-5 * std::sin(0.1 * k);
    const double command = pid.command(now, now.position + error);
    pid.update(command);
    sum += error / q.sample_rate;
    const double law = q.mass * now.acceleration + q.viscous * now.velocity - q.kp * error - q.ki * sum -
                       (k == 0 ? 0.0 : q.kd * (error - last) * q.sample_rate);
    worst = std::fmax(worst, std::abs(command - law));
    last = error;
  }
  check::holds(worst < 1e-9, "pid leaves its law by " + std::to_string(worst) + " V");
}

void run_all() {
  const auto loop = [](auto q) {
    q.sample_rate = 5000.0;
    q.kp = 100.0, q.mass = 0.12, q.coulomb = 0.1, q.coulomb_width = 1e-3, q.viscous = 0.2;
    q.feedforward_velocity = "measured";
    return q;
  };
  PidParameters<> pid = loop(PidParameters<>{});
  pid.ki = 1e4, pid.kd = 40.0;
  CascadeParameters<> cascade = loop(CascadeParameters<>{});
  cascade.kv = 40.0;
  SpeedParameters<> speed = loop(SpeedParameters<>{});
  speed.delay = 0.00053;
  AdaptiveRobustParameters<> adaptive;
  adaptive.mass_adaptation = 1.0, adaptive.disturbance_adaptation = 1000.0, adaptive.cogging_adaptation = 100.0;
  adaptive.cogging_harmonics = {1, 2, 3}, adaptive.cogging_control_points = 13, adaptive.epsilon = 0.1;
  run<Pid<>>("pid", pid);
  run<Cascade<>>("cascade", cascade);
  run<Speed<>>("speed", speed);
  run<Arc<>>("arc", adaptive);
  run<Dcarc<>>("dcarc", adaptive);
  run<OutputFeedbackArc<>>("output_feedback_arc", {});
  run<ObserverBased<>>("observer_based", {});
}

}  // namespace

int main(int count, char** arguments) {
  if (count > 1 && std::strcmp(arguments[1], "refuse") == 0) {
    PidParameters<> wrong;
    wrong.kp = NAN;
    const Pid<> pid(wrong);
    std::printf("taken: kp = %g\n", pid.parameters().kp);
    return 0;
  }
  run_all();
  pid_follows_its_law();
  return check::status();
}
