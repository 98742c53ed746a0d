#include "instantiated.hpp"

template class cogging::Axis<double>;
template class cogging::Amplifier<double>;
template void cogging::validate_effects(const std::vector<cogging::Effect<double>>&);
