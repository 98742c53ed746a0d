#pragma once
// A function that is known at places.

#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// Linear between two nodes, constant beyond the first and last; 0 without any.
template <class Scalar, class Place>
Scalar piecewise_linear(const std::vector<double>& nodes, const std::vector<double>& values, const Place& at) {
  if (nodes.empty()) return 0.0;
  Scalar value = values[0];
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    const Place share = (at - nodes[i - 1]) / (nodes[i] - nodes[i - 1]);
    value += (values[i] - values[i - 1]) * clamp(share, Place(0.0), Place(1.0));
  }
  return value;
}

/// Refuses nodes that do not increase, and values that are not as many; both are named as the user knows them.
inline void require_piecewise_linear(std::string_view nodes_name, const std::vector<double>& nodes,
                                     std::string_view values_name, const std::vector<double>& values) {
  for (std::size_t i = 1; i < nodes.size(); ++i)
    require(nodes[i] > nodes[i - 1], nodes_name, "must increase: above " + format(nodes[i - 1]), nodes[i]);
  require(nodes.size() == values.size(), values_name,
          "must have as many values as " + std::string(nodes_name) + " = " + format(nodes.size()), values.size());
}

}  // namespace cogging
