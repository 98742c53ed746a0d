#include "cogging/simulation/prediction.hpp"

#include "bindings.hpp"
#include "cogging/simulation/added_effect.hpp"
#include "cogging/simulation/batch.hpp"
#include "cogging/simulation/expected_prediction.hpp"
#include "cogging/simulation/observer_loop.hpp"
#include "without_gil.hpp"

using namespace cogging;

namespace {

std::span<const double> view(const Array& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

Recording recording_of(const Array& time, const Array& position, const Array& command) {
  require(position.size() == time.size(), "position", "must be as long as time", double(position.size()));
  require(command.size() == time.size(), "command", "must be as long as time", double(command.size()));
  require(time.size() >= 2, "time", "must have at least 2 rows", double(time.size()));
  return {view(time), view(position), view(command)};
}

// A log's columns, held for many predictions along it.
class Predictor {
 public:
  Predictor(Array time, Array position, Array command, double bandwidth, double gap, double initial_velocity,
            int steps_per_sample)
      : time_(std::move(time)),
        position_(std::move(position)),
        command_(std::move(command)),
        log_(recording_of(time_, position_, command_)),
        options_{bandwidth, gap, initial_velocity, steps_per_sample, nullptr} {
    require_positive("bandwidth", bandwidth);
    require_positive("gap", gap);
    require_finite("initial_velocity", initial_velocity);
    require(steps_per_sample >= 1 && steps_per_sample <= 1000, "steps_per_sample", "must be from 1 to 1000",
            double(steps_per_sample));
    for (const auto& [name, column] :
         {std::pair("time", log_.time), std::pair("position", log_.position), std::pair("command", log_.command)})
      for (const double value : column) require_finite(name, value);
    for (std::size_t k = 1; k < log_.time.size(); ++k)
      require(log_.time[k] > log_.time[k - 1], "time", "must be strictly increasing", log_.time[k]);
  }

  const Recording& log() const { return log_; }
  PredictionOptions options(StopRequest* stop) const {
    PredictionOptions options = options_;
    options.stop = stop;
    return options;
  }

 private:
  Array time_, position_, command_;
  Recording log_;
  PredictionOptions options_;
};

// As many threads as plants can use: where one holds a lock that it needs, others would wait for it.
unsigned useful(const std::vector<Plant<>>& plants, unsigned threads) {
  return std::any_of(plants.begin(), plants.end(), [](const Plant<>& one) { return is_serial(one.effects); }) ? 1
                                                                                                              : threads;
}

// Rows of a table, one a job (made by row(i, stop request)), filled on threads without the GIL.
template <class Row>
py::array_t<double> table(std::size_t count, std::size_t rows, unsigned threads, const Row& row) {
  std::vector<double> values(count * rows);
  without_gil([&](StopRequest* stop) {
    run_batch(count, threads, stop, [&](std::size_t i) {
      const std::vector<double> made = row(i, stop);
      std::copy(made.begin(), made.end(), values.begin() + static_cast<std::ptrdiff_t>(i * rows));
    });
  });
  return to_array(std::move(values), {static_cast<py::ssize_t>(count), static_cast<py::ssize_t>(rows)});
}

}  // namespace

void bind_prediction(py::module_& module) {
  py::class_<Prediction>(module, "Prediction", "A prediction along a log, with its slopes: what `propagate` needs.")
      .def_property_readonly(
          "innovation", [](const Prediction& p) { return to_array(std::vector(p.innovation)); },
          "m, reading less what was foreseen")
      .def_property_readonly(
          "position", [](const Prediction& p) { return to_array(std::vector(p.position)); }, "m, corrected")
      .def_property_readonly(
          "velocity", [](const Prediction& p) { return to_array(std::vector(p.velocity)); }, "m/s, corrected")
      .def_property_readonly(
          "middle_position", [](const Prediction& p) { return to_array(std::vector(p.middle_position)); },
          "m, half-way to the next row")
      .def_property_readonly(
          "middle_velocity", [](const Prediction& p) { return to_array(std::vector(p.middle_velocity)); },
          "m/s, half-way to the next row")
      .def_property_readonly(
          "moving", [](const Prediction& p) { return to_array(std::vector(p.moving)); },
          "1, or 0 where the axis sticks");

  py::class_<Predictor>(module, "Predictor", R"(One step ahead along a log.

The plant is driven by the recorded command and held to the recorded position by an observer with both poles at
exp(-2 pi bandwidth Ts); the innovation (m) is what the model did not foresee. Of a load with play it is the mean over
gaps 0.7 to 1.3 of the one that is meant: when it strikes hangs on forces that no model has. Time steps may differ;
after one longer than `gap` (s) the observer starts anew.

Raises:
    ValueError: columns of different lengths, time that does not increase, a NaN or an infinity in one of them, a
        bandwidth that is not positive.)")
      .def(py::init<Array, Array, Array, double, double, double, int>(), py::arg("time"), py::arg("position"),
           py::arg("command"), py::kw_only(), py::arg("bandwidth") = 30.0, py::arg("gap") = 1e300,
           py::arg("initial_velocity") = 0.0, py::arg("steps_per_sample") = 1)
      .def(
          "predict",
          [](const Predictor& self, const Plant<>& plant) {
            return without_gil(
                [&](StopRequest* stop) { return expected_prediction(plant, self.log(), self.options(stop), true); });
          },
          py::arg("plant"), "The prediction along the log, with slopes.")
      .def(
          "innovations",
          [](const Predictor& self, const std::vector<Plant<>>& plants, unsigned threads) {
            threads = useful(plants, threads);
            return table(plants.size(), self.log().time.size(), threads, [&](std::size_t i, StopRequest* stop) {
              return expected_prediction(plants[i], self.log(), self.options(stop), false).innovation;
            });
          },
          py::arg("plants"), py::kw_only(), py::arg("threads") = 0,
          "Innovations (m) of many plants, (plants, n), on `threads` threads (0 = all cores).")
      .def(
          "net_force",
          [](const Predictor& self, const std::vector<Plant<>>& plants, const Array& middle_position,
             const Array& middle_velocity, unsigned threads) {
            threads = useful(plants, threads);
            require(middle_position.size() == py::ssize_t(self.log().time.size()), "middle_position",
                    "must be as long as the log", double(middle_position.size()));
            require(middle_velocity.size() == middle_position.size(), "middle_velocity", "must be as long as the log",
                    double(middle_velocity.size()));
            const auto x = view(middle_position), v = view(middle_velocity);
            return table(plants.size(), self.log().time.size(), threads, [&](std::size_t i, StopRequest* stop) {
              return net_force(plants[i], self.log(), x, v, stop);
            });
          },
          py::arg("plants"), py::arg("middle_position"), py::arg("middle_velocity"), py::kw_only(),
          py::arg("threads") = 0,
          "Command that acts plus all forces (V) along a motion given half-way between rows, (plants, n).")
      .def(
          "propagate",
          [](const Predictor& self, const Prediction& along, double mass, const Array& forces,
             const std::optional<Array>& reading_errors, unsigned threads) {
            const std::size_t rows = self.log().time.size();
            require(forces.ndim() == 2 && std::size_t(forces.shape(1)) == rows, "forces", "must be (p, n)",
                    double(forces.size()));
            require(!reading_errors || (reading_errors->ndim() == 2 && reading_errors->shape(0) == forces.shape(0) &&
                                        reading_errors->shape(1) == forces.shape(1)),
                    "reading_errors", "must have the shape of forces", 0.0);
            require_positive("mass", mass);
            const double* force = forces.data();
            const double* error = reading_errors ? reading_errors->data() : nullptr;
            const py::ssize_t count = forces.shape(0);
            std::vector<double> innovation = without_gil([&](StopRequest* stop) {
              const ObserverLoop loop(along, self.log(), self.options(stop));
              return pass_all(loop, mass, std::size_t(count), force, error, threads);
            });
            return to_array(std::move(innovation), {count, py::ssize_t(rows)});
          },
          py::arg("along"), py::arg("mass"), py::arg("forces"), py::arg("reading_errors") = py::none(), py::kw_only(),
          py::arg("threads") = 0,
          R"(What small forces (V, (p, n)) and errors of the reading (m, (p, n)) add to the innovations (m, (p, n)).)")
      .def_static(
          "is_addable", &is_addable, py::arg("plant"), py::arg("effect"),
          "Whether `added` can tell what an effect would add to a plant: no bristle, no error of the reading, no "
          "memory "
          "of its own beside a bristle or a load, and under friction no heavy load that rings long or has play.")
      .def(
          "added",
          [](const Predictor& self, const Prediction& along, const Plant<>& plant, const std::vector<Effect<>>& effects,
             const std::vector<double>& sizes, unsigned threads) {
            const py::ssize_t rows = py::ssize_t(self.log().time.size()), count = py::ssize_t(effects.size());
            require(sizes.size() == effects.size(), "sizes", "must be as many as effects", double(sizes.size()));
            for (const double size : sizes) require_positive("sizes", size);
            for (const Effect<>& effect : effects) {
              std::visit(
                  [&]<class E>(const E& law) {
                    law.validate();
                    require(is_addable(plant, effect), E::name, "must be predicted as a whole in this plant, added", 1);
                  },
                  effect);
            }
            if (is_serial(effects) || is_serial(plant.effects)) threads = 1;
            std::vector<double> innovation = without_gil([&](StopRequest* stop) {
              const ObserverLoop loop(along, self.log(), self.options(stop));
              return added_by(effects, sizes, plant, along, self.log(), loop, threads);
            });
            return to_array(std::move(innovation), {count, rows});
          },
          py::arg("along"), py::arg("plant"), py::arg("effects"), py::arg("sizes"), py::kw_only(),
          py::arg("threads") = 0,
          R"(What each effect would add to the innovations of a plant (m, (p, n)) per size of it, to first order.

Its own law is evaluated along the prediction of the plant and passed through the observer's loop: forces, friction
levels and gains; the difference that a shape, a delay or a lag makes to the command that acts, with where in each
interval it does; a load of its own by the deflection that the plant's net force causes.

Args:
    along: prediction of `plant` on this log.
    plant: what the effects join, one at a time.
    effects: p of them.
    sizes: what each row is divided by, (p,), above 0.

Raises:
    ValueError: an effect that is not addable (see is_addable) or not valid; sizes that are not one an effect.)")
      .def(
          "propagate_transposed",
          [](const Predictor& self, const Prediction& along, double mass, const Array& weight) {
            require(weight.size() == py::ssize_t(self.log().time.size()), "weight", "must be as long as the log",
                    double(weight.size()));
            require_positive("mass", mass);
            Adjoint adjoint = without_gil([&](StopRequest* stop) {
              return pass_transposed(ObserverLoop(along, self.log(), self.options(stop)), mass, view(weight));
            });
            return std::pair(to_array(std::move(adjoint.force)), to_array(std::move(adjoint.reading)));
          },
          py::arg("along"), py::arg("mass"), py::arg("weight"),
          "The transpose of propagate: by how much forces (n,) and errors of the reading (n,) move sum(weight "
          "innovation).");
}
