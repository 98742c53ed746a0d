#include "own_controller.hpp"

#include <cmath>

#include "real_number.hpp"

using namespace cogging;

namespace {

constexpr const char* what_is_one =
    "an object with sample_rate and command(reference, reading), and maybe update(applied), reset() and command_limit "
    "(see cogging.Controller)";

PyObject* controller_error = nullptr;     // the class; never freed, as all classes of the module
PyTypeObject* reference_point = nullptr;  // cogging.ReferencePoint, a named tuple, once it is needed
PyObject *command_name, *update_name;     // interned

std::string class_of(const py::handle& object) {
  return py::type::handle_of(object).attr("__qualname__").cast<std::string>();
}

double stated_number(const py::object& object, const char* field, const char* rule, bool (*holds)(double),
                     const py::object& value) {
  const std::optional<double> number = real_number(value.ptr());
  if (!number || !holds(*number)) refuse("controller", class_of(object) + "." + field + " " + rule, shown(value));
  return *number;
}

void require_callable(const py::object& object, const char* name, const py::object& method, const char* arguments,
                      int count) {
  const std::string said = "controller: " + class_of(object) + "." + name;
  if (!PyCallable_Check(method.ptr()))
    throw py::type_error(said + " must be a method: " + name + arguments + ", got " + shown(method));
  py::object signature;
  try {
    signature = called(py::module_::import("inspect").attr("signature"), py::make_tuple(method));
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
    return;  // compiled code need not have one
  }
  try {
    called(signature.attr("bind"), py::tuple(py::make_tuple(py::none()) * py::int_(count)));
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError)) throw;
    throw py::type_error(said + " must take " + arguments + ", got " + name + shown(signature, false));
  }
}

void set_controller_error(const std::string& message, std::size_t row, double time, const py::object& cause = {}) {
  const py::object error = py::reinterpret_borrow<py::object>(controller_error)(message);
  error.attr("row") = row;
  error.attr("time") = time;
  if (cause) PyException_SetCause(error.ptr(), py::object(cause).release().ptr());
  PyErr_SetObject(controller_error, error.ptr());
}

void tell_of_controller(std::exception_ptr thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const ControllerError& error) {
    set_controller_error(error.what(), error.row, error.time);
  }
}

PyObject* make_point(const ReferencePoint& reference) {
  PyObject* point = reference_point->tp_alloc(reference_point, 3);
  if (point == nullptr) return nullptr;
  const double values[3] = {reference.position, reference.velocity, reference.acceleration};
  for (Py_ssize_t i = 0; i < 3; ++i) {
    PyObject* number = PyFloat_FromDouble(values[i]);
    if (number == nullptr) {
      Py_DECREF(point);
      return nullptr;
    }
    PyTuple_SET_ITEM(point, i, number);
  }
  return point;
}

// A method of the first argument, before which there is room; null where it raises.
py::object called_method(PyObject* name, PyObject** arguments, std::size_t count) {
  return py::reinterpret_steal<py::object>(or_wait_for_ever(
      [&] { return PyObject_VectorcallMethod(name, arguments, count | PY_VECTORCALL_ARGUMENTS_OFFSET, nullptr); }));
}

void bind_controller_error(py::module_& module) {
  controller_error = py::exception<ControllerError>(module, "ControllerError", PyExc_RuntimeError).release().ptr();
  const py::handle kind(controller_error);
  kind.attr("__doc__") =
      "A controller of one's own raised, which is the cause of this, or gave a command that is no finite number.\n\n"
      "`row` of the run (from 0) and `time` (s) say when.";
  kind.attr("row") = 0;
  kind.attr("time") = 0.0;
  py::register_local_exception_translator(tell_of_controller);
}

// Of a function with the C ABI, as ctypes and numba's cfunc give it. It is called as the signature says, whatever it
// was compiled with: so what it says of itself must fit.
std::uintptr_t address_of(const py::object& function, const char* field, std::size_t arguments, bool gives) {
  const py::module_ ctypes = py::module_::import("ctypes");
  const py::object own = member(function, "ctypes");  // numba's has one of ctypes
  const py::object pointer = own.is_none() ? function : own;
  if (!py::isinstance(pointer, ctypes.attr("_CFuncPtr")))
    throw py::type_error(std::string(field) + ": must be a numba cfunc or a function pointer of ctypes, got " +
                         shown(function));
  const py::object given = pointer.attr("argtypes"), result = pointer.attr("restype");
  const py::object number = ctypes.attr("c_double");
  bool fits = gives ? result.is(number) : result.is_none();
  if (given.is_none()) {
    fits = fits || result.is(ctypes.attr("c_int"));  // nothing is said, neither of the result
  } else {
    const py::tuple types(given);
    fits = fits && types.size() == arguments && py::object(types[arguments - 1]).is(number);
  }
  if (!fits)
    throw py::type_error(
        std::string(field) + ": must be " + (gives ? "double " : "void ") + field +
        (gives ? "(double*, const double*, const double*, double)" : "(double*, const double*, double)") +
        ", got argtypes " + shown(given) + ", restype " + shown(result));
  return ctypes.attr("cast")(pointer, ctypes.attr("c_void_p")).attr("value").cast<std::uintptr_t>();
}

