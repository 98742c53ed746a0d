#include "bindings.hpp"
#include "cogging/reference/point_to_point.hpp"
#include "cogging/reference/sampled.hpp"
#include "cogging/reference/sine.hpp"

using namespace cogging;

void bind_reference(py::module_& module) {
  py::class_<Reference>(module, "Reference", "A motion: position and its first two derivatives over time.")
      .def_property_readonly("end", &Reference::end,
                             "time at which the motion is over, s; infinite if it never is")
      .def(
          "sample",
          [](const Reference& reference, const Array& times) {
            const std::size_t n = static_cast<std::size_t>(times.size());
            std::vector<double> position(n), velocity(n), acceleration(n);
            for (std::size_t i = 0; i < n; ++i) {
              const ReferencePoint point = reference.at(times.data()[i]);
              position[i] = point.position;
              velocity[i] = point.velocity;
              acceleration[i] = point.acceleration;
            }
            return py::make_tuple(to_array(std::move(position)), to_array(std::move(velocity)),
                                  to_array(std::move(acceleration)));
          },
          py::arg("times"), "Position (m), velocity (m/s) and acceleration (m/s^2) at the times (n,), s.");

  bind_parameters<PointToPointParameters>(module, "PointToPointParameters",
                                          "Limits and rests of a PointToPoint.");
  py::class_<PointToPoint, Reference>(module, "PointToPoint", R"(Jerk-limited moves there and back.

start -> start + distance -> start, `repeats` times, resting `dwell` after each move. Each move is the fastest under
the limits on velocity, acceleration and jerk that starts and ends at rest with zero acceleration.)")
      .def(py::init<const PointToPointParameters&>(), py::arg("parameters"))
      .def_property_readonly("parameters", &PointToPoint::parameters)
      .def_property_readonly("move_time", &PointToPoint::move_time, "duration of one move, s")
      .def_property_readonly("period", &PointToPoint::period, "one move there and back with both rests, s");

  bind_parameters<SineParameters>(module, "SineParameters", "Centre, amplitude and frequency of a Sine.");
  py::class_<Sine, Reference>(
      module, "Sine",
      "x_d(t) = center + amplitude sin(2 pi frequency t). It starts at speed: the axis does not.")
      .def(py::init<const SineParameters&>(), py::arg("parameters"))
      .def_property_readonly("parameters", &Sine::parameters);

  py::class_<Sampled, Reference>(module, "Sampled", R"(A motion given by its samples.

time (s), position (m) and, where known, velocity (m/s) and acceleration (m/s^2), all (n,). A missing derivative is
differentiated from the one before it. Between samples cubic, the acceleration linear; outside at rest.

Raises:
    ValueError: fewer than three samples, time not strictly increasing, lengths that differ, a NaN.)")
      .def(py::init([](const Array& time, const Array& position, const std::optional<Array>& velocity,
                       const std::optional<Array>& acceleration) {
             return Sampled(to_vector(time), to_vector(position),
                            velocity ? to_vector(*velocity) : std::vector<double>{},
                            acceleration ? to_vector(*acceleration) : std::vector<double>{});
           }),
           py::arg("time"), py::arg("position"), py::arg("velocity") = py::none(),
           py::arg("acceleration") = py::none());
}
