#pragma once
// What stands in for the machine. To run a real one, write a class with the same two functions, of your encoder and
// your analogue output, and name it in real_time_loop.cpp; nothing else there knows of the machine.

#include "cogging/plant/plant.hpp"

class SimulatedAxis {
 public:
  SimulatedAxis(const cogging::Plant<>& plant, double position)
      : axis_(plant.axis, plant.cogging), encoder_(plant.encoder), state_{position, 0.0} {}

  /// The encoder's reading (m) at a time (s): the axis has moved under the command that was held until then.
  double read(double time) noexcept {
    if (time > time_) axis_.advance(state_, {command_, 0.0}, time_, time - time_);
    time_ = time;
    return cogging::read_encoder(encoder_, state_.position, 0.0);
  }

  /// Holds a command (V) from now on.
  void write(double command) noexcept { command_ = command; }

 private:
  cogging::Axis<> axis_;
  cogging::EncoderParameters encoder_;
  cogging::AxisState<double> state_;
  double time_ = 0.0, command_ = 0.0;
};