CompiledController make_compiled(const py::object& command, const py::object& update, double sample_rate,
                                 const std::vector<double>& state, const std::vector<double>& parameters,
                                 double command_limit) {
  CompiledFunctions functions;
  functions.command = reinterpret_cast<CompiledFunctions::Command>(address_of(command, "command", 4, true));
  if (!update.is_none())
    functions.update = reinterpret_cast<CompiledFunctions::Update>(address_of(update, "update", 3, false));
  functions.owner = std::make_shared<const Kept>(py::make_tuple(command, update));
  return {functions, {sample_rate, state, parameters, command_limit}};
}

void bind_compiled(py::module_& module) {
  py::class_<CompiledController> bound(module, "CompiledController", R"(A controller of compiled functions.

    double command(double* state, const double* parameters, const double* reference, double reading);
    void update(double* state, const double* parameters, double applied);

`reference` holds position, velocity and acceleration (m, m/s, m/s^2), `reading` is in m, commands in V. A run starts
from the state given here, has a state of its own, and calls the functions without Python's lock: in a batch on many
threads at once, so that what is not in their state must not be written. They must not raise.

Args:
    command, update: of numba, `@numba.cfunc(cogging.CompiledController.COMMAND)` and `.UPDATE`; or of ctypes, a
        function of a shared library. They are kept alive.
    sample_rate: Hz.
    state: V, m or whatever it means, (n,); with which a run begins.
    parameters: (p,), never written.
    command_limit: V, largest command; 0 = none.

Raises:
    TypeError: what is no compiled function, or says that its signature is another.
    ValueError: a number breaks its rule; the message names field, rule and value.)");
  bound.def(py::init(&make_compiled), py::arg("command"), py::kw_only(), py::arg("update") = py::none(),
            py::arg("sample_rate"), py::arg("state") = std::vector<double>{},
            py::arg("parameters") = std::vector<double>{}, py::arg("command_limit") = 0.0);
  bound.attr("COMMAND") = "float64(CPointer(float64), CPointer(float64), CPointer(float64), float64)";
  bound.attr("UPDATE") = "void(CPointer(float64), CPointer(float64), float64)";
  using C = CompiledController;
  bound.def_property_readonly("sample_rate", &C::sample_rate, "Hz")
      .def_property_readonly("command_limit", &C::command_limit, "V; 0 = none")
      .def_property_readonly(
          "parameters", [](const C& c) { return to_array(std::vector<double>(c.settings().parameters)); },
          "(p,): a copy")
      .def_property_readonly(
          "estimates",
          [](const C& c) { return to_array(std::vector<double>(c.estimates().begin(), c.estimates().end())); },
          "Its state now, (n,): a copy.")
      .def(
          "command",
          [](C& c, const std::array<Real, 3>& reference, Real reading) {
            return c.command({reference[0].value, reference[1].value, reference[2].value}, reading.value);
          },
          py::arg("reference"), py::arg("reading"),
          "The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).")
      .def(
          "update", [](C& c, Real applied) { c.update(applied.value); }, py::arg("applied"),
          "Ends the sample: the command (V) that was really applied.")
      .def("reset", &C::reset, "Back to the state with which a run begins.")
      .def(
          "copy", [](const C& c) { return c; }, "A controller in the same state.")
      .def("__copy__", [](const C& c) { return c; })
      .def(
          "__deepcopy__", [](const C& c, const py::dict&) { return c; }, py::arg("memo"))
      .def(
          "__eq__", [](const C& c, const C& other) { return c == other; }, py::is_operator())
      .def("__repr__", [](const C& c) {
        return "CompiledController(" + format(c.sample_rate()) + " Hz, state " + std::to_string(c.estimates().size()) +
               ", parameters " + std::to_string(c.settings().parameters.size()) + ")";
      });
}

}  // namespace

PythonController::PythonController(const py::object& object) : held_(std::make_shared<Held>(object)) {
  held_->name = class_of(object);
  const py::object rate = member(object, "sample_rate"), method = member(object, "command");
  if (rate.is_none() && method.is_none())
    throw py::type_error(std::string("controller: must be a controller of cogging or ") + what_is_one + ", got " +
                         shown(object));
  if (PyType_Check(object.ptr()))
    throw py::type_error("controller: must be an object, got the class " + shown(object) + ": call it to make one");
  for (const auto& [name, value] : {std::pair("sample_rate", rate), std::pair("command", method)})
    if (value.is_none())
      throw py::type_error("controller: " + held_->name + "." + name + " must be given, got nothing: a controller is " +
                           what_is_one);
  held_->sample_rate = stated_number(
      object, "sample_rate", "must be finite and above 0 (Hz)", [](double hz) { return std::isfinite(hz) && hz > 0.0; },
      rate);
  require_callable(object, "command", method, "(reference, reading)", 2);
  if (const py::object update = member(object, "update"); !update.is_none()) {
    require_callable(object, "update", update, "(applied)", 1);
    held_->has_update = true;
  }
  if (const py::object reset = member(object, "reset"); !reset.is_none())
    require_callable(object, "reset", reset, "()", 0);
  held_->command_limit = stated_number(
      object, "command_limit", "must be finite and at least 0 (V; 0 = none)",
      [](double limit) { return std::isfinite(limit) && limit >= 0.0; },
      py::hasattr(object, "command_limit") ? member(object, "command_limit") : py::object(py::float_(0.0)));
}

