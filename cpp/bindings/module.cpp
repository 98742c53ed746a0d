#include "bindings.hpp"
#include "cogging/require.hpp"

namespace {

// pybind11 lends raw memory to an object whose __init__ has not run (made by __new__ alone, or by a subclass that skips
// it) as soon as it is used. This stands in the place of that loan, in every class and for every use.
void* refuse_uninitialised(std::size_t) {
  throw py::type_error("the object must be initialised before it is used: its class' __init__ has not run");
}

void refuse_uninitialised_objects(const py::module_& module) {
  for (const auto& [name, value] : py::dict(module.attr("__dict__"))) {
    if (!PyType_Check(value.ptr())) continue;
    if (auto* type = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr())))
      type->operator_new = refuse_uninitialised;
  }
}

void tell_of_memory(std::exception_ptr thrown) {
  constexpr const char* text = "more memory was asked for than there is: fewer rows, points or runs must be enough";
  try {
    std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    py::set_error(PyExc_MemoryError, text);
  } catch (const std::length_error&) {
    py::set_error(PyExc_MemoryError, text);
  }
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  module.doc() = "The core of cogging: cogging model, references, plant, controllers and simulation, in C++.";
  py::register_exception<cogging::DivergedError>(module, "DivergedError", PyExc_RuntimeError);
  py::register_local_exception_translator(tell_of_memory);
  bind_basis(module);
  bind_reference(module);
  bind_plant(module);
  bind_control(module);
  bind_simulation(module);
  bind_estimation(module);
  bind_table(module);
  refuse_uninitialised_objects(module);
  refuse_uninitialised_objects(module.attr("effects"));
}
