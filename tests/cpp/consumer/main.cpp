// What a first program of a user may be: one controller, one command.

#include <cstdio>

#include "cogging/control/pid.hpp"

int main() {
  cogging::Pid<> pid({.sample_rate = 1000.0, .kp = 9600.0, .ki = 1e5, .kd = 48.0});
  std::printf("%.17g\n", pid.command({0.1, 0.0, 0.0}, 0.09));
}
