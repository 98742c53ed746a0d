// Numbers that an integer does not hold, or that are none, on their way to a count or to a place in a table; and the
// core's elementary functions beside those of the library.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "check.hpp"
#include "cogging/basis/spline_harmonics.hpp"
#include "cogging/lanes.hpp"
#include "cogging/scalar.hpp"

namespace {

using namespace cogging;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double none = std::numeric_limits<double>::quiet_NaN();

template <class Integer>
void whole_parts(const std::string& type) {
  constexpr Integer lowest = std::numeric_limits<Integer>::min(), highest = std::numeric_limits<Integer>::max();
  const double beyond = std::ldexp(1.0, std::numeric_limits<Integer>::digits);  // the first that it does not hold
  const double last = std::min(std::nextafter(beyond, 0.0), beyond - 0.5);
  const auto gives = [&](double value, Integer whole) {
    check::holds(whole_part<Integer>(value) == whole, type + " of " + std::to_string(value));
  };
  gives(none, 0), gives(-none, 0);
  gives(infinity, highest), gives(1e300, highest), gives(beyond, highest);
  gives(-infinity, lowest), gives(-1e300, lowest), gives(-2.0 * beyond, lowest);
  gives(0.0, 0), gives(-0.0, 0), gives(0.999, 0), gives(-0.999, 0), gives(5e-324, 0);
  gives(7.9, 7), gives(-7.9, lowest < 0 ? static_cast<Integer>(-7) : lowest);
  gives(last, static_cast<Integer>(last));
}

// A position anywhere is in one of the spans, in each lane as alone; weights of no position are no numbers.
void places_in_a_spline() {
  using Four = Lanes<4>;
  const std::vector<double> positions{none, infinity, -infinity, 1e300, -1e300, 5e-324, 0.62, 0.6, 0.3, 2147483648.0};
  for (const int order : {1, 2, 3, 4, 7})
    for (const double pitch : {0.05, 1e-300, 1e30}) {
      const BSpline spline(order, 0.0, pitch, 13);
      for (std::size_t i = 0; i < positions.size(); ++i) {
        BSpline::Active<double> one;
        spline.evaluate(positions[i], one);
        const std::string place = std::to_string(positions[i]) + " in a spline of order " + std::to_string(order);
        check::holds(one.first >= 0 && one.first + order <= 13, place);
        double sum = 0.0;
        for (int j = 0; j < order; ++j) sum += one.weight[j];
        check::holds(order == 1 || (std::isnan(positions[i]) ? std::isnan(sum) : std::abs(sum - 1.0) < 1e-12), place);
        Four beside(0.31);
        beside.set(i % 4, positions[i]);
        BSpline::Active<Four> four;
        spline.evaluate(beside, four);
        check::holds(four.first[i % 4] == one.first, place + ", in a lane");
      }
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
  const double ends[] = {cogging::exp(-infinity),         1.0 / cogging::exp(infinity),
                         1.0 / cogging::log(0.0),         1.0 / cogging::log(infinity),
                         cogging::pow(0.0, 0.7),          1.0 / cogging::pow(infinity, 0.7),
                         cogging::expm1(-infinity) + 1.0, cogging::tanh(infinity) - 1.0,
                         cogging::exp(0.0) - 1.0,         cogging::log(1.0),
                         cogging::pow(3.0, 2.0) - 9.0,    cogging::pow(0.0, 0.0) - 1.0};
  for (const double end : ends) check::holds(end == 0.0, "an elementary function at an end of its range");
  const double undefined[] = {cogging::exp(none), cogging::expm1(none),    cogging::log(none),
                              cogging::log(-1.0), cogging::pow(none, 0.7), cogging::tanh(none)};
  for (const double one : undefined) check::holds(std::isnan(one), "an elementary function of no number");
  double s, c;
  sin_cos(0.0, s, c);
  check::holds(s + c + cogging::atan(0.0) == 1.0, "sine, cosine, arctangent of 0");
  check::holds(cogging::atan(infinity) - cogging::atan(-infinity) == std::numbers::pi, "arctangent of infinity");
  sin_cos(none, s, c);
  check::holds(std::isnan(s) && std::isnan(c) && std::isnan(cogging::atan(none)), "sine of no number");
}

// Sine, cosine and smooth sign by those of a place nearby: as exact as alone, wherever that lies, and in each lane the
// bits of its number.
void functions_nearby() {
  using Four = Lanes<4>;
  std::mt19937_64 engine(3);
  const auto uniform = [&] { return 2.0 * static_cast<double>(engine() >> 11) * 0x1.0p-53 - 1.0; };
  const auto basis = SplineHarmonics::of_harmonics(2.0 * std::numbers::pi, {1}, BSpline());
  double worst = 0.0;
  for (const double step : {0.0, 1e-9, 1e-4, 1e-3, 1e-2, 1.0})
    for (int i = 0; i < 20000; ++i) {
      const double from = uniform(), width = std::exp(5.0 * uniform() - 5.0);
      const auto to = Four::map([&](std::size_t lane) { return from + (lane < 2 ? step : 1e-3) * uniform(); });
      const SmoothSign<Four> signs{Four(width)};
      const auto four = signs(to, signs.known(Four(from)));
      const auto waves = basis.wave_at(to, basis.wave_at(Four(from)));
      for (std::size_t lane = 0; lane < 4; ++lane) {
        const SmoothSign<double> sign(width);
        const double x = to[lane], one = sign(x, sign.known(from));
        const auto wave = basis.wave_at(x, basis.wave_at(from));
        if (four[lane] != one || waves.sine[lane] != wave.sine || waves.cosine[lane] != wave.cosine) worst = infinity;
        const long double angle = x, exact = std::atan(angle / width) * 2.0L / std::numbers::pi_v<long double>;
        for (const long double off : {one - exact, wave.sine - std::sin(angle), wave.cosine - std::cos(angle)})
          worst = std::max(worst, static_cast<double>(std::abs(off)));
      }
    }
  check::holds(worst < 4.0 * 0x1.0p-53, "a function nearby errs by " + std::to_string(worst * 0x1.0p53) + " of 2^-53");
  check::holds(std::isnan(SmoothSign<double>(1e-3)(none, {100.0, 0.99})), "a sign of no number");
}

}  // namespace

int main() {
  whole_parts<int>("int");
  whole_parts<std::int64_t>("int64_t");
  whole_parts<std::uint64_t>("uint64_t");
  whole_parts<std::size_t>("size_t");
  places_in_a_spline();
  elementary_functions();
  functions_nearby();
  return check::status();
}
