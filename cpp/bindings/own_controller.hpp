#pragma once
// Controllers that are not of the core: an object of Python's, or compiled functions by their address.

#include "bindings.hpp"
#include "cogging/control/compiled.hpp"
#include "cogging/control/list.hpp"
#include "gil.hpp"

/// An object of Python's that closes the loop; its calls need the lock. The object is held by all copies of this: a run
/// that may not change it is given a deep copy.
class PythonController {
 public:
  /// Refuses what is no controller, in one line. With the lock held, as every call but those of copies.
  explicit PythonController(const py::object& object);

  double sample_rate() const { return held_->sample_rate; }
  double command_limit() const { return held_->command_limit; }
  /// Of its `estimates` now; empty where it has none.
  std::span<const double> estimates() const;

  void begin_row(std::size_t row, double time) {
    row_ = row;
    time_ = time;
  }

  double command(const cogging::ReferencePoint& reference, double reading);
  void update(double applied);

 private:
  struct Held {
    explicit Held(const py::object& given) : object(given) {}
    Kept object;
    std::string name{};  // of its class
    double sample_rate = 0.0, command_limit = 0.0;
    bool has_update = false, has_estimates = false;
    std::vector<double> estimates{};
  };

  [[noreturn]] void fail(const char* method) const;

  std::shared_ptr<Held> held_;
  std::size_t row_ = 0;
  double time_ = 0.0;
};

template <class Listed>
struct WithOwn;
template <class... C>
struct WithOwn<std::variant<C...>> {
  using type = std::variant<C..., cogging::CompiledController, PythonController>;
};
using GivenController = WithOwn<cogging::AnyController<>>::type;

/// A controller for one run from what a user gave: a copy of one of the core, or a deep copy of an object, reset. With
/// the lock held.
///
/// Raises TypeError for what is no controller, ValueError for a sample rate or a limit that is none.
GivenController take_controller(const py::object& given);

/// Calls loop(controller, stop request) with the controller that was given: one of Python is run with the lock.
template <class Loop>
auto close_with(const GivenController& controller, cogging::StopRequest* stop, const Loop& loop) {
  return std::visit(
      [&]<class C>(const C& c) {
        if constexpr (std::is_same_v<C, PythonController>)
          return with_gil(stop, [&](cogging::StopRequest* turns) { return loop(c, turns); });
        else
          return loop(c, stop);
      },
      controller);
}
