// Numbers of the core in full, to be compared between processors and compilers: every controller, every effect with
// friction that sticks and that is smooth, every motion, and predictions along what they logged. A case is a line with
// its name and a hash over the bits of all its numbers.

#include <bit>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cogging/estimation/predictor.hpp"
#include "cogging/reference/list.hpp"
#include "cogging/simulation/closed_loop.hpp"
#include "machines.hpp"

namespace {

using namespace cogging;
using namespace drawn;

// SplitMix64's mixing, over the bits in their order.
std::uint64_t mixed(std::uint64_t hash, double value) {
  std::uint64_t z = (hash ^ std::bit_cast<std::uint64_t>(value)) + 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

void print(const std::string& name, const std::vector<const std::vector<double>*>& columns) {
  std::uint64_t hash = 0;
  for (const auto* column : columns)
    for (const double value : *column) hash = mixed(hash, value);
  std::printf("%s %016llx\n", name.c_str(), static_cast<unsigned long long>(hash));
}

// One run, and one step ahead along it; with friction that sticks and that is smooth.
template <class C>
void run(const std::string& name, const C& control, const Reference& motion,
         const std::vector<Effect<>>& effects = {}) {
  for (const double width : {0.0, 2e-3}) {
    std::mt19937_64 engine(1);
    const Plant<> plant = machine(engine, width, effects);
    RunOptions options;
    options.duration = 0.5;
    options.seed = 5;
    const Log<> log = closed_loop<double>(plant, control, motion, options);
    const std::string known = name + (width > 0.0 ? ",smooth" : ",sticks");
    print(known, {&log.position, &log.command, &log.true_position, &log.true_velocity});
    const Prediction along = Predictor(log.time, log.position, log.command).predict(plant);
    print(known + ",predicted", {&along.innovation, &along.velocity, &along.slope_velocity});
  }
}

template <class... C>
void every_controller(const std::variant<C...>*, const Reference& motion) {
  (run(std::string(C::name), tuned<C>(), motion), ...);
}

}  // namespace

int main() {
  const PointToPoint move(PointToPointParameters{.start = -0.05,
                                                 .distance = 0.1,
                                                 .velocity = 0.6,
                                                 .acceleration = 8.0,
                                                 .jerk = 400.0,
                                                 .dwell = 0.05,
                                                 .repeats = 1});
  FilteredSineParameters filtered;
  filtered.amplitude = 0.05, filtered.frequency = 0.7;
  every_controller(static_cast<const AnyController<>*>(nullptr), move);
  run("pid,sine", tuned<Pid<>>(), Sine(SineParameters{0.0, 0.08, 0.7}));
  run("pid,filtered_sine", tuned<Pid<>>(), FilteredSine(filtered));
  for (const Effect<>& effect : every_effect())
    run(std::visit([](const auto& law) { return std::string(law.name); }, effect), tuned<Pid<>>(), move, {effect});
}
