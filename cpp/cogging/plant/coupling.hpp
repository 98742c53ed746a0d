#pragma once
// What holds motor and load together where they are two masses.

#include <numbers>

#include "cogging/scalar.hpp"

namespace cogging {

/// As the effects say it: the axis' mass is the total, the load's share of it `mass_ratio`.
struct CouplingParameters {
  double mass_ratio = 0.0;      // load / total
  double frequency = infinity;  // Hz, free-free, of the two masses in contact
  double damping_ratio = 0.0;   // of that vibration
  double gap = 0.0;             // m, full play
  bool pushes_only = false;     // a contact, which never pulls

  bool rigid() const { return mass_ratio == 0.0 || !std::isfinite(frequency) || (pushes_only && gap == 0.0); }
};

/// A spring and damper between motor and load, with play. k = w^2 m1 m2 / (m1 + m2), c = 2 zeta w m1 m2 / (m1 + m2).
class Coupling {
 public:
  Coupling() = default;
  Coupling(const CouplingParameters& parameters, double mass)
      : exists_(!parameters.rigid()),
        pushes_only_(parameters.pushes_only),
        motor_mass_(mass * (exists_ ? 1.0 - parameters.mass_ratio : 1.0)),
        load_mass_(mass * parameters.mass_ratio),
        half_gap_(0.5 * parameters.gap) {
    if (!exists_) return;
    const double w = 2.0 * std::numbers::pi * parameters.frequency;
    const double reduced = motor_mass_ * parameters.mass_ratio;
    stiffness_ = w * w * reduced;
    damping_ = 2.0 * parameters.damping_ratio * w * reduced;
    rate_ = w * std::max(1.0, 2.0 * parameters.damping_ratio);
  }

  bool exists() const { return exists_; }
  double motor_mass() const { return motor_mass_; }
  double load_mass() const { return load_mass_; }
  double rate() const { return rate_; }  // 1/s, the fastest that it answers with

  /// A law that holds about one deflection and rate: force = stiffness (deflection - origin) + damping rate.
  struct Piece {
    double stiffness, damping, origin;
    bool operator==(const Piece&) const = default;
  };

  /// The piece of `force` at a deflection and rate.
  Piece piece(double deflection, double rate) const {
    const double origin = clamp(deflection, -half_gap_, half_gap_);
    const double spring = stiffness_ * (deflection - origin), damper = damping_ * rate;
    if (spring == 0.0) return {0.0, 0.0, 0.0};
    if (!pushes_only_ || std::abs(damper) <= std::abs(spring)) return {stiffness_, damping_, origin};
    return spring * damper > 0.0 ? Piece{2.0 * stiffness_, 0.0, origin} : Piece{0.0, 0.0, 0.0};
  }

  /// The force by which the load pulls the motor towards +x, V.
  ///
  /// Where it only pushes, the damper gives no more than the spring: the force then comes and goes with the
  /// contact without a jump, and a load that parts is not held back.
  double force(double deflection, double rate) const {
    const double strain = deflection - clamp(deflection, -half_gap_, half_gap_);
    const double spring = stiffness_ * strain, damper = damping_ * rate;
    return pushes_only_ ? spring + clamp(damper, -std::abs(spring), std::abs(spring)) : spring + damper;
  }

 private:
  bool exists_ = false, pushes_only_ = false;
  double motor_mass_ = 1.0, load_mass_ = 0.0, half_gap_ = 0.0;
  double stiffness_ = 0.0, damping_ = 0.0, rate_ = 0.0;
};

}  // namespace cogging
