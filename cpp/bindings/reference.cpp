#include "bindings.hpp"
#include "cogging/reference/filtered.hpp"
#include "cogging/reference/point_to_point.hpp"
#include "cogging/reference/sampled.hpp"
#include "cogging/reference/sine.hpp"
#include "without_gil.hpp"

using namespace cogging;

namespace {

// Left out and empty are not the same: an empty column is one of a wrong length.
std::vector<double> optional_column(const std::optional<Array>& column, const char* name, const Array& time) {
  if (!column) return {};
  require(column->size() > 0, name, "must be as long as time (" + format(double(time.size())) + ")", 0.0);
  return to_vector(*column);
}

}  // namespace

void bind_reference(py::module_& module) {
  py::class_<Reference>(module, "Reference", "A motion: position and its first two derivatives over time.")
      .def_property_readonly("end", &Reference::end, "time at which the motion is over, s; infinite if it never is")
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

  bind_parameters<PointToPointParameters>(module, "PointToPointParameters", "Limits and rests of a PointToPoint.");
  py::class_<PointToPoint, Reference>(module, "PointToPoint", R"(Jerk-limited moves there and back.

start -> start + distance -> start, `repeats` times, resting `dwell` after each move. Each move is the fastest under
the limits on velocity, acceleration and jerk that starts and ends at rest with zero acceleration.)")
      .def(py::init<const PointToPointParameters&>(), py::arg("parameters"))
      .def_property_readonly("parameters", &PointToPoint::parameters)
      .def_property_readonly("move_time", &PointToPoint::move_time, "duration of one move, s")
      .def_property_readonly("period", &PointToPoint::period, "one move there and back with both rests, s");

  bind_parameters<SineParameters>(module, "SineParameters", "Centre, amplitude and frequency of a Sine.");
  py::class_<Sine, Reference>(
      module, "Sine", "x_d(t) = center + amplitude sin(2 pi frequency t). It starts at speed: the axis does not.")
      .def(py::init<const SineParameters&>(), py::arg("parameters"))
      .def_property_readonly("parameters", &Sine::parameters);

  bind_parameters<FilteredSineParameters>(module, "FilteredSineParameters",
                                          "Sine and generator of a FilteredSine (Xu and Yao 2001, eq. 58).");
  py::class_<FilteredSine, Reference>(module, "FilteredSine", R"(A sine that starts from rest (Xu and Yao 2001, eq. 58).

q_d'' + beta_1 q_d' + beta_2 q_d = q_r'' + beta_1 q_r' + beta_2 q_r, q_r = center + amplitude sin(omega t), from rest at
the centre. Solved exactly at every time; the acceleration starts at beta_1 amplitude omega.)")
      .def(py::init<const FilteredSineParameters&>(), py::arg("parameters"))
      .def_property_readonly("parameters", &FilteredSine::parameters);

  py::class_<Sampled, Reference>(module, "Sampled", R"(A motion given by its samples.

time (s), position (m) and, where known, velocity (m/s) and acceleration (m/s^2), all (n,). A missing derivative is
differentiated from the one before it. Between samples cubic, the acceleration linear; outside at rest.

Raises:
    ValueError: fewer than three samples, time not strictly increasing, lengths that differ, a NaN.)")
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
            std::map<std::string, std::vector<double>> columns;
            without_gil([&](StopRequest* request) {
              StopCheck stop(request);
              for (std::size_t i = 0; i < motion.size(); ++i) {
                stop.row();
                const ReferencePoint point = motion.sample(i);
                columns["time"].push_back(motion.time(i));
                columns["reference"].push_back(point.position);
                columns["reference_velocity"].push_back(point.velocity);
                columns["reference_acceleration"].push_back(point.acceleration);
              }
            });
            std::map<std::string, py::array_t<double>> arrays;
            for (auto& [name, values] : columns) arrays[name] = to_array(std::move(values));
            return arrays;
          },
          "Its samples and their derivatives by the names of a log's columns, (n,) each.");
}
