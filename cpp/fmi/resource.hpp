#pragma once
// The numbers of a unit, as the exporter wrote them among its resources.

#include <cstdint>
#include <map>
#include <string>

#include "axis_unit.hpp"

namespace cogging::fmi {

/// Where a parameter of the plant stands.
struct Place {
  std::string section;  // axis, encoder, noise, or the number of an effect
  std::string field;
};

struct Resource {
  std::string token;  // of the description that belongs to it
  Plant<> plant;
  Start start;
  std::map<std::uint32_t, Place> parameters;  // by value reference
};

/// Reads the file: a line an item, its name first; a number is the 16 digits of its bits, so that no locale and no
/// rounding touch it; what stands behind # is for people.
///
/// Raises std::runtime_error where it cannot be read, std::invalid_argument where it breaks a rule.
Resource read_resource(const std::string& path);

/// A parameter of the plant; null where there is none.
double* find_parameter(Plant<>& plant, const Place& place);

}  // namespace cogging::fmi
