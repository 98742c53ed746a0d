#pragma once
// A controller that the user gives as compiled functions, by address: of numba, of C, of anything that has the C ABI.

#include <memory>
#include <utility>

#include "cogging/control/controller.hpp"
#include "cogging/reference/reference.hpp"
#include "cogging/require.hpp"

namespace cogging {

/// A user's own controller that failed, or whose command is no number; says in which row of the run, and at what time.
class ControllerError : public std::runtime_error {
 public:
  ControllerError(const std::string& message, std::size_t at_row, double at_time)
      : std::runtime_error(message), row(at_row), time(at_time) {}
  std::size_t row;
  double time;  // s
};

/// Ends a run whose controller, one of the user's own, cannot go on.
[[noreturn]] inline void end_run(const std::string& controller, const std::string& what, std::size_t row, double time) {
  const std::string place = " in row " + std::to_string(row) + " (" + format(time) + " s)";
  throw ControllerError("controller: " + controller + ": " + what + place, row, time);
}

/// The functions, and whoever keeps their code in memory.
struct CompiledFunctions {
  /// The command (V) of a sample; `reference` holds position, velocity, acceleration (m, m/s, m/s^2), `reading` m.
  using Command = double (*)(double* state, const double* parameters, const double* reference, double reading);
  /// Ends the sample with the command (V) that was applied.
  using Update = void (*)(double* state, const double* parameters, double applied);

  Command command = nullptr;
  Update update = nullptr;  // none: nothing is done
  std::shared_ptr<const void> owner = nullptr;

  bool operator==(const CompiledFunctions& other) const { return command == other.command && update == other.update; }
};

struct CompiledSettings {
  double sample_rate = 0.0;          // Hz
  std::vector<double> state{};       // with which a run begins
  std::vector<double> parameters{};  // never written
  double command_limit = 0.0;        // V; 0 = none

  bool operator==(const CompiledSettings&) const = default;

  void validate() const {
    require_positive("sample_rate", sample_rate);
    require_finite("state", state);
    require_finite("parameters", parameters);
    require_not_negative("command_limit", command_limit);
  }
};

/// u = command(state, parameters, reference, reading), then update(state, parameters, applied). The state is the
/// controller's own: a copy has another. Its estimates are its state.
class CompiledController {
 public:
  CompiledController(CompiledFunctions functions, CompiledSettings settings)
      : functions_(std::move(functions)), settings_(std::move(settings)), state_(settings_.state) {
    if (functions_.command == nullptr) refuse("command", "must be a compiled function", "none");
    settings_.validate();
  }

  const CompiledSettings& settings() const { return settings_; }
  double sample_rate() const { return settings_.sample_rate; }
  double command_limit() const { return settings_.command_limit; }
  std::span<const double> estimates() const { return state_; }

  void begin_row(std::size_t row, double time) noexcept {
    row_ = row;
    time_ = time;
  }

  /// Throws ControllerError where the function gives no finite number.
  double command(const ReferencePoint& reference, double reading) {
    const double point[3] = {reference.position, reference.velocity, reference.acceleration};
    const double command = functions_.command(state_.data(), settings_.parameters.data(), point, reading);
    if (!std::isfinite(command)) [[unlikely]]
      end_run("CompiledController", "command must give a finite number, got " + format(command), row_, time_);
    return command;
  }

  void update(double applied) {
    if (functions_.update != nullptr) functions_.update(state_.data(), settings_.parameters.data(), applied);
  }

  /// Whether it is made of the same and is in the same state: it goes on alike.
  bool operator==(const CompiledController& other) const {
    return functions_ == other.functions_ && settings_ == other.settings_ && state_ == other.state_;
  }

  /// As it was made: the state with which a run begins.
  void reset() { state_ = settings_.state; }

 private:
  CompiledFunctions functions_;
  CompiledSettings settings_;
  std::vector<double> state_;
  std::size_t row_ = 0;
  double time_ = 0.0;
};

}  // namespace cogging
