#pragma once
// What a run leaves behind.

#include <vector>

namespace cogging {

/// Columns of a run, one entry a sample. The true position and velocity are the plant's own, not the
/// encoder's.
template <class Scalar = double>
struct Log {
  std::vector<double> time;                    // s
  std::vector<Scalar> position;                // m, encoder reading
  std::vector<Scalar> command;                 // V, applied from `time` on
  std::vector<double> reference;               // m
  std::vector<double> reference_velocity;      // m/s
  std::vector<double> reference_acceleration;  // m/s^2
  std::vector<Scalar> true_position;           // m
  std::vector<Scalar> true_velocity;           // m/s
  std::vector<Scalar> estimates;               // the controller's, one row a sample; empty unless asked for
  int estimate_count = 0;
};

}  // namespace cogging
