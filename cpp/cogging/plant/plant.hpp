#pragma once
// A whole machine: axis, its effects, encoder and noise. The truth; what a controller believes stands
// elsewhere.

#include "cogging/plant/axis.hpp"
#include "cogging/plant/encoder.hpp"
#include "cogging/plant/noise.hpp"

namespace cogging {

template <class Scalar = double>
struct Plant {
  AxisParameters<Scalar> axis;
  CoggingModel<Scalar> cogging;
  std::vector<Effect<Scalar>> effects;
  EncoderParameters encoder;
  NoiseParameters noise;
};

}  // namespace cogging
