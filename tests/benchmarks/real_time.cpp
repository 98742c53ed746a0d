// The step of every controller of the list, call by call: `real_time CALLS TICKS`. Prints one line for each figure (the
// controller's name, the figure's, its value) and writes the duration of each call (ticks, 32 bits) to the file TICKS;
// `ticks_NAME COUNT` names each series, in the order of the file. real_time.py builds it with the setups that it writes
// to setups.hpp, and prints the table.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <random>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#if defined(__x86_64__)
#include <immintrin.h>
#else
#include <cfenv>
#endif

#include "cogging/inlining.hpp"
#include "cogging/reference/point_to_point.hpp"
#include "real_time_step.hpp"
#include "setups.hpp"
#include "simulated_axis.hpp"

namespace {

long allocations = 0;         // calls of new and delete
std::size_t bytes_asked = 0;  // of new

}  // namespace

COGGING_NOINLINE void* operator new(std::size_t size) {
  ++allocations;
  bytes_asked += size;
  void* memory = std::malloc(size);
  if (memory == nullptr) std::abort();
  return memory;
}
COGGING_NOINLINE void operator delete(void* memory) noexcept {
  ++allocations;
  std::free(memory);
}
COGGING_NOINLINE void operator delete(void* memory, std::size_t) noexcept {
  ::operator delete(memory);
}

namespace {

using namespace real_time;
using cogging::ReferencePoint;

// Ticks of the processor's counter where there is one, else nanoseconds; the fences keep the step between both reads.
#if defined(__x86_64__)
std::uint64_t begin_ticks() noexcept {
  _mm_lfence();
  const std::uint64_t ticks = __rdtsc();
  _mm_lfence();
  return ticks;
}
std::uint64_t end_ticks() noexcept {
  unsigned processor;
  const std::uint64_t ticks = __rdtscp(&processor);
  _mm_lfence();
  return ticks;
}
#else
std::uint64_t begin_ticks() noexcept {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
}
std::uint64_t end_ticks() noexcept {
  return begin_ticks();
}
#endif

double ticks_per_nanosecond() {
  const auto begun = std::chrono::steady_clock::now();
  const std::uint64_t ticks = begin_ticks();
  while (std::chrono::steady_clock::now() - begun < std::chrono::milliseconds(50)) {
  }
  const std::uint64_t passed = end_ticks() - ticks;
  const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - begun;
  return static_cast<double>(passed) / time.count();
}

// Whether arithmetic met a denormal number since `forget`: as an operand (x86 alone tells) or as a rounded result.
struct Denormals {
#if defined(__x86_64__)
  static constexpr unsigned flags = 0x02 | 0x10, to_zero = 0x40 | 0x8000;  // DE, UE; DAZ, FTZ of MXCSR
  static void forget() noexcept { _mm_setcsr(_mm_getcsr() & ~flags); }
  static bool met() noexcept { return (_mm_getcsr() & flags) != 0; }
  /// Takes them as 0 and puts them out as 0 from here on; whether this is possible.
  static bool flush(bool wanted) noexcept {
    _mm_setcsr(wanted ? _mm_getcsr() | to_zero : _mm_getcsr() & ~to_zero);
    return true;
  }
#else
  static void forget() noexcept { std::feclearexcept(FE_UNDERFLOW); }
  static bool met() noexcept { return std::fetestexcept(FE_UNDERFLOW) != 0; }
  static bool flush(bool) noexcept { return false; }
#endif
};

struct Controlled {
  void* memory = nullptr;
  Step step = nullptr;
  double sample_rate = 5000.0, preview = 0.0;
};

struct Run {
  std::vector<std::uint32_t> ticks;
  long allocations = 0, denormal = 0;
  double error_squares = 0.0, error_max = 0.0, command_max = 0.0;

  /// One step, timed.
  double take(const Controlled& c, const ReferencePoint& now, const ReferencePoint& ahead, double reading) {
    Denormals::forget();
    const long before = ::allocations;
    const std::uint64_t begun = begin_ticks();
    const double command = c.step(c.memory, now, ahead, reading);
    const std::uint64_t ended = end_ticks();
    denormal += Denormals::met();
    allocations += ::allocations - before;
    ticks.push_back(static_cast<std::uint32_t>(std::min<std::uint64_t>(ended - begun, UINT32_MAX)));
    const double error = reading - now.position;
    error_squares += error * error;
    error_max = std::fmax(error_max, std::abs(error));
    command_max = std::fmax(command_max, std::abs(command));
    return command;
  }
};

/// The machine and its motion, and how far they have come.
struct Loop {
  const cogging::PointToPoint& motion;
  SimulatedAxis axis{plant(), motion.at(0.0).position};
  long sample = 0;

