#pragma once
// What an effect may take from the plant that it stands in.

#include <array>
#include <limits>

#include "cogging/basis/b_spline.hpp"

namespace cogging {

using Range = std::array<double, 2>;

struct PlantContext {
  Range travel = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};  // m
  bool has_knots = false;  // there is a cogging model
  BSpline knots;           // of its amplitudes; a constant where they are constant, with the pitch all the same
};

}  // namespace cogging