void PythonController::fail(const char* method) const {
  py::error_already_set raised;
  if (!raised.matches(PyExc_Exception)) throw raised;
  py::object cause = py::reinterpret_borrow<py::object>(raised.value());
  if (raised.trace()) PyException_SetTraceback(cause.ptr(), raised.trace().ptr());
  std::string text = class_of(cause);
  if (const std::string said = shown(cause, false); !said.empty()) text += ": " + said;
  try {
    end_run(held_->name, std::string(method) + " raised " + text, row_, time_);
  } catch (const ControllerError& error) {
    set_controller_error(error.what(), error.row, error.time, cause);
  }
  throw py::error_already_set();
}

std::span<const double> PythonController::estimates() const {
  py::object values;
  try {
    values = member(held_->object.object(), "estimates");
    if (values.is_none()) return {};
    const auto numbers = Array::ensure(values);
    if (!numbers) throw py::error_already_set();
    std::vector<double> now = to_vector(numbers);
    if (held_->has_estimates && now.size() != held_->estimates.size())
      end_run(held_->name,
              "estimates must keep their number, " + std::to_string(held_->estimates.size()) + ", got " +
                  std::to_string(now.size()),
              row_, time_);
    held_->estimates = std::move(now);
    held_->has_estimates = true;
  } catch (py::error_already_set& error) {
    error.restore();
    fail("estimates");
  }
  return held_->estimates;
}

double PythonController::command(const ReferencePoint& reference, double reading) {
  const py::object point = py::reinterpret_steal<py::object>(make_point(reference));
  const py::object number = py::reinterpret_steal<py::object>(PyFloat_FromDouble(reading));
  if (!point || !number) throw py::error_already_set();
  PyObject* arguments[] = {nullptr, held_->object.object().ptr(), point.ptr(), number.ptr()};
  const py::object given = called_method(command_name, arguments + 1, 3);
  if (!given) fail("command");
  const std::optional<double> command = real_number(given.ptr());
  if (!command || !std::isfinite(*command))
    end_run(held_->name, "command must give a finite number, got " + shown(given), row_, time_);
  return *command;
}

void PythonController::update(double applied) {
  if (!held_->has_update) return;
  const py::object number = py::reinterpret_steal<py::object>(PyFloat_FromDouble(applied));
  if (!number) throw py::error_already_set();
  PyObject* arguments[] = {nullptr, held_->object.object().ptr(), number.ptr()};
  const py::object done = called_method(update_name, arguments + 1, 2);
  if (!done) fail("update");
}

GivenController take_controller(const py::object& given) {
  std::optional<GivenController> taken;
  std::string classes;  // those whose parameters were given
  const auto take = [&]<class C>() {
    if (taken || !py::isinstance<C>(given)) return;
    if (py::type::handle_of(given).is(py::type::of<C>())) {
      taken = given.cast<const C&>();
      return;
    }
    const std::string kind = py::type::of<C>().attr("__name__").template cast<std::string>();
    throw py::type_error("controller: must not be of a subclass of " + kind +
                         ", whose own methods would not be called, got " + class_of(given) + ": give " + what_is_one +
                         ", which may hold a " + kind);
  };
  Alternatives<AnyController<>>::for_each([&]<class C>() {
    if (!py::isinstance<typename C::Parameters>(given)) return take.template operator()<C>();
    classes += (classes.empty() ? "" : " or ") + class_name(C::name);
    taken = C(given.cast<const typename C::Parameters&>());
  });
  if (classes.find(" or ") != std::string::npos)
    throw py::type_error("controller: must be " + classes + " with these parameters, got " + class_of(given) +
                         " alone, which both have");
  take.operator()<CompiledController>();
  if (taken) {
    if (auto* compiled = std::get_if<CompiledController>(&*taken)) compiled->reset();
    return *std::move(taken);
  }
  if (reference_point == nullptr)
    reference_point = reinterpret_cast<PyTypeObject*>(
        py::object(py::module_::import("cogging").attr("ReferencePoint")).release().ptr());
  const PythonController checked{given};
  py::object copy;
  try {
    copy = called(py::module_::import("copy").attr("deepcopy"), py::make_tuple(given));
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_Exception)) throw;
    throw py::type_error(
        "controller: must be such that copy.deepcopy copies it, since a run does not change what it is "
        "given, got " +
        class_of(given) + ", which raises " + shown(error.value(), true));
  }
  if (!member(copy, "reset").is_none()) called(copy.attr("reset"));
  return PythonController{copy};
}

void bind_own_controllers(py::module_& module) {
  command_name = PyUnicode_InternFromString("command");
  update_name = PyUnicode_InternFromString("update");
  bind_controller_error(module);
  bind_compiled(module);
}
