#include "bindings.hpp"
#include "cogging/estimation/replay_controller.hpp"
#include "cogging/memory.hpp"
#include "cogging/simulation/closed_loop.hpp"
#include "cogging/simulation/performance.hpp"
#include "gil.hpp"
#include "instantiated.hpp"
#include "own_controller.hpp"

using namespace cogging;

namespace {

// Every column becomes a numpy array without copying.
std::map<std::string, py::array_t<double>> to_columns(Log<>&& log) {
  const auto rows = static_cast<py::ssize_t>(log.time.size());
  std::map<std::string, py::array_t<double>> columns;
  columns["time"] = to_array(std::move(log.time));
  columns["position"] = to_array(std::move(log.position));
  columns["command"] = to_array(std::move(log.command));
  columns["reference"] = to_array(std::move(log.reference));
  columns["reference_velocity"] = to_array(std::move(log.reference_velocity));
  columns["reference_acceleration"] = to_array(std::move(log.reference_acceleration));
  columns["true_position"] = to_array(std::move(log.true_position));
  columns["true_velocity"] = to_array(std::move(log.true_velocity));
  if (log.estimate_count > 0) columns["estimates"] = to_array(std::move(log.estimates), {rows, log.estimate_count});
  return columns;
}

}  // namespace

void bind_simulation(py::module_& module) {
  PythonSignals::main_thread =
      py::module_::import("threading").attr("main_thread")().attr("ident").cast<unsigned long>();
  py::class_<StopFlag>(module, "StopFlag", R"(What ends the work of the core in other threads than Python's main one.

Python tells its main thread alone of Ctrl-C. A thread that heeds a flag raises KeyboardInterrupt out of the core within
milliseconds after another thread has set it.)")
      .def(py::init<>())
      .def("set", &StopFlag::set, "End what the threads that heed this flag do in the core, now and later.")
      .def("heed", &StopFlag::heed, "Heed this flag, and no other, in the calling thread.");

  module.def("memory_left", &memory_left, R"(Bytes that this process may still take.

What the machine has left, no more than control groups and the limit of addresses allow; where the system does not say,
half of its memory, or 8 GiB.)");
  module.def(
      "require_memory",
      [](const std::string& name, double bytes, const std::string& what, const std::string& value) {
        require_memory(name, bytes, what, value);
      },
      py::arg("name"), py::arg("bytes"), py::arg("what"), py::arg("value"),
      "Refuse what would not fit into memory, before any of it is taken: over 64 MB, more than 0.8 of memory_left.");

  module.def(
      "closed_loop",
      [](const Plant<>& plant, const py::object& controller, const Reference& reference, double duration,
         std::uint64_t seed, int steps_per_sample, bool record_estimates, std::optional<double> initial_position,
         double initial_velocity, const std::optional<Array>& added_command) {
        const std::vector<double> added = to_vector(added_command);
        require_finite("added_command", added);
        RunOptions options{duration,         seed,  steps_per_sample, record_estimates, initial_position,
                           initial_velocity, added, nullptr};
        const GivenController given = take_controller(controller);
        return to_columns(without_gil([&](StopRequest* request) {
          return close_with(given, request, [&](const auto& c, StopRequest* stop) {
            options.stop = stop;
            return closed_loop<double>(plant, c, reference, options);
          });
        }));
      },
      py::arg("plant"), py::arg("controller"), py::arg("reference"), py::kw_only(), py::arg("duration") = 0.0,
      py::arg("seed") = 0, py::arg("steps_per_sample") = 1, py::arg("record_estimates") = false,
      py::arg("initial_position") = py::none(), py::arg("initial_velocity") = 0.0,
      py::arg("added_command") = py::none(),
      R"(One closed-loop run, of cogging.closed_loop: columns by name, arrays (n,); `estimates` is (n, p).

A pure function: the controller given is copied, the noise comes from `seed`, the same call gives the same bits. Between
samples the command is held and the axis integrated by Runge-Kutta steps of fourth order: `steps_per_sample`, or as many
more as keep what they err by below 1e-6 of the motion.)");

  module.def(
      "replay_controller",
      [](const py::object& controller, const Array& time, const Array& reference,
         const std::optional<Array>& reference_velocity, const std::optional<Array>& reference_acceleration,
         const Array& position, const std::optional<Array>& applied) {
        const std::vector<double> times = to_vector(time), positions = to_vector(reference),
                                  velocities = to_vector(reference_velocity),
                                  accelerations = to_vector(reference_acceleration), readings = to_vector(position),
                                  told = to_vector(applied);
        const GivenController given = take_controller(controller);
        return to_array(without_gil([&](StopRequest* request) {
          return close_with(given, request, [&](const auto& c, StopRequest* stop) {
            return replay_controller(c, times, positions, velocities, accelerations, readings, told, stop);
          });
        }));
      },
      py::arg("controller"), py::kw_only(), py::arg("time"), py::arg("reference"),
      py::arg("reference_velocity") = py::none(), py::arg("reference_acceleration") = py::none(), py::arg("position"),
      py::arg("applied") = py::none(),
      R"(The commands (V, (n,)) that a controller gives for the references and readings of a log.

Columns (n,): s, m, m/s, m/s^2, m, V. A missing derivative of the reference is differentiated. The controller is copied,
called once a row whatever the times are, and told that its own command, cut at its limit, was applied, or what
`applied` holds; one that looks ahead sees the reference interpolated between rows, at rest after the last.

Raises:
    ValueError: fewer than three rows, time not strictly increasing, lengths that differ, a NaN.

Example:
    >>> pid = cogging.Pid(cogging.PidParameters(kp=1000.0))
    >>> time, at_rest = 0.01 * np.arange(3), np.zeros(3)
    >>> cogging.replay_controller(pid, time=time, reference=at_rest, position=[0.0, 1e-6, -2e-6]).tolist()
    [0.0, -0.001, 0.002])");

  py::class_<Performance> bound(module, "Performance", R"(The indexes of one run: what `performance` gives.

Example:
    >>> print(f"{cogging.performance(log).command_rms:.3f} V")
    0.421 V)");
  for_each_field<Performance>([&](const auto& field) {
    const std::string unit = field.unit.empty() ? "" : ", " + std::string(field.unit);
    bound.def_readonly(field.name.data(), field.member, (std::string(field.meaning) + unit).c_str());
  });
  bound.def(py::pickle(
      [](const Performance& p) {
        std::vector<double> kept;
        for_each_field<Performance>([&](const auto& field) { kept.push_back(p.*(field.member)); });
        return kept;
      },
      [](const std::vector<double>& kept) {
        Performance made{};
        auto next = kept.begin();
        for_each_field<Performance>([&](const auto& field) { made.*(field.member) = *next++; });
        return made;
      }));
  module.def(
      "performance",
      [](const Array& time, const Array& error, const Array& command, double start, double stop, double final_window) {
        return performance(view(time), view(error), view(command), {start, stop, final_window});
      },
      py::arg("time"), py::arg("error"), py::arg("command"), py::kw_only(), py::arg("start") = -infinity,
      py::arg("stop") = infinity, py::arg("final_window") = 2.0,
      "The indexes over the rows with start <= time < stop (s) of arrays (n,) in s, m, V: cogging.performance.");
}
