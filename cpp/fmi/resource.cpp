#include "resource.hpp"

#include <array>
#include <bit>
#include <charconv>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <type_traits>
#include <variant>
#include <vector>

namespace cogging::fmi {

namespace {

using Words = std::istringstream;

template <class Integer>
bool read_integer(Words& words, Integer& value, int base) {
  std::string word;
  if (!(words >> word)) return false;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value, base);
  return error == std::errc() && end == word.data() + word.size();
}
bool read(Words& words, double& value) {
  std::uint64_t bits = 0;
  if (!read_integer(words, bits, 16)) return false;
  value = std::bit_cast<double>(bits);
  return true;
}
bool read(Words& words, int& value) {
  return read_integer(words, value, 10);
}
template <class Value>
bool read(Words& words, std::vector<Value>& values) {
  values.clear();
  while (words >> std::ws, !words.eof()) {
    Value value{};
    if (!read(words, value)) return false;
    values.push_back(value);
  }
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

/// The field `name` of a struct takes what follows.
template <class Struct>
void set_field(Struct& parameters, Words& words) {
  std::string name;
  words >> name;
  bool found = false;
  for_each_field<Struct>([&](const auto& field) {
    if (field.name == name) found = read(words, parameters.*(field.member));
  });
  if (!found) throw std::runtime_error("no field " + name + ", or no value of it");
}

template <class E>
void add_if_named(const std::string& name, std::vector<Effect<>>& found) {
  if constexpr (requires { E::fields(); })
    if (E::name == name) found.push_back(E{});
}
template <class... E>
Effect<> effect_named(const std::string& name, const std::variant<E...>*) {
  std::vector<Effect<>> found;
  (add_if_named<E>(name, found), ...);
  if (found.empty()) throw std::runtime_error("no effect " + name);
  return found.front();
}

/// Calls visit(struct) for the struct of a section.
template <class Visitor>
void visit_section(Plant<>& plant, const std::string& section, const Visitor& visit) {
  if (section == "axis") return visit(plant.axis);
  if (section == "encoder") return visit(plant.encoder);
  if (section == "noise") return visit(plant.noise);
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(section.data(), section.data() + section.size(), number);
  if (error != std::errc() || number >= plant.effects.size()) throw std::runtime_error("no section " + section);
  std::visit(
      [&]<class E>(E& law) {
        if constexpr (requires { E::fields(); }) visit(law);
      },
      plant.effects[number]);
}

/// Reads the items, a line each.
class Reader {
 public:
  void take(const std::string& item, Words& words) {
    if (item == "token") {
      words >> resource.token;
    } else if (item == "sample_rate") {
      resource.start.sample_rate = next<double>(words);
      require_positive("sample_rate", resource.start.sample_rate);
    } else if (item == "steps_per_sample") {
      resource.start.steps_per_sample = next<int>(words);
    } else if (item == "initial_position") {
      resource.start.position = next<double>(words);
    } else if (item == "effect") {
      std::string name;
      words >> name;
      resource.plant.effects.push_back(effect_named(name, static_cast<const Effect<>*>(nullptr)));
    } else if (item == "parameter") {
      const auto reference = static_cast<std::uint32_t>(next<int>(words));
      Place& place = resource.parameters[reference];
      words >> place.section >> place.field;
    } else if (item.starts_with("cogging_")) {
      take_cogging(item, words);
    } else {
      visit_section(resource.plant, item, [&](auto& parameters) { set_field(parameters, words); });
    }
  }

  Resource resource;

 private:
  // The knots first, then the terms, then the amplitudes.
  void take_cogging(const std::string& item, Words& words) {
    if (item == "cogging_knots") {
      const int order = next<int>(words);
      const double origin = next<double>(words), pitch = next<double>(words);
      spline_ = BSpline(order, origin, pitch, next<int>(words));
    } else if (item == "cogging_harmonics") {
      const double pitch = next<double>(words);
      basis_ = SplineHarmonics::of_harmonics(pitch, next<std::vector<int>>(words), spline_);
    } else if (item == "cogging_periods") {
      basis_ = SplineHarmonics::of_periods(next<std::vector<double>>(words), spline_);
    } else if (item == "cogging_coefficients") {
      resource.plant.cogging = CoggingModel<>(basis_, next<std::vector<double>>(words));
    } else {
      throw std::runtime_error("no item " + item);
    }
  }

  BSpline spline_;
  SplineHarmonics basis_;
};

}  // namespace

Resource read_resource(const std::string& path) {
  std::ifstream file(path);
  std::string line, item;
  if (!std::getline(file, line) || line != "cogging_axis 1")
    throw std::runtime_error(path + ": must begin with the line \"cogging_axis 1\"");
  Reader reader;
  for (int number = 2; std::getline(file, line); ++number) {
    Words words(line.substr(0, line.find('#')));
    if (!(words >> item)) continue;
    try {
      reader.take(item, words);
    } catch (const std::exception& error) {
      throw std::runtime_error(path + ": line " + std::to_string(number) + ": " + error.what());
    }
  }
  for (const auto& [reference, place] : reader.resource.parameters)
    if (find_parameter(reader.resource.plant, place) == nullptr)
      throw std::runtime_error(path + ": no parameter " + place.section + " " + place.field);
  return std::move(reader.resource);
}

double* find_parameter(Plant<>& plant, const Place& place) {
  double* found = nullptr;
  visit_section(plant, place.section, [&]<class Struct>(Struct& parameters) {
    for_each_field<Struct>([&](const auto& field) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(parameters.*(field.member))>, double>)
        if (field.name == place.field) found = &(parameters.*(field.member));
    });
  });
  return found;
}

}  // namespace cogging::fmi
