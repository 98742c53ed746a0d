#pragma once
// What the binding files share: parameter structs and arrays, bound from what the core says of itself.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <variant>

#include "cogging/parameters.hpp"
#include "cogging/require.hpp"

namespace py = pybind11;

void bind_basis(py::module_& module);
void bind_reference(py::module_& module);
void bind_plant(py::module_& module);
void bind_own_effect(py::module_& module);
void bind_control(py::module_& module);
void bind_own_controllers(py::module_& module);
void bind_simulation(py::module_& module);
void bind_batch(py::module_& module);
void bind_estimation(py::module_& module);
void bind_table(py::module_& module);

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// The name of a class by that in files: constant_force -> ConstantForce.
inline std::string class_name(std::string_view name) {
  std::string result;
  bool start = true;
  for (char letter : name) {
    if (letter == '_') {
      start = true;
      continue;
    }
    result += start ? static_cast<char>(letter - 'a' + 'A') : letter;
    start = false;
  }
  return result;
}

/// Calls visit<T>() for each alternative of a variant, in order: how lists of effects, controllers, motions are read.
template <class Variant>
struct Alternatives;
template <class... T>
struct Alternatives<std::variant<T...>> {
  template <class Visitor>
  static void for_each(Visitor&& visit) {
    (visit.template operator()<T>(), ...);
  }
};

/// A numpy array that takes over the vector's memory.
inline py::array_t<double> to_array(std::vector<double>&& values, std::vector<py::ssize_t> shape = {}) {
  if (shape.empty()) shape = {static_cast<py::ssize_t>(values.size())};
  auto* owned = new std::vector<double>(std::move(values));
  py::capsule owner(owned, [](void* memory) { delete static_cast<std::vector<double>*>(memory); });
  return py::array_t<double>(shape, owned->data(), owner);
}

inline std::vector<double> to_vector(const Array& array) {
  return {array.data(), array.data() + array.size()};
}

/// Empty where there is none.
inline std::vector<double> to_vector(const std::optional<Array>& array) {
  return array ? to_vector(*array) : std::vector<double>();
}

inline std::span<const double> view(const Array& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

/// What a constructor takes for a member: counts in 64 bits, so that one that is too large is told by name.
template <class Member>
struct Taken {
  using type = Member;
};
template <>
struct Taken<int> {
  using type = std::int64_t;
};
template <>
struct Taken<std::vector<int>> {
  using type = std::vector<std::int64_t>;
};

inline int counted(std::string_view name, std::int64_t value) {
  constexpr std::int64_t limit = std::numeric_limits<int>::max();
  cogging::require(value >= -limit && value <= limit, name, "must be below 2^31", value);
  return static_cast<int>(value);
}

template <class Member>
Member taken(std::string_view name, typename Taken<Member>::type&& value) {
  if constexpr (std::is_same_v<Member, int>) {
    return counted(name, value);
  } else if constexpr (std::is_same_v<Member, std::vector<int>>) {
    std::vector<int> counts;
    for (const std::int64_t one : value) counts.push_back(counted(name, one));
    return counts;
  } else {
    return std::move(value);
  }
}

/// A field of a parameter struct, whatever its type: how it is read and written where it lies in the struct.
struct BoundField {
  std::string name, unit, meaning;
  cogging::Trait trait;
  std::ptrdiff_t offset;
  py::object usual;         // its default
  std::string given, kept;  // its type as an argument and as a property
  py::object (*get)(const void* member);
  void (*set)(void* member, const std::string& name, const py::handle& value);
};

/// A parameter struct, whatever its type.
struct BoundStruct {
  std::vector<BoundField> fields;
  void* (*make)(const std::function<void(void*)>& fill);  // with its defaults but for what is filled in, and valid
};

/// The doc of its class.
std::string doc_of(const std::string& doc, const BoundStruct& bound);
/// Keyword constructor with the struct's own defaults and its validation, properties with unit and meaning, FIELDS
/// (name -> (unit, meaning)), to_dict and replace.
void bind_fields(const py::object& type, const BoundStruct& bound);

template <class Member>
BoundField bound_field(const std::string_view (&texts)[3], const cogging::Trait& trait, const void* defaults,
                       const Member& usual) {
  // What pybind11 says of a function from one to the other: (arg0: given) -> kept
  const py::cpp_function function([](const typename Taken<Member>::type&) { return Member{}; });
  const auto types = function.attr("__doc__").cast<std::string>();
  const std::size_t begin = types.find(": ") + 2, end = types.find(") -> "), next = end + 5;
  return {std::string(texts[0]),
          std::string(texts[1]),
          std::string(texts[2]),
          trait,
          reinterpret_cast<const char*>(&usual) - static_cast<const char*>(defaults),
          py::cast(usual),
          types.substr(begin, end - begin),
          types.substr(next, types.find('\n') - next),
          [](const void* member) { return py::cast(*static_cast<const Member*>(member)); },
          [](void* member, const std::string& name, const py::handle& value) {
            if constexpr (std::is_same_v<Member, bool>)  // pybind11 makes one of any number
              if (!py::detail::make_caster<bool>{}.load(value, false)) throw py::cast_error();
            *static_cast<Member*>(member) = taken<Member>(name, py::cast<typename Taken<Member>::type>(value));
          }};
}

template <class Struct>
BoundStruct bound_struct() {
  BoundStruct bound{{}, [](const std::function<void(void*)>& fill) -> void* {
                      auto made = std::make_unique<Struct>();
                      fill(made.get());
                      cogging::validated(*made);
                      return made.release();
                    }};
  const Struct defaults{};
  cogging::for_each_field<Struct>([&](const auto& field) {
    bound.fields.push_back(
        bound_field({field.name, field.unit, field.meaning}, field.trait, &defaults, defaults.*(field.member)));
  });
  return bound;
}

/// Binds a read-only parameter struct by the list of its fields.
template <class Struct>
py::class_<Struct> bind_parameters(py::module_& module, const std::string& class_name, const std::string& doc,
                                   const BoundStruct& bound = bound_struct<Struct>()) {
  py::class_<Struct> type(module, class_name.c_str(), doc_of(doc, bound).c_str());
  bind_fields(type, bound);
  return type;
}

/// Binds the parameter struct of a class that stands in a list, unless it is bound already, and gives its type. It is
/// called as it says itself, or after the class: PidParameters.
template <class Listed>
py::object bind_parameters_of(py::module_& module) {
  using Struct = typename Listed::Parameters;
  std::string name = class_name(Listed::name) + "Parameters";
  if constexpr (requires { Struct::name; }) name = class_name(Struct::name) + "Parameters";
  if (py::hasattr(module, name.c_str())) return module.attr(name.c_str());
  std::string doc = "Parameters of " + class_name(Listed::name) + ".";
  if constexpr (requires { Struct::description; }) doc = Struct::description;
  return bind_parameters<Struct>(module, name, doc);
}

/// What every class of a list says of itself, its place in it and in the module's part of that name, and its
/// parameters, if it has any.
void enlist(py::module_& module, const char* part, py::dict& list, std::string_view name, const py::object& bound,
            const py::object& parameters = py::none());
