#pragma once
// One number that Python gives: a float, an int, a scalar of numpy, an array without dimensions. Truth values and texts
// are none, though pybind11 and numpy make numbers of them.

#include <pybind11/pybind11.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

/// The first line of what Python says of an object, short enough for a message.
inline std::string shown(const pybind11::handle& object, bool quoted = true) {
  constexpr std::size_t longest = 200;
  std::string text;
  try {
    text = quoted ? std::string(pybind11::repr(object)) : std::string(pybind11::str(object));
  } catch (pybind11::error_already_set&) {
    text = std::string("an object of ") + Py_TYPE(object.ptr())->tp_name;
  }
  if (const std::size_t end = std::min(text.find('\n'), longest); end < text.size()) {
    text.resize(end);
    if (end == longest) text += " ...";
  }
  return text;
}

/// None where it has no such member; what a property raises is raised.
inline pybind11::object member(const pybind11::handle& object, const char* name) {
  if (PyObject* found = PyObject_GetAttrString(object.ptr(), name))
    return pybind11::reinterpret_steal<pybind11::object>(found);
  if (!PyErr_ExceptionMatches(PyExc_AttributeError)) throw pybind11::error_already_set();
  PyErr_Clear();
  return pybind11::none();
}

/// Whether something that is no float is one real number all the same.
inline bool is_real_scalar(PyObject* value) {
  if (PyBool_Check(value) || PyComplex_Check(value)) return false;
  const PyNumberMethods* methods = Py_TYPE(value)->tp_as_number;
  if (methods == nullptr || (methods->nb_float == nullptr && methods->nb_index == nullptr)) return false;
  const pybind11::handle object(value);
  const pybind11::object dimensions = member(object, "ndim");
  if (!dimensions.is_none() && !dimensions.equal(pybind11::int_(0))) return false;
  const pybind11::object kind = member(member(object, "dtype"), "kind");
  constexpr std::string_view none = "bcSUO";  // truth values, complex numbers, texts and objects
  return std::none_of(none.begin(), none.end(), [&](char one) { return kind.equal(pybind11::str(&one, 1)); });
}

inline std::optional<double> real_number(PyObject* value) {
  if (PyFloat_Check(value)) return PyFloat_AS_DOUBLE(value);
  if (!is_real_scalar(value)) return {};
  const double number = PyFloat_AsDouble(value);
  if (number != -1.0 || !PyErr_Occurred()) return number;
  if (!PyErr_ExceptionMatches(PyExc_Exception)) throw pybind11::error_already_set();
  PyErr_Clear();
  return {};
}

/// A number among the arguments of a controller's step. A loop calls those in every sample, where a look at the whole
/// call (module.cpp) would cost more than the call, so it is refused here.
struct Real {
  double value = 0.0;
};

template <>
struct pybind11::detail::type_caster<Real> {
  PYBIND11_TYPE_CASTER(Real, make_caster<double>::name);

  bool load(handle source, bool) {
    const std::optional<double> number = real_number(source.ptr());
    if (number) {
      value.value = *number;
      return true;
    }
    const bool text = PyUnicode_Check(source.ptr()) || PyBytes_Check(source.ptr());
    if (!text && PyObject_Length(source.ptr()) >= 0)
      return false;  // three numbers in one: another signature takes them
    PyErr_Clear();
    throw type_error("a controller's step must be given real numbers, got " + shown(source));
  }
};
