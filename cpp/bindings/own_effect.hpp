#pragma once
// Effects of the user's own, whose laws are functions that Python holds.

#include "bindings.hpp"
#include "cogging/plant/effects/list.hpp"

void bind_own_effect(py::module_& module);

/// An effect of a plant as Python knows it.
py::object original_of(const cogging::Effect<>& effect);
