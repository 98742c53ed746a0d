#include "bindings.hpp"
#include "cogging/estimation/predictor.hpp"
#include "cogging/estimation/whitening.hpp"
#include "cogging/simulation/batch.hpp"
#include "gil.hpp"
#include "instantiated.hpp"
#include "lanes/lanes.hpp"

using namespace cogging;

namespace {

// A table of a predictor, (count, n), made without the GIL by make(stop request).
template <class Make>
py::array_t<double> rows_of(const Predictor& predictor, std::size_t count, const Make& make) {
  std::vector<double> values = without_gil(make);
  return to_array(std::move(values), {py::ssize_t(count), py::ssize_t(predictor.rows())});
}

// Rows of plants that take longer than a thread to start, some 50 us against 10 to 100 ns a row.
constexpr std::size_t rows_per_thread = 10'000;

// Command that acts plus all forces, V, of many plants along a motion given half-way between rows: (plants, rows);
// side by side those that share a course, each with the bits that it has alone.
std::vector<double> net_forces(const Predictor& predictor, const std::vector<Plant<>>& plants,
                               std::span<const double> middle_position, std::span<const double> middle_velocity,
                               unsigned threads, StopRequest* stop) {
  predictor.require_length("middle_position", middle_position);
  predictor.require_length("middle_velocity", middle_velocity);
  const auto worth =
      static_cast<unsigned>(std::clamp<std::size_t>(plants.size() * predictor.rows() / rows_per_thread, 1, 1'000));
  threads = std::min(threads_of(Predictor::useful(plants, threads)), worth);
  const std::optional<InstructionSet> set = instruction_set();
  const Jobs jobs = jobs_of(plants.size(), set, threads, [&](std::size_t i) { return course_of_forces(plants[i]); });
  std::vector<double> values(plants.size() * predictor.rows());
  const auto row = [&](std::size_t i) { return values.data() + i * predictor.rows(); };
  const auto run_pack = [&](const std::vector<std::size_t>& job) {
    std::vector<const Plant<>*> its;
    std::vector<double*> rows;
    for (const std::size_t i : job) its.push_back(&plants[i]), rows.push_back(row(i));
    try {
      set->net_force({its, rows, predictor.log(), middle_position, middle_velocity, stop});
    } catch (const std::invalid_argument&) {
      return false;  // each of them alone says why
    }
    return true;
  };
  run_batch(jobs.size(), threads, stop, [&](std::size_t number) {
    const std::vector<std::size_t>& job = jobs[number];
    if (job.size() > 1 && run_pack(job)) return;
    for (const std::size_t i : job) {
      const Recording log = predictor.log();
      double* const force = row(i);
      write_net_force(plants[i], {RecordedAmplifier(plants[i].effects, log.time, log.command)}, log, middle_position,
                      middle_velocity, {&force, 1}, stop);
    }
  });
  return values;
}

void bind_predictor(py::module_& module) {
  py::class_<Prediction> prediction(module, "Prediction",
                                    "A prediction along a log, with its slopes: what `propagate` needs.");
  const std::tuple<const char*, std::vector<double> Prediction::*, const char*> columns[] = {
      {"innovation", &Prediction::innovation, "m, reading less what was foreseen"},
      {"position", &Prediction::position, "m, corrected"},
      {"velocity", &Prediction::velocity, "m/s, corrected"},
      {"middle_position", &Prediction::middle_position, "m, half-way to the next row"},
      {"middle_velocity", &Prediction::middle_velocity, "m/s, half-way to the next row"}};
  for (const auto& [name, column, doc] : columns)
    prediction.def_property_readonly(
        name, [column](const Prediction& p) { return to_array(std::vector(p.*column)); }, doc);

  py::class_<Predictor>(module, "Predictor", R"(One step ahead along a log.

The plant is driven by the recorded command and held to the recorded position by an observer with both poles at
exp(-2 pi bandwidth Ts); the innovation (m) is what the model did not foresee. Time steps may differ; after one longer
than `gap` (s) the observer starts anew.)")
      .def(py::init([](const Array& time, const Array& position, const Array& command, double bandwidth, double gap,
                       double initial_velocity, int steps_per_sample) {
             return Predictor(to_vector(time), to_vector(position), to_vector(command),
                              {bandwidth, gap, initial_velocity, steps_per_sample, nullptr});
           }),
           py::arg("time"), py::arg("position"), py::arg("command"), py::kw_only(), py::arg("bandwidth") = 30.0,
           py::arg("gap") = 1e30, py::arg("initial_velocity") = 0.0, py::arg("steps_per_sample") = 1)
      .def(
          "predict",
          [](const Predictor& self, const Plant<>& plant) {
            return without_gil([&](StopRequest* stop) { return self.predict(plant, stop); });
          },
          py::arg("plant"), "The prediction along the log, with slopes.")
      .def(
          "innovations",
          [](const Predictor& self, const std::vector<Plant<>>& plants, unsigned threads) {
            return rows_of(self, plants.size(),
                           [&](StopRequest* stop) { return self.innovations(plants, threads, stop); });
          },
          py::arg("plants"), py::kw_only(), py::arg("threads") = 0,
          "Innovations (m) of many plants, (plants, n), on `threads` threads (0 = all cores).")
      .def(
          "net_force",
          [](const Predictor& self, const std::vector<Plant<>>& plants, const Array& middle_position,
             const Array& middle_velocity, unsigned threads) {
            return rows_of(self, plants.size(), [&](StopRequest* stop) {
              return net_forces(self, plants, view(middle_position), view(middle_velocity), threads, stop);
            });
          },
          py::arg("plants"), py::arg("middle_position"), py::arg("middle_velocity"), py::kw_only(),
          py::arg("threads") = 0,
          "Command that acts plus all forces (V) along a motion given half-way between rows, (plants, n).")
      .def(
          "propagate",
          [](const Predictor& self, const Prediction& along, double mass, const Array& forces,
             const std::optional<Array>& reading_errors, unsigned threads) {
            require(forces.ndim() == 2 && std::size_t(forces.shape(1)) == self.rows(), "forces", "must be (p, n)",
                    forces.size());
            require(!reading_errors || (reading_errors->ndim() == 2 && reading_errors->shape(0) == forces.shape(0) &&
                                        reading_errors->shape(1) == forces.shape(1)),
                    "reading_errors", "must have the shape of forces", 0.0);
            const std::size_t count = std::size_t(forces.shape(0));
            const std::span<const double> errors = reading_errors ? view(*reading_errors) : std::span<const double>();
            return rows_of(self, count, [&](StopRequest* stop) {
              return self.propagate(along, mass, count, view(forces), errors, threads, stop);
            });
          },
          py::arg("along"), py::arg("mass"), py::arg("forces"), py::arg("reading_errors") = py::none(), py::kw_only(),
          py::arg("threads") = 0,
          R"(What small forces (V, (p, n)) and errors of the reading (m, (p, n)) add to the innovations (m, (p, n)).)");
}

void bind_whitening(py::module_& module) {
  module.def(
      "autoregression",
      [](const Array& residual, const Array& counts, int order) {
        require(counts.size() == residual.size(), "counts", "must be as long as residual", counts.size());
        return without_gil(
            [&](StopRequest* stop) { return autoregression(view(residual), view(counts), order, stop); });
      },
      py::arg("residual"), py::arg("counts"), py::kw_only(), py::arg("order"),
      R"(Coefficients a (order,) of e_k = r_k - sum_i a_i r_(k-i) with the least rms of e.

Yule and Walker's equations; rows with counts = 0 and pairs with one of them are left out.

Raises:
    ValueError: lengths differ, order above a quarter of the rows, nothing that counts.)");
  module.def(
      "whiten",
      [](const Array& rows, const std::vector<double>& coefficients, unsigned threads) {
        require(rows.ndim() == 2, "rows", "must be (p, n)", rows.ndim());
        const std::size_t count = std::size_t(rows.shape(0)), length = std::size_t(rows.shape(1));
        std::vector<double> values(count * length);
        without_gil([&](StopRequest* stop) {
          run_batch(count, threads, stop, [&](std::size_t i) {
            whiten({rows.data() + i * length, length}, coefficients, values.data() + i * length, stop);
          });
        });
        return to_array(std::move(values), {rows.shape(0), rows.shape(1)});
      },
      py::arg("rows"), py::arg("coefficients"), py::kw_only(), py::arg("threads") = 0,
      "e_k = r_k - sum_i a_i r_(k-i) of every row of (p, n); r is 0 before the first column.");
}

}  // namespace

void bind_estimation(py::module_& module) {
  bind_predictor(module);
  bind_whitening(module);
}
