#include "net_forces.hpp"

#include <algorithm>
#include <stdexcept>

#include "jobs.hpp"

using namespace cogging;

/// Rows of plants that take longer than a thread to start, some 50 us against 10 to 100 ns a row.
static constexpr std::size_t rows_per_thread = 10'000;

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
      const std::vector<double> force = net_force(plants[i], predictor.log(), middle_position, middle_velocity, stop);
      std::copy(force.begin(), force.end(), row(i));
    }
  });
  return values;
}
