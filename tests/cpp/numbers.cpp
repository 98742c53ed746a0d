// What is no number, or beyond what an integer holds, on its way to a count or to a place in a table.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "check.hpp"
#include "cogging/basis/b_spline.hpp"
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
        const std::string told = std::to_string(positions[i]) + " in a spline of order " + std::to_string(order);
        check::holds(one.first >= 0 && one.first + order <= 13, told);
        double sum = 0.0;
        for (int j = 0; j < order; ++j) sum += one.weight[j];
        check::holds(order == 1 || (std::isnan(positions[i]) ? std::isnan(sum) : std::abs(sum - 1.0) < 1e-12), told);
        Four beside(0.31);
        beside.set(i % 4, positions[i]);
        BSpline::Active<Four> four;
        spline.evaluate(beside, four);
        check::holds(four.first[i % 4] == one.first, told + ", in a lane");
      }
    }
}

}  // namespace

int main() {
  whole_parts<int>("int");
  whole_parts<std::int64_t>("int64_t");
  whole_parts<std::uint64_t>("uint64_t");
  whole_parts<std::size_t>("size_t");
  places_in_a_spline();
  return check::status();
}
