#pragma once
// What the tests in C++ check with: one line for each failure, and a status for main() to return.

#include <cstdio>
#include <string>

namespace check {

inline int checks = 0, failures = 0;

inline void holds(bool condition, const std::string& what) {
  ++checks;
  if (condition) return;
  ++failures;
  std::printf("FAILED: %s\n", what.c_str());
}

inline int status() {
  std::printf("%d checks, %d failures\n", checks, failures);
  return checks > 0 && failures == 0 ? 0 : 1;
}

}  // namespace check
