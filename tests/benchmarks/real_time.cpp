// The step of every controller of the list, call by call: `real_time CALLS`, or `real_time check` for what the
// instruments themselves see. One line for each figure: the controller's name, the figure's, and its value.
// real_time.py builds it with the setups that it writes to setups.hpp, and prints the table.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "real_time_runs.hpp"

namespace {

using namespace real_time;

/// The setup with numbers drawn about their values, switches at random, and half of what is off on.
template <class Parameters>
Parameters drawn(Parameters q, std::mt19937& random) {
  std::uniform_real_distribution<double> factor(0.7, 1.4), small(-0.01, 0.01);
  cogging::for_each_field<Parameters>([&](const auto& field) {
    auto& value = q.*(field.member);
    if constexpr (std::is_same_v<decltype(value), double&>)
      value = value != 0.0 ? value * factor(random) : std::fmax(0.0, small(random));
    if constexpr (std::is_same_v<decltype(value), bool&>) value = small(random) > 0.0;
  });
  return q;
}

/// Of such a setup, or of the one as it is where the controller refuses a hundred draws.
template <class C>
C drawn_controller(std::mt19937& random, long& refused) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    try {
      return C(drawn(setup<C>(), random));
    } catch (const std::invalid_argument&) {  // a bound that the draw has passed
    }
  }
  ++refused;
  return C(setup<C>());
}

double nothing(void*, const ReferencePoint&, const ReferencePoint&, double) {
  return 0.0;
}

/// Bytes of the stack below a call: of samples as they come, and of lost ones.
std::size_t stack_of(const Controlled& c) {
  return stack_touched([&] {
    for (int k = 0; k < 200; ++k) {
      const double x = 0.1 + 1e-3 * k;
      c.step(c.memory, {x, 0.5, 0.1}, {x, 0.5, 0.1}, k % 7 == 3 || (k > 50 && k < 90) ? NAN : x + 1e-5);
    }
  });
}

void say(const std::string& name, const char* figure, double value) {
  std::printf("%s %s %.17g\n", name.c_str(), figure, value);
}

struct Parts {
  Run moving, again, cold, gap, resting, tiny, flushed;
  std::vector<std::uint32_t> shortest;  // ticks of each call, by the quicker of both loops
};

