#include "bindings.hpp"
#include "cogging/reference/list.hpp"
#include "gil.hpp"

using namespace cogging;

namespace {

// Left out and empty are not the same: an empty column is one of a wrong length.
std::vector<double> optional_column(const std::optional<Array>& column, const char* name, const Array& time) {
  require(!column || column->size() > 0, name, "must be as long as time (" + format(time.size()) + ")", 0.0);
  return to_vector(column);
}

// What one motion has and no other.
template <class R>
void bind_special(py::class_<R, Reference>&) {}

void bind_special(py::class_<PointToPoint, Reference>& bound) {
  bound.def_property_readonly("move_time", &PointToPoint::move_time, "duration of one move, s");
}

void bind_special(py::class_<Sampled, Reference>& bound) {
  bound
      .def(py::init([](const Array& time, const Array& position, const std::optional<Array>& velocity,
                       const std::optional<Array>& acceleration) {
             const std::vector<double> times = to_vector(time), positions = to_vector(position),
                                       velocities = optional_column(velocity, "velocity", time),
                                       accelerations = optional_column(acceleration, "acceleration", time);
             return without_gil([&](StopRequest*) { return Sampled(times, positions, velocities, accelerations); });
           }),
           py::arg("time"), py::arg("position"), py::arg("velocity") = py::none(), py::arg("acceleration") = py::none())
      .def_property_readonly(
          "samples",
          [](const Sampled& motion) {
            std::map<std::string, py::array_t<double>> arrays;
            arrays["time"] = to_array(std::vector(motion.times()));
            arrays["reference"] = to_array(std::vector(motion.positions()));
            arrays["reference_velocity"] = to_array(std::vector(motion.velocities()));
            arrays["reference_acceleration"] = to_array(std::vector(motion.accelerations()));
            return arrays;
          },
          "Its samples and their derivatives by the names of a log's columns, (n,) each.");
}

template <class R>
void bind_motion(py::module_& module, py::dict& references) {
  py::object parameters = py::none();
  if constexpr (requires { typename R::Parameters; }) parameters = bind_parameters_of<R>(module);
  const std::string name = class_name(R::name);
  std::string doc(R::description);
  if constexpr (requires { typename R::Parameters; })
    doc += "\n\nExample:\n    >>> motion = cogging." + name + "(cogging." + name +
           ".PARAMETERS())\n    >>> position, velocity, acceleration = motion.sample([0.0, 0.1])";
  if constexpr (std::is_same_v<R, Sampled>)
    doc +=
        "\n\nExample:\n    >>> motion = cogging.Sampled(time=[0.0, 0.1, 0.2], position=[0.0, 0.01, 0.02])"
        "\n    >>> position, velocity, acceleration = motion.sample([0.05, 0.1])";
  py::class_<R, Reference> bound(module, name.c_str(), doc.c_str());
  if constexpr (requires { typename R::Parameters; })
    bound.def(py::init<const typename R::Parameters&>(), py::arg("parameters"))
        .def_property_readonly("parameters", &R::parameters);
  bind_special(bound);
  enlist(module, "references", references, R::name, bound, parameters);
}

}  // namespace

void bind_reference(py::module_& module) {
  py::class_<Reference>(module, "Reference", "A motion: position and its first two derivatives over time.")
      .def_property_readonly("end", &Reference::end, "time at which the motion is over, s; infinite if it never is")
      .def_property_readonly("period", &Reference::period,
                             "after which it repeats itself, s, rests included; infinite if it never does")
      .def(
          "sample",
          [](const Reference& reference, const Array& times) {
            const std::size_t n = static_cast<std::size_t>(times.size());
            std::vector<double> position(n), velocity(n), acceleration(n);
            without_gil([&](StopRequest* request) {
              StopCheck stop(request);
              for (std::size_t i = 0; i < n; ++i) {
                stop.row();
                const ReferencePoint point = reference.at(times.data()[i]);
                position[i] = point.position;
                velocity[i] = point.velocity;
                acceleration[i] = point.acceleration;
              }
            });
            return py::make_tuple(to_array(std::move(position)), to_array(std::move(velocity)),
                                  to_array(std::move(acceleration)));
          },
          py::arg("times"), "Position (m), velocity (m/s) and acceleration (m/s^2) at the times (n,), s.");

  py::module_ names =
      module.def_submodule("references", "Every motion that a reference file may name, with its parameters.");
  names.attr("__all__") = py::list();
  py::dict references;
  Alternatives<AnyReference>::for_each([&]<class R>() { bind_motion<R>(module, references); });
  module.attr("REFERENCES") = references;
}
