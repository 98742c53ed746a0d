#pragma once
// Friction of a contact that deflects before it slides: the bristle state of Dahl (1968) and of Canudas de Wit,
// Olsson, Astrom, Lischinsky (1995, "LuGre").

#include <cmath>
#include <limits>

#include "cogging/scalar.hpp"

namespace cogging {

/// F = stiffness z + damping z', z' = v - stiffness |v| z / g. In steady sliding z = g sgn(v) / stiffness and
/// F = g sgn(v): g is the level of the friction that the bristle stands in for.
struct Bristle {
  double stiffness = std::numeric_limits<double>::infinity();  // V/m; infinite = none, friction follows S(v)
  double damping = 0.0;                                        // V/(m/s)

  bool exists() const { return std::isfinite(stiffness); }

  /// The deflection after a path (m) at a constant level and in one direction. By path in place of time the
  /// equation is linear, dz/dx = 1 - stiffness z sgn(x) / g, so this is exact, and can not become unstable
  /// however stiff it is.
  double moved(double deflection, double path, double level) const {
    if (!(level > 0.0)) return 0.0;
    const double steady = level * sign(path) / stiffness;
    return deflection + (deflection - steady) * std::expm1(-stiffness * std::abs(path) / level);
  }

  /// Opposes positive motion, V.
  double force(double deflection, double velocity, double level) const {
    if (!(level > 0.0)) return 0.0;
    return stiffness * deflection + damping * (velocity - std::abs(velocity) * (stiffness * deflection / level));
  }
};

}  // namespace cogging
