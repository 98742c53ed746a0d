#pragma once
// What the binding files share: parameter structs and arrays, bound from what the core says of itself.

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "cogging/parameters.hpp"
#include "cogging/require.hpp"

namespace py = pybind11;

void bind_basis(py::module_& module);
void bind_reference(py::module_& module);
void bind_plant(py::module_& module);
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
  cogging::require(value >= -limit && value <= limit, name, "must be below 2^31", static_cast<double>(value));
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

/// Binds a read-only parameter struct: keyword constructor with the struct's own defaults and its validation,
/// properties with unit and meaning, FIELDS (name -> (unit, meaning)), replace, equality, repr and pickle.
template <class Struct>
py::class_<Struct> bind_parameters(py::module_& module, const std::string& class_name, std::string doc) {
  doc += "\n\nFields:\n";
  const Struct defaults{};
  cogging::for_each_field<Struct>([&](const auto& field) {
    doc += "    " + std::string(field.name);
    if (!field.unit.empty() && field.unit != "1") doc += " (" + std::string(field.unit) + ")";
    doc += ": " + std::string(field.meaning) + "\n";
  });
  doc += "\nRaises:\n    ValueError: a value breaks its rule; the message names field, rule and value.";
  const std::string part = module.attr("__name__").cast<std::string>().ends_with(".effects") ? "effects." : "";
  doc += "\n\nExample:\n    >>> one = cogging." + part + class_name + "()";
  doc += "\n    >>> one.replace(**one.to_dict()) == one\n    True";
  py::class_<Struct> bound(module, class_name.c_str(), doc.c_str());

  std::apply(
      [&]<class... Member>(const cogging::Field<Struct, Member>&... field) {
        bound.def(py::init([](typename Taken<Member>::type... values) {
                    Struct made{};
                    std::apply(
                        [&](const auto&... f) { ((made.*(f.member) = taken<Member>(f.name, std::move(values))), ...); },
                        Struct::fields());
                    made.validate();
                    return made;
                  }),
                  py::kw_only(), (py::arg(field.name.data()) = defaults.*(field.member))...);
      },
      Struct::fields());

  py::dict described;
  cogging::for_each_field<Struct>([&](const auto& field) {
    const auto member = field.member;
    std::string text(field.meaning);
    if (!field.unit.empty()) text += ", " + std::string(field.unit);
    bound.def_property_readonly(field.name.data(), [member](const Struct& self) { return self.*member; }, text.c_str());
    described[py::str(std::string(field.name))] = py::make_tuple(std::string(field.unit), std::string(field.meaning));
  });
  bound.attr("FIELDS") = described;

  const auto to_dict = [](const Struct& self) {
    py::dict values;
    cogging::for_each_field<Struct>(
        [&](const auto& field) { values[py::str(std::string(field.name))] = py::cast(self.*(field.member)); });
    return values;
  };
  const py::object type = bound;
  bound.def("to_dict", to_dict, "All fields by name.");
  bound.def(
      "replace",
      [to_dict](const py::object& self, const py::kwargs& changes) {
        py::dict values = to_dict(self.cast<const Struct&>());
        for (const auto& change : changes) values[change.first] = change.second;
        return py::type::of(self)(**values).template cast<Struct>();
      },
      "A copy with the given fields changed.");
  bound.def("__eq__", [to_dict](const Struct& self, const py::object& other) {
    return py::isinstance<Struct>(other) && to_dict(self).equal(to_dict(other.cast<const Struct&>()));
  });
  bound.def("__repr__", [to_dict, class_name](const Struct& self) {
    std::string text = class_name + "(";
    bool first = true;
    for (const auto& item : to_dict(self)) {
      text += (first ? "" : ", ") + std::string(py::str(item.first)) + "=" + std::string(py::repr(item.second));
      first = false;
    }
    return text + ")";
  });
  bound.def(
      py::pickle([to_dict](const Struct& self) { return to_dict(self); },
                 [](const py::dict& values) { return py::type::of<Struct>()(**values).template cast<Struct>(); }));
  return bound;
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

/// What every class of a list says of itself, and its place in it and in the module's part of that name.
template <class Listed>
void enlist(py::module_& module, const char* part, py::dict& list, py::object bound) {
  py::module_ names = module.attr(part);
  const std::string name = class_name(Listed::name);
  bound.attr("NAME") = std::string(Listed::name);
  names.attr(name.c_str()) = bound;
  names.attr("__all__").cast<py::list>().append(name);
  if constexpr (requires { typename Listed::Parameters; }) {
    const py::object parameters = bind_parameters_of<Listed>(module);
    bound.attr("PARAMETERS") = parameters;
    const std::string struct_name = parameters.attr("__name__").cast<std::string>();
    if (!py::hasattr(names, struct_name.c_str())) names.attr("__all__").cast<py::list>().append(struct_name);
    names.attr(struct_name.c_str()) = parameters;
  }
  list[py::str(std::string(Listed::name))] = bound;
}
