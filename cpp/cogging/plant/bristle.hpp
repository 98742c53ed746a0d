#pragma once
// Friction of a contact that deflects before it slides: the bristle state of Dahl (1968) and of Canudas de Wit,
// Olsson, Astrom, Lischinsky (1995, "LuGre").

#include "cogging/scalar.hpp"

namespace cogging {

/// F = stiffness z + damping z', z' = v - stiffness |v| z / g. In steady sliding z = g sgn(v) / stiffness and
/// F = g sgn(v): g is the level of the friction that the bristle stands in for.
struct Bristle {
  double stiffness = infinity;  // V/m; infinite = none, friction follows S(v)
  double damping = 0.0;         // V/(m/s)

  bool exists() const { return std::isfinite(stiffness); }

  /// The deflection after a path (m) in one direction, along which the level goes evenly from one value to another. By
  /// path in place of time the equation is linear, dz/dx = 1 - stiffness z sgn(x) / g, so this is exact at a constant
  /// level, to first order in its change, and can not become unstable however stiff it is.
  double moved(double deflection, double path, double level_start, double level_end) const {
    const double level = 0.5 * (level_start + level_end);
    if (!(level > 0.0)) return 0.0;
    const double bent = stiffness * std::abs(path) / level, relaxed = -expm1(-bent);
    const double lag = bent > 0.0 ? (level_end - level_start) * (1.0 - relaxed / bent) : 0.0;
    const double steady = sign(path) * level_start / stiffness;
    return deflection + (steady - deflection) * relaxed + sign(path) * lag / stiffness;
  }

  /// z', m/s; `level` above 0.
  double rate(double deflection, double velocity, double level) const {
    return velocity - std::abs(velocity) * (stiffness * deflection / level);
  }

  /// Opposes positive motion, V.
  double force(double deflection, double velocity, double level) const {
    if (!(level > 0.0)) return 0.0;
    return stiffness * deflection + damping * rate(deflection, velocity, level);
  }
};

}  // namespace cogging
