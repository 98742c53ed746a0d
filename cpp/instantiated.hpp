#pragma once
// The axis of one run, which the Python module and the units of FMI both move, and the rules of its effects: compiled
// once, in instantiated.cpp.

#include "cogging/plant/amplifier.hpp"
#include "cogging/plant/axis.hpp"

extern template class cogging::Axis<double>;
extern template class cogging::Amplifier<double>;
extern template void cogging::validate_effects(const std::vector<cogging::Effect<double>>&);
