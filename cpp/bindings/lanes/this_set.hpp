#pragma once
// What is compiled once for each instruction set, with COGGING_SET its name and COGGING_LANES the size of a pack. No
// inline function of it has a name outside of its object (-fno-weak): another may run on a machine that lacks its
// instructions.

#include <cstddef>

#include "run_lanes.hpp"

namespace {

constexpr std::size_t count = COGGING_LANES;
using Scalar = cogging::Lanes<count>;

}  // namespace

#define COGGING_JOINED(a, b) a##b
#define COGGING_NAMED(a, b) COGGING_JOINED(a, b)
