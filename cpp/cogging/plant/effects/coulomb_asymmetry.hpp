#pragma once
// A Coulomb level that differs with direction.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// Coulomb level Fc + difference/2 forward, Fc - difference/2 backward.
template <class Scalar = double>
struct CoulombAsymmetry {
  static constexpr std::string_view name = "coulomb_asymmetry";
  static constexpr std::string_view law = "-(difference / 2) sgn(v) S(v)";

  Scalar difference = 0.0;  // V

  static constexpr auto fields() {
    return std::tuple{Field{"difference", &CoulombAsymmetry::difference, "V", "forward level less backward level",
                            amplitude(Quantity::friction, 2.0)}};
  }

  Scalar friction_level(const Motion<Scalar>& motion) const { return 0.5 * difference * sign(motion.direction); }

  Variation variation() const { return {.velocity = all(difference == 0.0) ? infinity : 0.0}; }
};

}  // namespace cogging
