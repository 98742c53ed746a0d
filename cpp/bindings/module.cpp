#include "bindings.hpp"
#include "cogging/require.hpp"

PYBIND11_MODULE(_core, module) {
  module.doc() = "The core of cogging: cogging model, references, plant, controllers and simulation, in C++.";
  py::register_exception<cogging::DivergedError>(module, "DivergedError", PyExc_RuntimeError);
  bind_basis(module);
  bind_reference(module);
  bind_plant(module);
  bind_control(module);
  bind_simulation(module);
  bind_prediction(module);
  bind_estimation(module);
  bind_table(module);
}
