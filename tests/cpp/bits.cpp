// Numbers of the core in full, to be compared between processors and compilers: every controller, every effect with
// friction that sticks and that is smooth, every motion, and predictions along what they logged. A case is a line with
// its name, a hash over the bits of all its numbers, and then column by column some of them.

#include <bit>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cogging/control/list.hpp"
#include "cogging/estimation/predictor.hpp"
#include "cogging/plant/effects/list.hpp"
#include "cogging/reference/list.hpp"
#include "cogging/simulation/closed_loop.hpp"
#include "machines.hpp"

namespace {

using namespace cogging;

constexpr double pitch = 0.05, frequency = 0.7;
constexpr int points = 9;

Plant<> machine(double width, std::vector<Effect<>> effects) {
  AxisParameters<> axis;
  axis.mass = 0.15, axis.viscous = 0.4, axis.coulomb = 0.2, axis.coulomb_width = width, axis.travel = {-0.15, 0.25};
  const SplineHarmonics basis = SplineHarmonics::of_harmonics(pitch, {1, 2, 3}, BSpline(3, -0.15, pitch, points));
  std::vector<double> coefficients;
  for (int c = 0; c < basis.coefficients(); ++c) coefficients.push_back(0.05 - 0.013 * ((7 * c) % 9));
  return {axis, CoggingModel<>(basis, coefficients), std::move(effects), EncoderParameters{1e-7, 2e-8},
          NoiseParameters{0.01, 40.0}};
}

template <class C>
C controller() {
  typename C::Parameters q;
  drawn::tune(q);
  return C(q);
}

// SplitMix64's mixing, over the bits in their order.
std::uint64_t mixed(std::uint64_t hash, double value) {
  std::uint64_t z = (hash ^ std::bit_cast<std::uint64_t>(value)) + 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

void told(const std::string& name, const std::vector<const std::vector<double>*>& columns) {
  std::uint64_t hash = 0;
  for (const auto* column : columns)
    for (const double value : *column) hash = mixed(hash, value);
  std::printf("%s %016llx", name.c_str(), static_cast<unsigned long long>(hash));
  for (const auto* column : columns) {
    std::printf(" |");
    for (std::size_t k = 1; k <= 40; ++k) std::printf(" %.17g", (*column)[k * (column->size() - 1) / 40]);
  }
  std::printf("\n");
}

// One run, and one step ahead along it with a plant that lacks what is at its front.
template <class C>
void run(const std::string& name, const C& control, const Plant<>& plant, const Reference& motion) {
  RunOptions options;
  options.duration = 0.5;
  options.seed = 5;
  const Log<> log = closed_loop<double>(plant, control, motion, options);
  told(name, {&log.position, &log.command, &log.true_position, &log.true_velocity});
  const Predictor predictor(log.time, log.position, log.command);
  const Prediction along = predictor.predict(plant);
  told(name + ",predicted", {&along.innovation, &along.velocity, &along.slope_velocity});
}

template <class... C>
void every_controller(const std::variant<C...>*, const Reference& motion) {
  const auto both = [&]<class One>(const One& control) {
    for (const double width : {0.0, 2e-3})
      run(std::string(One::name) + (width > 0.0 ? ",smooth" : ",sticks"), control, machine(width, {}), motion);
  };
  (both(controller<C>()), ...);
}

}  // namespace

int main() {
  const Sine sine(SineParameters{0.0, 0.08, frequency});
  const PointToPoint move(PointToPointParameters{.start = -0.05,
                                                 .distance = 0.1,
                                                 .velocity = 0.6,
                                                 .acceleration = 8.0,
                                                 .jerk = 400.0,
                                                 .dwell = 0.05,
                                                 .repeats = 1});
  FilteredSineParameters filtered;
  filtered.amplitude = 0.05, filtered.frequency = frequency;
  every_controller(static_cast<const AnyController<>*>(nullptr), move);
  run("pid,sine", controller<Pid<>>(), machine(2e-3, {}), sine);
  run("pid,filtered_sine", controller<Pid<>>(), machine(0.0, {}), FilteredSine(filtered));
  for (const Effect<>& effect : drawn::sized_effects(true))
    for (const double width : {0.0, 2e-3}) {
      const std::string name = std::visit([]<class E>(const E&) { return std::string(E::name); }, effect);
      run(name + (width > 0.0 ? ",smooth" : ",sticks"), controller<Pid<>>(), machine(width, {effect}), move);
    }
}
