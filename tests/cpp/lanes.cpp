// Controllers in the four lanes of a pack have the bits of the same four one by one, where lanes lose readings and
// where some are sharp and others smooth; and the core's own elementary functions are the library's to the last places.
// tests/simulation/test_lanes.py compares runs in packs, of every controller and effect, through the bindings.

#include "cogging/lanes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "check.hpp"
#include "cogging/control/list.hpp"
#include "cogging/plant/amplifier.hpp"
#include "machines.hpp"

namespace {

using namespace cogging;
using namespace drawn;

constexpr std::size_t width = 4;
using Four = Lanes<width>;

template <class C, class Reading>
auto ask(C& controller, const ReferencePoint& now, const ReferencePoint& ahead, const Reading& reading) {
  if constexpr (LooksAhead<C>)
    return controller.command(now, ahead, reading);
  else
    return controller.command(now, reading);
}

// Each lane loses readings of its own, in the first samples and later, singly and in gaps that are bridged and not;
// some references are lost to all. Commands, estimates and counts are those of the single runs, and numbers.
template <class FourController, class OneController>
void lose_readings() {
  const std::string name(OneController::name);
  std::mt19937_64 engine(7);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1.0p-53; };
  typename FourController::Parameters four_parameters;
  typename OneController::Parameters one_parameters;
  tune(four_parameters);
  tune(one_parameters);
  constexpr double widths[width] = {0.0, 2e-3, 0.0, 8e-3};  // m/s, of the sign: sharp in some lanes, smooth in others
  std::vector<OneController> ones;
  for (std::size_t lane = 0; lane < width; ++lane) {
    if constexpr (requires { four_parameters.coulomb_width.set(lane, widths[lane]); }) {
      four_parameters.coulomb_width.set(lane, widths[lane]);
      one_parameters.coulomb_width = widths[lane];
    }
    ones.emplace_back(one_parameters);
  }
  FourController four(four_parameters);
  long apart = 0;
  const auto compare_to = [&](const Four& pack, std::size_t lane, double single) { apart += !(pack[lane] == single); };
  std::array<int, width> left{3, 0, 1, 20};  // samples that each lane still loses
  for (int k = 0; k < 3000; ++k) {
    const double t = k / 5000.0, w = 12.0;
    ReferencePoint now{0.2 + 0.05 * std::sin(w * t), 0.05 * w * std::cos(w * t), -0.05 * w * w * std::sin(w * t)};
    const ReferencePoint ahead{now.position + 1e-4 * now.velocity, now.velocity, now.acceleration};
    if (k % 500 == 77) now.velocity = NAN;
    Four reading;
    for (std::size_t lane = 0; lane < width; ++lane) {
      if (left[lane] == 0 && uniform() < 0.01) left[lane] = uniform() < 0.8 ? 1 + int(16 * uniform()) : 30;
      reading.set(lane, left[lane] > 0 ? (k % 2 ? NAN : INFINITY) : now.position + 1e-4 * (uniform() - 0.5));
      left[lane] -= left[lane] > 0;
    }
    const Four command = ask(four, now, ahead, reading);
    Four applied = clamp(command, Four(-2.0), Four(2.0));
    if (k % 300 == 5) applied.set(1, NAN);
    four.update(applied);
    for (std::size_t lane = 0; lane < width; ++lane) {
      compare_to(command, lane, ask(ones[lane], now, ahead, reading[lane]));
      ones[lane].update(applied[lane]);
      compare_to(four.samples_refused(), lane, ones[lane].samples_refused());
      for (std::size_t i = 0; i < ones[lane].estimates().size(); ++i)
        compare_to(four.estimates()[i], lane, ones[lane].estimates()[i]);
    }
  }
  check::holds(apart == 0, name + ": lanes that lose readings differ from single runs");
  check::holds(four.samples_refused()[0] > 100.0, name + ": few readings are lost");
}

// Every controller of the list.
template <std::size_t... i>
void lose_readings_of_all(std::index_sequence<i...>) {
  (lose_readings<std::variant_alternative_t<i, AnyController<Four>>, std::variant_alternative_t<i, AnyController<>>>(),
   ...);
}

// What lanes do not share runs on single machines alone: effects with a state, a current loop in some of them, friction
// that sticks, in all lanes or in some.
void refusals() {
  AxisParameters<Four> smooth, sticks, mixed;
  smooth.coulomb = sticks.coulomb = mixed.coulomb = 0.1;
  smooth.coulomb_width = 1e-3, sticks.coulomb_width = 0.0, mixed.coulomb_width = 1e-3;
  mixed.coulomb_width.set(1, 0.0);
  CoulombAsymmetry<Four> asymmetry;  // a friction level of an effect is friction in every lane
  asymmetry.difference = 0.01;
  ActuatorLag<Four> lag;
  lag.time_constant = 1e-3;
  lag.time_constant.set(1, 0.0);
  const auto axis = [](const AxisParameters<Four>& q, std::vector<Effect<Four>> effects = {}) {
    return [=] { Axis<Four>(q, CoggingModel<Four>{}, effects); };
  };
  AxisParameters<Four> frictionless = mixed;
  frictionless.coulomb = 0.0;
  const std::pair<const char*, std::function<void()>> all[] = {
      {"presliding_friction", axis(smooth, {PreslidingFriction<Four>{1e4, 0.0}})},
      {"backlash", axis(smooth, {Backlash<Four>{1e-3, 0.2, 200.0, 0.3}})},
      {"flexible_mode", axis(smooth, {FlexibleMode<Four>{20.0, 0.01, 0.2}})},
      {"coulomb_width: ", axis(sticks)},
      {"coulomb_width: ", axis(mixed)},
      {"coulomb_width: ", axis(frictionless, {asymmetry})},
      {"actuator_lag: ", [&] { Amplifier<Four>({lag}, 1e-3); }},
  };
  for (const auto& [told, make] : all) {
    std::string said = "taken";
    try {
      make();
    } catch (const std::invalid_argument& error) {
      said = error.what();
    }
    check::holds(said.find(told) != std::string::npos, std::string(told) + " in lanes: " + said);
  }
}

