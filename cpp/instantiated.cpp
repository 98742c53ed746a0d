#include "instantiated.hpp"

template class cogging::Axis<double>;
template class cogging::Amplifier<double>;
