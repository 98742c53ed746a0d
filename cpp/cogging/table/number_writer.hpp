#pragma once
// Columns of numbers as separated text, every number to its last bit.

#include <charconv>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "cogging/interruption.hpp"

namespace cogging {

/// Rows `first` to `end` (without) of columns of one length, a line each, separated by commas.
inline std::string format_rows(const std::vector<std::span<const double>>& columns, std::size_t first, std::size_t end,
                               StopRequest* request = nullptr) {
  std::string text;
  text.reserve((end - first) * columns.size() * 20);
  const auto append = [&](double value) {
    char buffer[40];
#if defined(__cpp_lib_to_chars)
    text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
#else
    for (int digits : {15, 16, 17}) {  // the fewest that read back as the same number
      std::snprintf(buffer, sizeof buffer, "%.*g", digits, value);
      if (std::strtod(buffer, nullptr) == value) break;
    }
    text += buffer;
#endif
  };
  StopCheck stop(request);
  for (std::size_t row = first; row < end; ++row) {
    stop.row();
    for (std::size_t column = 0; column < columns.size(); ++column) {
      append(columns[column][row]);
      text += column + 1 < columns.size() ? ',' : '\n';
    }
  }
  return text;
}

}  // namespace cogging
