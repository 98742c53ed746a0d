#include <algorithm>

#include "bindings.hpp"
#include "cogging/require.hpp"
#include "gil.hpp"

namespace {

// pybind11 lends raw memory to an object whose __init__ has not run (made by __new__ alone, or by a subclass that skips
// it) as soon as it is used. This stands in the place of that loan, in every class and for every use.
void* refuse_uninitialised(std::size_t) {
  throw py::type_error("the object must be initialised before it is used: its class' __init__ has not run");
}

void translate_memory_errors(std::exception_ptr thrown) {
  constexpr const char* text = "more memory was asked for than there is: fewer rows, points or runs must be enough";
  try {
    std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    py::set_error(PyExc_MemoryError, text);
  } catch (const std::length_error&) {
    py::set_error(PyExc_MemoryError, text);
  }
}

// True and False are no numbers, though Python and pybind11 take them for 1 and 0, and neither is a text of digits, of
// which numpy makes one. Whether an argument may hold such a thing: cogging.calls then looks at it and its signature.
bool may_hold_no_number(const py::handle& value, int depth = 4) {
  PyObject* object = value.ptr();
  if (PyFloat_CheckExact(object) || PyLong_CheckExact(object) || object == Py_None) return false;
  if (PyBool_Check(object) || PyUnicode_Check(object) || PyBytes_Check(object)) return true;
  if (PyList_Check(object) || PyTuple_Check(object)) {
    const auto list = py::reinterpret_borrow<py::sequence>(value);
    for (py::size_t i = 0; depth > 0 && i < list.size(); ++i)
      if (may_hold_no_number(list[i], depth - 1)) return true;
    return false;
  }
  if (py::isinstance<py::array>(value))
    return std::string_view("fiuc").find(py::reinterpret_borrow<py::array>(value).dtype().kind()) ==
           std::string_view::npos;
  if (py::detail::get_type_info(Py_TYPE(object))) return false;  // of the core
  return std::string_view(Py_TYPE(object)->tp_name).starts_with("numpy.bool") || py::hasattr(value, "__array__");
}

// The signature that help() shows names what a reader gives: pybind11 names all that can be made a number.
void name_plain_types(const py::module_& module) {
  constexpr std::pair<std::string_view, std::string_view> plain[] = {
      {"typing.SupportsFloat | typing.SupportsIndex", "float"},
      {"typing.SupportsInt | typing.SupportsIndex", "int"},
      {"typing.Annotated[numpy.typing.ArrayLike, numpy.float64]", "numpy.typing.ArrayLike"}};
  const auto rename = [&](PyObject* function) {
    if (PyInstanceMethod_Check(function)) function = PyInstanceMethod_GET_FUNCTION(function);
    if (!PyCFunction_Check(function)) return;
    char* doc = const_cast<char*>(reinterpret_cast<PyCFunctionObject*>(function)->m_ml->ml_doc);  // pybind11's own copy
    std::string text = doc ? doc : "";
    for (const auto& [long_name, name] : plain)
      for (std::size_t at; (at = text.find(long_name)) != std::string::npos;) text.replace(at, long_name.size(), name);
    if (doc) std::copy_n(text.c_str(), text.size() + 1, doc);  // never longer
  };
  for (const auto& [name, value] : py::dict(module.attr("__dict__"))) {
    rename(value.ptr());
    if (PyType_Check(value.ptr()))
      for (const auto& [own, method] : py::dict(value.attr("__dict__"))) rename(method.ptr());
  }
}

// A call that no signature takes is answered by pybind11 in many lines of C++ types. It is answered in one instead, by
// cogging.calls, which reads the signature; every other error passes as it is.
template <class... Self>
py::cpp_function explained_in_one_line(const py::object& bound, const std::string& name, const Self&... self) {
  const py::str doc = bound.attr("__doc__");
  const std::string untaken = bound.attr("__name__").cast<std::string>() + "(): incompatible ";  // pybind11's words
  const auto call = [bound, doc, untaken](const py::args& given, const py::kwargs& named) -> py::object {
    py::object numbers;
    const auto no_number = [&](const py::object& word, const py::handle& value) {
      if (!may_hold_no_number(value)) return false;
      if (!numbers) numbers = called(py::module_::import("cogging.calls").attr("number_places"), py::make_tuple(doc));
      return numbers.contains(word);
    };
    bool any = false;
    for (std::size_t place = 0; place < given.size(); ++place) any = any || no_number(py::int_(place), given[place]);
    for (const auto& [word, value] : named) any = any || no_number(py::reinterpret_borrow<py::object>(word), value);
    if (any) {
      const py::object line =
          called(py::module_::import("cogging.calls").attr("explain_non_number"), py::make_tuple(doc, given, named));
      if (!line.is_none()) throw py::type_error(line.cast<std::string>());
    }
    try {
      return bound(*given, **named);
    } catch (py::error_already_set& error) {
      if (!error.matches(PyExc_TypeError)) throw;
      const auto text = py::str(error.value()).cast<std::string>();
      if (!text.starts_with(untaken)) throw;
      const auto line =
          called(py::module_::import("cogging.calls").attr("explain_mismatch"), py::make_tuple(doc, given, named))
              .cast<std::string>();
      throw py::type_error(line);
    }
  };
  py::options options;
  options.disable_function_signatures();  // the text begins with that of the function behind
  return py::cpp_function(call, py::name(name.c_str()), doc.cast<std::string>().c_str(), self...);
}

// Makes a module's functions, and its classes and their methods, refuse in one line what they cannot use.
void answer_in_one_line(const py::module_& module) {
  for (const auto& [name, value] : py::dict(module.attr("__dict__"))) {
    const py::object bound = py::reinterpret_borrow<py::object>(value);
    if (PyType_Check(bound.ptr())) {
      auto* const type = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(bound.ptr()));
      if (!type) continue;
      type->operator_new = refuse_uninitialised;
      const py::object init = bound.attr("__dict__").attr("get")("__init__");
      if (!init.is_none() && !init.attr("__doc__").is_none())
        py::setattr(bound, "__init__", explained_in_one_line(init, "construct", py::is_method(bound)));
      for (const auto& [own, method] : py::dict(bound.attr("__dict__"))) {
        const auto called = own.cast<std::string>();
        if (called.starts_with("_") || !PyInstanceMethod_Check(method.ptr())) continue;
        const py::object inner = py::reinterpret_borrow<py::object>(method);
        const py::object doc = inner.attr("__doc__");
        if (!doc.is_none() &&
            doc.cast<std::string>().find("Array") != std::string::npos)  // numpy makes those of anything
          py::setattr(bound, called.c_str(), explained_in_one_line(inner, called, py::is_method(bound)));
      }
    } else if (PyCFunction_Check(bound.ptr())) {
      py::setattr(module, py::str(name), explained_in_one_line(bound, py::str(name), py::scope(module)));
    }
  }
}

}  // namespace

PYBIND11_MODULE(core_of_main, module) {
  module.doc() = "The core of cogging: cogging model, references, plant, controllers and simulation, in C++.";
  py::register_exception<cogging::DivergedError>(module, "DivergedError", PyExc_RuntimeError);
  py::register_local_exception_translator(translate_memory_errors);
  bind_basis(module);
  bind_reference(module);
  bind_plant(module);
  bind_control(module);
  bind_own_controllers(module);
  bind_simulation(module);
  bind_batch(module);
  bind_estimation(module);
  bind_table(module);
  for (const py::module_& part : {module, py::module_(module.attr("effects"))}) {
    name_plain_types(part);
    answer_in_one_line(part);
  }
}

// pybind11 waits for ever in any other interpreter of the process than the first, before it asks the module anything.
extern "C" PYBIND11_EXPORT PyObject* PyInit__core() {
  if (PyInterpreterState_Get() == PyInterpreterState_Main()) return PyInit_core_of_main();
  PyErr_SetString(PyExc_ImportError, "cogging: must be imported by the main interpreter of the process, got another");
  return nullptr;
}
