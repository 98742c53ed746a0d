#pragma once
// The axis of one run, which the Python module and the units of FMI both move: compiled once, in instantiated.cpp.

#include "cogging/plant/amplifier.hpp"
#include "cogging/plant/axis.hpp"

extern template class cogging::Axis<double>;
extern template class cogging::Amplifier<double>;
