#pragma once
// What parameters of an effect are together. A program that knows no field by name reads it here.

#include <variant>

#include "cogging/parameters.hpp"
#include "cogging/require.hpp"

namespace cogging {

/// A sine and a cosine of one period. The members of this and of the other kinds are names of fields.
struct Wave {
  std::string shape, sine, cosine;

  static constexpr auto fields() {
    return std::tuple{Field{"shape", &Wave::shape, "", "its period (m), or its frequency (Hz)"},
                      Field{"sine", &Wave::sine, "", "amplitude of the sine"},
                      Field{"cosine", &Wave::cosine, "", "amplitude of the cosine"}};
  }
};

/// A stretch of time.
struct Window {
  std::string start, stop;

  static constexpr auto fields() {
    return std::tuple{Field{"start", &Window::start, "", "time at which it begins (s)"},
                      Field{"stop", &Window::stop, "", "time at which it ends (s)"}};
  }
};

/// Values at nodes, linear between two.
struct Knots {
  std::string coordinate = "position";
  std::string nodes, levels;

  static constexpr auto fields() {
    return std::tuple{Field{"coordinate", &Knots::coordinate, "", "of the nodes: position, velocity or time"},
                      Field{"nodes", &Knots::nodes, "", "list of places, increasing"},
                      Field{"levels", &Knots::levels, "", "list of values, one a node"}};
  }
  void validate() const {
    if (coordinate != "position" && coordinate != "velocity" && coordinate != "time")
      refuse("coordinate", "must be position, velocity or time", "\"" + coordinate + "\"");
  }
};

/// Even knots along the travel, of B-splines whose control points are the effect's lists of amplitudes.
struct SplineKnots {
  std::string pitch, order, origin;

  static constexpr auto fields() {
    using K = SplineKnots;
    return std::tuple{Field{"pitch", &K::pitch, "", "distance of the knots (m)"},
                      Field{"order", &K::order, "", "of the B-splines"},
                      Field{"origin", &K::origin, "", "first knot of the first full span (m)"}};
  }
};

/// The ends of the travel, taken from the plant where they are not given.
struct Travel {
  std::string ends;

  static constexpr auto fields() { return std::tuple{Field{"ends", &Travel::ends, "", "lower and upper end (m)"}}; }
};

/// A stretch of the travel about a place.
struct Place {
  std::string center, width;

  static constexpr auto fields() {
    return std::tuple{Field{"center", &Place::center, "", "its middle (m)"},
                      Field{"width", &Place::width, "", "how far it reaches to each side (m)"}};
  }
};

/// A wave of exactly one turn, which only an axis with a position in rad has.
struct Turn {
  std::string angle;

  static constexpr auto fields() {
    return std::tuple{Field{"angle", &Turn::angle, "", "where it is zero and rises (rad)"}};
  }
};

using Kind = std::variant<Wave, Window, Knots, SplineKnots, Travel, Place, Turn>;
using Kinds = std::vector<Kind>;

template <class E>
concept HasKinds = requires { E::kinds(); };

}  // namespace cogging
