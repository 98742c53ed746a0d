#pragma once
// Every motion that a reference file may name: one line each.

#include <variant>

#include "cogging/reference/filtered.hpp"
#include "cogging/reference/point_to_point.hpp"
#include "cogging/reference/sampled.hpp"
#include "cogging/reference/sine.hpp"

namespace cogging {

using AnyReference = std::variant<PointToPoint,  // jerk-limited moves there and back
                                  Sine,          // about a centre, at speed from the start
                                  FilteredSine,  // about a centre, from rest
                                  Sampled        // given by its samples
                                  >;

}  // namespace cogging