// In units of the last place of the exact value, from the library's long double.
double error_in_ulps(double value, long double exact) {
  const double near = std::abs(static_cast<double>(exact));
  const double ulp = std::nextafter(near, INFINITY) - near;
  return static_cast<double>(std::abs(static_cast<long double>(value) - exact) / ulp);
}

void elementary_functions() {
  std::mt19937_64 engine(2);
  const auto uniform = [&] { return 2.0 * static_cast<double>(engine() >> 11) * 0x1.0p-53 - 1.0; };
  double sine_worst = 0.0, atan_worst = 0.0;
  for (double size : {1e-9, 1e-3, 0.5, 1.0, 3.0, 10.0, 300.0, 1e4, 1e6, 1e7, 1e11})
    for (int i = 0; i < 20000; ++i) {
      const double angle = size * uniform();
      double s, c;
      sin_cos(angle, s, c);
      sine_worst = std::max(sine_worst, error_in_ulps(s, std::sin(static_cast<long double>(angle))));
      sine_worst = std::max(sine_worst, error_in_ulps(c, std::cos(static_cast<long double>(angle))));
      atan_worst =
          std::max(atan_worst, error_in_ulps(cogging::atan(angle), std::atan(static_cast<long double>(angle))));
    }
  double exp_worst = 0.0, expm1_worst = 0.0, log_worst = 0.0, tanh_worst = 0.0, pow_worst = 0.0, root_worst = 0.0;
  for (double size : {1e-9, 1e-3, 0.5, 1.0, 10.0, 300.0, 745.0})
    for (int i = 0; i < 20000; ++i) {
      const double x = size * uniform(), exponent = 1.5 + 1.5 * uniform();
      const long double exact = x, base = std::abs(exact);
      exp_worst = std::max(exp_worst, error_in_ulps(cogging::exp(x), std::exp(exact)));
      expm1_worst = std::max(expm1_worst, error_in_ulps(cogging::expm1(x), std::expm1(exact)));
      log_worst = std::max(log_worst, error_in_ulps(cogging::log(std::abs(x)), std::log(base)));
      tanh_worst = std::max(tanh_worst, error_in_ulps(cogging::tanh(x), std::tanh(exact)));
      root_worst = std::max(root_worst, error_in_ulps(cogging::cube_root(std::abs(x)), std::cbrt(base)));
      const double power = error_in_ulps(cogging::pow(std::abs(x), exponent), std::pow(base, (long double)exponent));
      pow_worst = std::max(pow_worst, power / (1.0 + 2.6 * std::abs(exponent * std::log(std::abs(x)))));
    }
  const double worst[][2] = {{sine_worst, 2.5}, {atan_worst, 1.0}, {exp_worst, 1.0}, {expm1_worst, 2.0},
                             {log_worst, 1.0},  {tanh_worst, 2.5}, {pow_worst, 1.0}, {root_worst, 1.0}};
  if (std::numeric_limits<long double>::digits > std::numeric_limits<double>::digits)
    for (const auto& [ulps, most] : worst)
      check::holds(ulps < most, "an elementary function errs by " + std::to_string(ulps) + " units of the last place");
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double ends[] = {cogging::exp(-infinity),         1.0 / cogging::exp(infinity),
                         1.0 / cogging::log(0.0),         1.0 / cogging::log(infinity),
                         cogging::pow(0.0, 0.7),          1.0 / cogging::pow(infinity, 0.7),
                         cogging::expm1(-infinity) + 1.0, cogging::tanh(infinity) - 1.0,
                         cogging::exp(0.0) - 1.0,         cogging::log(1.0),
                         cogging::pow(3.0, 2.0) - 9.0,    cogging::pow(0.0, 0.0) - 1.0};
  for (const double end : ends) check::holds(end == 0.0, "an elementary function at an end of its range");
  const double nan = std::nan(""), none[] = {cogging::exp(nan),  cogging::expm1(nan),    cogging::log(nan),
                                             cogging::log(-1.0), cogging::pow(nan, 0.7), cogging::tanh(nan)};
  for (const double one : none) check::holds(std::isnan(one), "an elementary function of no number");
  double s, c;
  sin_cos(0.0, s, c);
  check::holds(s + c + cogging::atan(0.0) == 1.0, "sine, cosine, arctangent of 0");
  check::holds(cogging::atan(infinity) - cogging::atan(-infinity) == std::numbers::pi, "arctangent of infinity");
  sin_cos(std::nan(""), s, c);
  check::holds(std::isnan(s) && std::isnan(c) && std::isnan(cogging::atan(std::nan(""))), "sine of no number");
}

}  // namespace

int main() {
  lose_readings_of_all(std::make_index_sequence<std::variant_size_v<AnyController<>>>());
  refusals();
  elementary_functions();
  return check::status();
}
