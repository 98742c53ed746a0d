#include <array>

#include "bindings.hpp"
#include "cogging/plant/effects/list.hpp"
#include "gil.hpp"

using namespace cogging;

namespace {

constexpr std::array<const char*, 3> places{"position", "velocity", "time"};

// A Python function of what it takes by name: of places (0 position, 1 velocity, 2 time), then of its parameters.
class PythonLaw final : public OwnLaw {
 public:
  PythonLaw(std::string label, py::object function, std::vector<std::size_t> taken, const py::dict& values)
      : label_(std::move(label)), function_(std::move(function)), taken_(std::move(taken)) {
    py::list names, fixed;
    for (const std::size_t place : taken_) names.append(places.at(place));
    for (const auto& [name, value] : values) names.append(name), fixed.append(value);
    names_.emplace(py::tuple(names));
    values_.emplace(py::tuple(fixed));
  }

  bool serial() const override { return true; }

  double at(double position, double velocity, double time) const override {
    const std::array<double, 3> place{position, velocity, time};
    const GilTaken taken;
    return guarded([&] { return place_of(position, velocity, time); },
                   [&] {
                     std::array<py::object, 3> numbers;
                     for (std::size_t i = 0; i < taken_.size(); ++i) numbers[i] = py::float_(place[taken_[i]]);
                     const double value = PyFloat_AsDouble(call(numbers).ptr());
                     if (value == -1.0 && PyErr_Occurred()) throw py::error_already_set();
                     return value;
                   });
  }

  void along(const Course& course, std::span<double> values) const override {
    const std::array<std::span<const double>, 3> columns{course.position, course.velocity, course.time};
    const GilTaken taken;
    const std::string count = format(values.size());
    guarded([&] { return " along arrays of " + count; },
            [&] {
              std::array<py::object, 3> arrays;
              for (std::size_t i = 0; i < taken_.size(); ++i) {
                const auto column = columns[taken_[i]];
                arrays[i] = py::array_t<double>(static_cast<py::ssize_t>(column.size()), column.data());
              }
              const py::array result = py::array::ensure(call(arrays));
              if (!result || std::string_view("fiub").find(result.dtype().kind()) == std::string_view::npos)
                throw py::type_error("it must return real numbers");
              const bool one = result.ndim() == 0;
              if (!one && !(result.ndim() == 1 && result.shape(0) == static_cast<py::ssize_t>(values.size())))
                throw py::value_error("it must return an array of that length, got shape " +
                                      std::string(py::str(result.attr("shape"))));
              const auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>(result);
              for (std::size_t k = 0; k < values.size(); ++k) values[k] = numbers.data()[one ? 0 : k];
              return 0.0;
            });
  }

 private:
  py::object call(const std::array<py::object, 3>& first) const {
    const auto& fixed = values_->object();
    std::vector<PyObject*> arguments;
    arguments.reserve(taken_.size() + py::len(fixed));
    for (std::size_t i = 0; i < taken_.size(); ++i) arguments.push_back(first[i].ptr());
    for (Py_ssize_t i = 0; i < PyTuple_GET_SIZE(fixed.ptr()); ++i)
      arguments.push_back(PyTuple_GET_ITEM(fixed.ptr(), i));
    PyObject *function = function_.object().ptr(), *names = names_->object().ptr();
    PyObject* result = or_wait_for_ever([&] { return PyObject_Vectorcall(function, arguments.data(), 0, names); });
    if (result == nullptr) throw py::error_already_set();
    return py::reinterpret_steal<py::object>(result);
  }

  // What the function raises, with whose it is and where; interruptions pass as they are.
  template <class Where, class Work>
  double guarded(const Where& where, const Work& work) const {
    try {
      return work();
    } catch (py::error_already_set& error) {
      if (!error.matches(PyExc_Exception)) throw;
      raise(error, where());
    } catch (py::builtin_exception& error) {
      error.set_error();
      py::error_already_set raised;
      raise(raised, where());
    }
  }

  [[noreturn]] void raise(py::error_already_set& error, const std::string& where) const {
    const std::string kind = py::str(error.type().attr("__name__")), text = py::str(error.value());
    py::raise_from(error, PyExc_RuntimeError, (label_ + ": raised " + kind + " (" + text + ")" + where).c_str());
    throw py::error_already_set();
  }

