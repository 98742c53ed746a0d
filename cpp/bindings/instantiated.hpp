#pragma once
// What many files of the module need of the core and one of them compiles: instantiated.cpp.

#include "cogging/control/list.hpp"
#include "cogging/plant/amplifier.hpp"
#include "cogging/plant/axis.hpp"

extern template class cogging::Axis<double>;
extern template class cogging::Amplifier<double>;
