// A controller at its sample rate on a monotonic clock: `real_time_loop [SECONDS] [--no-wait] [--real-time]`.
// --no-wait takes one sample after the other as fast as it can: a simulation. --real-time asks Linux for the scheduling
// class SCHED_FIFO and keeps the memory from being paged out.

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "cogging/reference/point_to_point.hpp"
#include "controller_constants.hpp"
#include "simulated_axis.hpp"
#include "statistics.hpp"

#ifdef __linux__
#include <sched.h>
#include <sys/mman.h>
#endif

namespace {

using Clock = std::chrono::steady_clock;
using constants::Controller;
using Machine = SimulatedAxis;  // here your own

double seconds(Clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

/// Deadlines at multiples of the sample time after the start: what one sample is late by is not handed on to the next.
class Deadlines {
 public:
  Deadlines(double sample_rate, bool waits) : sample_time_(1.0 / sample_rate), waits_(waits) {}

  /// Sleeps until sample k is due; gives the sample that is due then, a later one where its time has passed.
  long wait_for(long k, Durations& lateness) {
    if (!waits_) return k;
    const Clock::time_point deadline = start_ + time_of(k);
    std::this_thread::sleep_until(deadline);  // clock_nanosleep to an absolute time, on Linux
    const double late = seconds(Clock::now() - deadline);
    lateness.add(late);
    return k + static_cast<long>(late / sample_time_);
  }

 private:
  Clock::duration time_of(long k) const {
    return std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(static_cast<double>(k) * sample_time_));
  }

  double sample_time_;
  bool waits_;
  Clock::time_point start_ = Clock::now() + std::chrono::milliseconds(1);
};

template <class C>
double ask(C& controller, const cogging::Reference& motion, double time, double reading) noexcept {
  if constexpr (cogging::LooksAhead<C>)
    return controller.command(motion.at(time), motion.at(time + controller.preview()), reading);
  else
    return controller.command(motion.at(time), reading);
}

/// Samples 0 to count - 1. A sample that was missed is one without a reading to the controller: it holds its command,
/// and takes differences over the time that has passed.
Statistics run(Machine& machine, Controller& controller, const cogging::Reference& motion, long count, bool waits) {
  Statistics statistics;
  const double rate = controller.sample_rate(), limit = controller.command_limit();
  double held = 0.0;
  Deadlines deadlines(rate, waits);
  for (long k = 0; k < count; ++k) {
    for (const long due = deadlines.wait_for(k, statistics.lateness); k < due && k < count; ++k) {
      ask(controller, motion, static_cast<double>(k) / rate, NAN);
      controller.update(held);
      ++statistics.missed;
    }
    if (k == count) break;
    const Clock::time_point begun = Clock::now();
    const double time = static_cast<double>(k) / rate;
    const double reading = machine.read(time);
    const double command = ask(controller, motion, time, reading);
    held = limit > 0.0 ? cogging::clamp(command, -limit, limit) : command;
    machine.write(held);
    controller.update(held);
    statistics.computing.add(seconds(Clock::now() - begun));
    statistics.add_error(reading - motion.at(time).position);
  }
  return statistics;
}

void ask_for_real_time() {
#ifdef __linux__
  const sched_param priority{.sched_priority = 80};
  const bool given = sched_setscheduler(0, SCHED_FIFO, &priority) == 0 && mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
#else
  const bool given = false;
#endif
  std::printf("real-time scheduling: %s\n", given ? "given" : "refused");
}

}  // namespace

int main(int count, char** arguments) {
  double duration = 1.0;
  bool waits = true;
  for (int i = 1; i < count; ++i) {
    if (std::strcmp(arguments[i], "--no-wait") == 0)
      waits = false;
    else if (std::strcmp(arguments[i], "--real-time") == 0)
      ask_for_real_time();
    else
      duration = std::atof(arguments[i]);
  }
  if (!(duration > 0.0 && duration < 1e5)) {
    std::fprintf(stderr, "real_time_loop [SECONDS] [--no-wait] [--real-time]: SECONDS must be above 0 and below 1e5\n");
    return 2;
  }
  const cogging::PointToPoint motion({.start = 0.05,
                                      .distance = 0.4,
                                      .velocity = 0.5,
                                      .acceleration = 10.0,
                                      .jerk = 1000.0,
                                      .dwell = 0.1,
                                      .repeats = 100000});
  Controller controller(constants::controller());
  Machine machine(constants::plant(), motion.at(0.0).position);
  const long samples = std::lround(duration * controller.sample_rate()) + 1;
  std::printf("%ld samples at %g Hz\n", samples, controller.sample_rate());
  run(machine, controller, motion, samples, waits).print();
  return 0;
}
