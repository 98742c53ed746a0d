#pragma once
// The numbers of a unit, as the exporter wrote them among its resources.

#include <array>
#include <bit>
#include <charconv>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "axis_unit.hpp"

namespace cogging::fmi {

/// Where a parameter stands.
struct Place {
  std::string section;  // start, axis, encoder, noise, or the number of an effect
  std::string field;
};

struct Machine {
  Plant<> plant;
  Start start;
};

struct Resource : Machine {
  std::string token;                          // of the description that belongs to it
  std::map<std::uint32_t, Place> parameters;  // by value reference
};

/// Calls visit(struct) for the struct of a section.
template <class Visitor>
void visit_section(Machine& machine, const std::string& section, const Visitor& visit) {
  if (section == "start") return visit(machine.start);
  if (section == "axis") return visit(machine.plant.axis);
  if (section == "encoder") return visit(machine.plant.encoder);
  if (section == "noise") return visit(machine.plant.noise);
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(section.data(), section.data() + section.size(), number);
  if (error != std::errc() || number >= machine.plant.effects.size())
    throw std::runtime_error("no item or section " + section);
  std::visit(
      [&]<class E>(E& law) {
        if constexpr (requires { E::fields(); }) visit(law);
      },
      machine.plant.effects[number]);
}

/// A parameter; null where there is none.
inline double* find_parameter(Machine& machine, const Place& place) {
  double* found = nullptr;
  visit_section(machine, place.section, [&]<class Struct>(Struct& parameters) {
    for_each_field<Struct>([&](const auto& field) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(parameters.*(field.member))>, double>)
        if (field.name == place.field) found = &(parameters.*(field.member));
    });
  });
  return found;
}

namespace detail {

using Words = std::istringstream;

template <class Number>
bool read(Words& words, Number& value) {
  std::conditional_t<std::is_integral_v<Number>, Number, std::uint64_t> whole{};
  std::string word;
  if (!(words >> word)) return false;
  const char* const last = word.data() + word.size();
  const auto [end, error] = std::from_chars(word.data(), last, whole, std::is_integral_v<Number> ? 10 : 16);
  value = std::bit_cast<Number>(whole);
  return error == std::errc() && end == last;
}
template <class Value>
bool read(Words& words, std::vector<Value>& values) {
  values.clear();
  while (words >> std::ws, !words.eof())
    if (!read(words, values.emplace_back())) return false;
  return true;
}
template <class Value, std::size_t count>
bool read(Words& words, std::array<Value, count>& values) {
  for (Value& value : values)
    if (!read(words, value)) return false;
  return true;
}

template <class Value>
Value next(Words& words) {
  Value value{};
  if (!read(words, value)) throw std::runtime_error("no number where one must be");
  return value;
}

template <class... E>
Effect<> effect_named(const std::string& name, const std::variant<E...>*) {
  std::optional<Effect<>> found;
  const auto try_one = [&]<class One>() {
    if constexpr (requires { One::fields(); })
      if (One::name == name) found = One{};
  };
  (try_one.template operator()<E>(), ...);
  if (!found) throw std::runtime_error("no effect " + name);
  return *found;
}

/// Takes an item: of the cogging the knots first, then the terms, then the amplitudes.
inline void take_item(Resource& resource, SplineHarmonics& basis, const std::string& item, Words& words) {
  std::string name;
  if (item == "token") {
    words >> resource.token;
  } else if (item == "effect") {
    words >> name;
    resource.plant.effects.push_back(effect_named(name, static_cast<const Effect<>*>(nullptr)));
  } else if (item == "parameter") {
    Place& place = resource.parameters[next<std::uint32_t>(words)];
    words >> place.section >> place.field;
  } else if (item == "cogging") {
    const int order = next<int>(words), points = next<int>(words);
    const double origin = next<double>(words), knots = next<double>(words), pitch = next<double>(words);
    const BSpline spline(order, origin, knots, points);
    basis = pitch > 0.0 ? SplineHarmonics::of_harmonics(pitch, next<std::vector<int>>(words), spline)
                        : SplineHarmonics::of_periods(next<std::vector<double>>(words), spline);
  } else if (item == "cogging_coefficients") {
    resource.plant.cogging = CoggingModel<>(basis, next<std::vector<double>>(words));
  } else {
    bool found = false;
    words >> name;
    visit_section(resource, item, [&]<class Struct>(Struct& parameters) {
      for_each_field<Struct>([&](const auto& field) {
        if constexpr (!std::is_same_v<std::remove_cvref_t<decltype(parameters.*(field.member))>, std::string>)
          if (field.name == name) found = read(words, parameters.*(field.member));
      });
    });
    if (!found) throw std::runtime_error("no field " + name + ", or no value of it");
  }
}

}  // namespace detail

/// Reads the file: a line an item, its name first; a number is the 16 digits of its bits, so that no locale and no
/// rounding touch it; what stands behind # is for people.
///
/// Raises std::runtime_error where it cannot be read.
inline Resource read_resource(const std::string& path) {
  std::ifstream file(path);
  std::string line, item;
  if (!std::getline(file, line) || line != "cogging_axis 2")
    throw std::runtime_error(path + ": must begin with the line \"cogging_axis 2\"");
  Resource resource;
  SplineHarmonics basis;
  for (int number = 2; std::getline(file, line); ++number) {
    detail::Words words(line.substr(0, line.find('#')));
    if (!(words >> item)) continue;
    try {
      detail::take_item(resource, basis, item, words);
    } catch (const std::exception& error) {
      throw std::runtime_error(path + ": line " + std::to_string(number) + ": " + error.what());
    }
  }
  for (const auto& [reference, place] : resource.parameters)
    if (find_parameter(resource, place) == nullptr)
      throw std::runtime_error(path + ": no parameter " + place.section + " " + place.field);
  return resource;
}

}  // namespace cogging::fmi