/// A fresh controller for each part: the closed loop twice, cold samples behind it, gaps, two rests, and
/// denormal inputs. Both loops do the same to the bit, so that what is long in one of them alone was the machine's
/// doing.
void measure(const std::function<Controlled()>& fresh, long calls, Parts& found) {
  const cogging::PointToPoint along(motion());
  Run warm_up;
  Loop(along).run(fresh(), 5000, warm_up);
  found.shortest.assign(static_cast<std::size_t>(calls), std::numeric_limits<std::uint32_t>::max());
  found.moving.shortest = found.again.shortest = &found.shortest;
  Loop(along).run(fresh(), calls, found.moving);
  const Controlled c = fresh();
  Loop loop(along);
  loop.run(c, calls, found.again);
  loop.run(c, std::min(200L, calls / 1000 + 1), found.cold, evict);
  gaps(fresh(), along, 1000, found.gap);
  for (const double start : {along.parameters().start, 0.0}) rest(fresh(), start, 100'000, false, found.resting);
  tiny(fresh(), 20'000, found.tiny);
  if (Denormals::flush(true)) tiny(fresh(), 20'000, found.flushed);
  Denormals::flush(false);
}

void say_parts(const std::string& name, const Parts& found, double ticks) {
  const auto in_nanoseconds = [&](const char* figure, auto duration) {
    say(name, figure, static_cast<double>(duration) / ticks);
  };
  const Run& moving = found.moving;
  in_nanoseconds("mean", moving.durations.mean(0.9999));
  in_nanoseconds("median", moving.durations.quantile(0.5));
  in_nanoseconds("most", moving.durations.quantile(0.9999));
  in_nanoseconds("worst", moving.durations.largest());
  in_nanoseconds("own_worst", *std::max_element(found.shortest.begin(), found.shortest.end()));
  in_nanoseconds("cold", found.cold.durations.quantile(0.5));
  in_nanoseconds("gap", found.gap.durations.quantile(0.5));
  in_nanoseconds("resting", found.resting.durations.mean(0.9999));
  in_nanoseconds("tiny", found.tiny.durations.mean(0.99));
  if (found.flushed.durations.count() > 0) in_nanoseconds("flushed", found.flushed.durations.mean(0.99));
  say(name, "longer", static_cast<double>(moving.durations.longer_than(10e3 * ticks)));
  const double calls = static_cast<double>(moving.durations.count());
  say(name, "calls", calls);
  say(name, "error_rms", std::sqrt(moving.error_squares / calls));
  say(name, "error_max", moving.error_max);
  say(name, "command_max", moving.command_max);
  say(name, "differs", moving.error_squares == found.again.error_squares ? 0.0 : 1.0);
  long allocated = 0;
  for (const Run* run : {&moving, &found.again, &found.cold, &found.gap, &found.resting}) allocated += run->allocations;
  say(name, "allocations", static_cast<double>(allocated));
  say(name, "denormal_moving", static_cast<double>(moving.denormal));
  say(name, "denormal_tiny", static_cast<double>(found.tiny.denormal));
  say(name, "denormal_resting", static_cast<double>(found.resting.denormal));
}

void measure_and_say(const std::string& name, const std::function<Controlled()>& fresh, long calls, double ticks) {
  Parts found;
  measure(fresh, calls, found);
  say_parts(name, found, ticks);
  const std::size_t touched = stack_of(fresh()), without = stack_of({nullptr, nothing});
  if (touched > 0) say(name, "touched", static_cast<double>(touched - without + sizeof(void*)));
}

template <class C>
Controlled controlled(C& controller, Step step) {
  Controlled c{&controller, step, controller.sample_rate(), 0.0};
  if constexpr (cogging::LooksAhead<C>) c.preview = controller.preview();
  return c;
}

/// Drawn gains at rest in drawn places, one of them the origin.
template <std::size_t number>
void rest_as_drawn() {
  std::mt19937 random(number);
  Run found;
  long refused = 0;
  for (int draw = 0; draw < 10; ++draw) {
    auto controller = drawn_controller<Listed<number>>(random, refused);
    const double start = 1e-6 * std::uniform_int_distribution<int>(-300'000, 300'000)(random);
    rest(controlled(controller, steps[number]), draw % 3 == 0 ? 0.0 : start, 40'000, draw % 2 == 1, found);
  }
  const std::string name(Listed<number>::name);
  say(name, "drawn_refused", static_cast<double>(refused));
  say(name, "drawn_calls", static_cast<double>(found.durations.count()));
  say(name, "drawn_denormal", static_cast<double>(found.denormal));
  say(name, "drawn_allocations", static_cast<double>(found.allocations));
}

template <std::size_t number>
void measure_listed(long calls, double ticks) {
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
  measure_and_say(name, fresh, calls, ticks);
  rest_as_drawn<number>();
}

template <std::size_t... number>
void measure_all(long calls, std::index_sequence<number...>) {
  const double ticks = Clock::ticks_in_a_nanosecond();
  measure_and_say("none", [] { return Controlled{nullptr, nothing}; }, calls, ticks);
  (measure_listed<number>(calls, ticks), ...);
}

/// What each instrument says of what it must see.
void check_allocations() {
  const auto counted = [](const std::function<void()>& function) {
    const long before = allocations;
    function();
    return static_cast<double>(allocations - before);
  };
  static void* volatile kept;
  say("seen", "nothing", counted([] {}));
  say("seen", "new", counted([] { kept = ::operator new(8); }));
  say("seen", "delete", counted([] { ::operator delete(kept); }));
  say("seen", "vector", counted([] { kept = new std::vector<double>(10); }));
  say("seen", "string", counted([] { kept = new std::string(100, 'x'); }));
#ifdef __GLIBC__
  say("seen", "malloc", counted([] { kept = std::malloc(8); }));
  say("seen", "realloc", counted([] { kept = std::realloc(kept, 80); }));
  say("seen", "free", counted([] { std::free(kept); }));
  say("seen", "calloc", counted([] { kept = std::calloc(2, 8); }));
  say("seen", "aligned_alloc", counted([] { kept = std::aligned_alloc(64, 64); }));
#endif
}

void check_instruments() {
  check_allocations();
  volatile double decays = 1.0;
  for (const int halvings : {500, 1000}) {
    Denormals::forget();
    for (int i = 0; i < halvings; ++i) decays = 0.5 * decays * 0.999;
    say("denormal", std::to_string(halvings).c_str(), Denormals::met() ? 1.0 : 0.0);
  }
  Histogram durations;
  for (std::uint64_t ticks = 1; ticks <= 20'000; ++ticks) durations.add(ticks);
  durations.add(1'000'000);
  for (const double share : {0.5, 0.9999})
    say("quantile", std::to_string(share).c_str(), double(durations.quantile(share)));
  say("quantile", "largest", static_cast<double>(durations.largest()));
  say("quantile", "longer_than_15000.5", static_cast<double>(durations.longer_than(15'000.5)));
  for (const std::size_t size : {1000, 10'000})
    say("stack", std::to_string(size).c_str(), static_cast<double>(stack_touched([size] {
          std::array<volatile unsigned char, 10'000> large;
          for (std::size_t i = 0; i < size; ++i) large[large.size() - 1 - i] = 1;
        })));
}

}  // namespace

int main(int count, char** arguments) {
  if (count == 2 && std::strcmp(arguments[1], "check") == 0) {
    check_instruments();
    return 0;
  }
  const long calls = count == 2 ? std::atol(arguments[1]) : 0;
  if (calls < 1) {
    std::fprintf(stderr, "real_time CALLS | check: CALLS must be a whole number of at least 1\n");
    return 2;
  }
  measure_all(calls, std::make_index_sequence<controllers>{});
  return 0;
}