  std::string label_;
  Kept function_;
  std::vector<std::size_t> taken_;
  std::optional<Kept> names_, values_;
};

using Compiled = double (*)(void*, const double*);

template <std::size_t... i>
double call_with(void* address, const double* arguments, std::index_sequence<i...>) {
  using Function = double (*)(decltype(static_cast<void>(i), 0.0)...);
  return reinterpret_cast<Function>(address)(arguments[i]...);
}

template <std::size_t... count>
constexpr auto callers(std::index_sequence<count...>) {
  return std::array<Compiled, sizeof...(count)>{[](void* address, const double* arguments) {
    return call_with(address, arguments, std::make_index_sequence<count>());
  }...};
}

constexpr std::size_t arguments_max = 24;

// A compiled function of doubles: of the places, then of its parameters. No lock is taken.
class CompiledLaw final : public OwnLaw {
 public:
  CompiledLaw(std::uintptr_t address, std::vector<std::size_t> taken, const std::vector<double>& values,
              py::object owner)
      : address_(reinterpret_cast<void*>(address)), taken_(std::move(taken)), owner_(std::move(owner)) {
    require(address != 0, "function", "must have an address, got", 0);
    const std::size_t count = taken_.size() + values.size();
    require(count <= arguments_max, "function", "must take at most 24 numbers", count);
    std::copy(values.begin(), values.end(), arguments_.begin() + static_cast<std::ptrdiff_t>(taken_.size()));
    call_ = callers(std::make_index_sequence<arguments_max + 1>())[count];
  }

  double at(double position, double velocity, double time) const override {
    const std::array<double, 3> place{position, velocity, time};
    std::array<double, arguments_max> arguments = arguments_;
    for (std::size_t i = 0; i < taken_.size(); ++i) arguments[i] = place[taken_[i]];
    return call_(address_, arguments.data());
  }

 private:
  void* address_;
  std::vector<std::size_t> taken_;
  Kept owner_;  // of the code
  std::array<double, arguments_max> arguments_{};
  Compiled call_;
};

Hook hook_of(std::string_view name) {
  for (const Hook hook : {Hook::force, Hook::friction_level, Hook::command_gain, Hook::reading_error})
    if (name == to_string(hook)) return hook;
  refuse("hook", "must be force, friction_level, command_gain or reading_error", name);
}

}  // namespace

void bind_own_effect(py::module_& module) {
  py::class_<OwnLaw, std::shared_ptr<OwnLaw>>(module, "OwnLaw", "One law of an effect of the user's own.");
  py::class_<PythonLaw, OwnLaw, std::shared_ptr<PythonLaw>>(module, "PythonLaw", "A law that is a Python function.")
      .def(py::init<std::string, py::object, std::vector<std::size_t>, const py::dict&>(), py::arg("label"),
           py::arg("function"), py::arg("taken"), py::arg("values"));
  py::class_<CompiledLaw, OwnLaw, std::shared_ptr<CompiledLaw>>(module, "CompiledLaw",
                                                                "A law that is a compiled function of doubles.")
      .def(py::init<std::uintptr_t, std::vector<std::size_t>, const std::vector<double>&, py::object>(),
           py::arg("address"), py::arg("taken"), py::arg("values"), py::arg("owner"));
  py::class_<Custom<>>(module, "OwnLaws", "The laws of an effect of the user's own: what `Custom` hands to a plant.")
      .def(py::init([](std::string name, const std::map<std::string, std::shared_ptr<OwnLaw>>& laws,
                       double length_scale, double velocity_scale, double time_scale, py::object origin) {
             Custom<> made;
             made.label = std::move(name);
             for (const auto& [hook, law] : laws) made.laws[static_cast<std::size_t>(hook_of(hook))] = law;
             made.length_scale = length_scale;
             made.velocity_scale = velocity_scale;
             made.time_scale = time_scale;
             made.origin = std::make_shared<const Kept>(std::move(origin));
             made.validate();
             return made;
           }),
           py::arg("name"), py::arg("laws"), py::kw_only(), py::arg("length_scale"), py::arg("velocity_scale"),
           py::arg("time_scale"), py::arg("origin"))
      .def(
          "values_along",
          [](const Custom<>& self, const std::string& hook, const Array& position, const Array& velocity,
             const Array& time) {
            require(velocity.size() == position.size() && time.size() == position.size(), "position",
                    "must be as long as velocity and time", position.size());
            return to_array(self.along(hook_of(hook), {view(position), view(velocity), view(time)}));
          },
          py::arg("hook"), py::arg("position"), py::arg("velocity"), py::arg("time"),
          "One law along arrays (n,) of m, m/s and s.")
      .def(
          "value_at",
          [](const Custom<>& self, const std::string& hook, double position, double velocity, double time) {
            return self.value(hook_of(hook), position, velocity, time);
          },
          py::arg("hook"), py::arg("position"), py::arg("velocity"), py::arg("time"),
          "One law at one moment, as a run asks it.");
}

py::object original_of(const Effect<>& effect) {
  if (const auto* own = std::get_if<Custom<>>(&effect)) return static_cast<const Kept*>(own->origin.get())->object()();
  return py::cast(effect);
}