  /// Samples in closed loop; `cold` pushes what lies in the caches out before each, as other work on a machine does.
  void run(const Controlled& c, long samples, Run& found, bool cold = false) {
    static std::vector<unsigned char> other(std::size_t{1} << 25);
    for (const long end = sample + samples; sample < end; ++sample) {
      for (std::size_t i = 0; cold && i < other.size(); i += 64) ++other[i];
      const double time = static_cast<double>(sample) / c.sample_rate;
      const double reading = axis.read(time);
      axis.write(found.take(c, motion.at(time), motion.at(time + c.preview), reading));
    }
  }
};

/// A move there and back that ends exactly where it began, then rest: what is not driven any more dies away. With
/// `losses`, some readings are lost.
void rest(const Controlled& c, double start, long samples, bool losses, Run& found) {
  cogging::PointToPointParameters once = motion();
  once.start = start;
  once.repeats = 1;
  const cogging::PointToPoint move(once);
  const double resolution = plant().encoder.resolution;
  const long moving = static_cast<long>(move.end() * c.sample_rate) + 1;
  Run before;
  for (long k = 0; k < moving + samples; ++k) {
    const double time = static_cast<double>(k) / c.sample_rate;
    const ReferencePoint now = move.at(time);
    const double behind = resolution * std::round(5.0 * std::sin(300.0 * time));  // as a loop leaves it
    const double reading = losses && k % 5003 < k % 29 ? NAN : k < moving ? now.position + behind : start;
    (k < moving ? before : found).take(c, now, move.at(time + c.preview), reading);
  }
  found.denormal += before.denormal;
  found.allocations += before.allocations;
}

/// Samples behind 16 lost readings, as many as an observer makes up for at once.
void gaps(const Controlled& c, const cogging::PointToPoint& along, long samples, Run& found) {
  Run lost;
  for (long k = 0; k < 17 * samples; ++k) {
    const double time = static_cast<double>(k) / c.sample_rate;
    const ReferencePoint now = along.at(time), ahead = along.at(time + c.preview);
    (k % 17 == 0 ? found : lost).take(c, now, ahead, k % 17 == 0 ? now.position : NAN);
  }
  found.allocations += lost.allocations;
}

/// Readings and references that are denormal numbers, as those of a simulation or of a filter may become.
void tiny(const Controlled& c, long samples, Run& found) {
  for (long k = 0; k < samples; ++k) {
    const double x = 1e-310 * (2.0 + std::sin(0.1 * static_cast<double>(k)));
    found.take(c, {x, -x, x}, {x, -x, x}, 2.0 * x);
  }
}

void say(const std::string& name, const std::string& figure, double value) {
  std::printf("%s %s %.17g\n", name.c_str(), figure.c_str(), value);
}

std::FILE* ticks_file = nullptr;

void write_ticks(const std::string& name, const std::string& series, const Run& run) {
  say(name, "ticks_" + series, static_cast<double>(run.ticks.size()));
  std::fwrite(run.ticks.data(), sizeof(std::uint32_t), run.ticks.size(), ticks_file);
}

/// A fresh controller for each part: the closed loop twice, cold samples behind it, gaps, rests, and denormal inputs.
/// Both loops do the same to the bit, so what is long in one of them alone was the machine's doing.
template <class Fresh>
void measure(const std::string& name, const Fresh& fresh, long calls) {
  const cogging::PointToPoint along(motion());
  Run warm_up, moving, again, cold, gap, resting, small, flushed;
  Loop{along}.run(fresh(), 5000, warm_up);
  moving.ticks.reserve(static_cast<std::size_t>(calls));
  again.ticks.reserve(static_cast<std::size_t>(calls));
  Loop{along}.run(fresh(), calls, moving);
  const Controlled c = fresh();
  Loop loop{along};
  loop.run(c, calls, again);
  loop.run(c, std::min(200L, calls / 1000 + 1), cold, true);
  gaps(fresh(), along, 1000, gap);
  for (const double start : {along.parameters().start, 0.0}) rest(fresh(), start, 100'000, false, resting);
  tiny(fresh(), 20'000, small);
  if (Denormals::flush(true)) tiny(fresh(), 20'000, flushed);
  Denormals::flush(false);
  write_ticks(name, "moving", moving), write_ticks(name, "again", again), write_ticks(name, "cold", cold);
  write_ticks(name, "gap", gap), write_ticks(name, "resting", resting), write_ticks(name, "tiny", small);
  write_ticks(name, "flushed", flushed);
  say(name, "error_rms", std::sqrt(moving.error_squares / static_cast<double>(calls)));
  say(name, "error_max", moving.error_max);
  say(name, "command_max", moving.command_max);
  say(name, "differs", moving.error_squares == again.error_squares ? 0.0 : 1.0);
  long allocated = 0;
  for (const Run* run : {&moving, &again, &cold, &gap, &resting}) allocated += run->allocations;
  say(name, "allocations", static_cast<double>(allocated));
  say(name, "denormal", static_cast<double>(moving.denormal + resting.denormal));
  say(name, "denormal_tiny", static_cast<double>(small.denormal));
}

/// The controller of this setup with numbers drawn about their values, switches at random, and half of what is off on;
/// of the setup as it is where the controller refuses a hundred draws.
template <class C>
C drawn_controller(std::mt19937& random, long& refused) {
  using Parameters = typename C::Parameters;
  std::uniform_real_distribution<double> factor(0.7, 1.4), small(-0.01, 0.01);
  for (int attempt = 0; attempt < 100; ++attempt) {
    Parameters q = setup<C>();
    cogging::for_each_field<Parameters>([&](const auto& field) {
      auto& value = q.*(field.member);
      if constexpr (std::is_same_v<decltype(value), double&>)
        value = value != 0.0 ? value * factor(random) : std::fmax(0.0, small(random));
      if constexpr (std::is_same_v<decltype(value), bool&>) value = small(random) > 0.0;
    });
    try {
      return C(q);
    } catch (const std::invalid_argument&) {  // a bound that the draw has passed
    }
  }
  ++refused;
  return C(setup<C>());
}

template <class C>
Controlled controlled(C& controller, Step step) {
  Controlled c{&controller, step, controller.sample_rate(), 0.0};
  if constexpr (cogging::LooksAhead<C>) c.preview = controller.preview();
  return c;
}

template <std::size_t number>
void measure_listed(long calls) {
  using C = Listed<number>;
  const std::string name(C::name);
  C controller(setup<C>());
  const std::size_t before = bytes_asked;
  const C copy(controller);
  say(name, "bytes", static_cast<double>(sizeof(C)));
  say(name, "heap", static_cast<double>(bytes_asked - before));
  const auto fresh = [&] {
    controller = copy;
    return controlled(controller, steps[number]);
  };
  measure(name, fresh, calls);

  std::mt19937 random(number);  // drawn gains at rest in drawn places, one of them the origin
  Run found;
  long refused = 0;
  for (int draw = 0; draw < 10; ++draw) {
    auto drawn = drawn_controller<C>(random, refused);
    const double start = 1e-6 * std::uniform_int_distribution<int>(-300'000, 300'000)(random);
    rest(controlled(drawn, steps[number]), draw % 3 == 0 ? 0.0 : start, 40'000, draw % 2 == 1, found);
  }
  say(name, "drawn_refused", static_cast<double>(refused));
  say(name, "drawn_denormal", static_cast<double>(found.denormal));
  say(name, "drawn_allocations", static_cast<double>(found.allocations));
}

double nothing(void*, const ReferencePoint&, const ReferencePoint&, double) {
  return 0.0;
}

template <std::size_t... number>
void measure_all(long calls, std::index_sequence<number...>) {
  say("clock", "ticks_per_nanosecond", ticks_per_nanosecond());
  measure("none", [] { return Controlled{nullptr, nothing}; }, calls);
  (measure_listed<number>(calls), ...);
}

}  // namespace

int main(int, char** arguments) {
  ticks_file = std::fopen(arguments[2], "wb");
  if (ticks_file == nullptr) return 2;
  measure_all(std::atol(arguments[1]), std::make_index_sequence<controllers>{});
  return std::fclose(ticks_file) == 0 ? 0 : 2;
}
