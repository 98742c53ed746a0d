#pragma once
// A position loop around a velocity loop.

#include <string>

#include "cogging/control/controller.hpp"
#include "cogging/control/feedforward.hpp"
#include "cogging/control/sample_guard.hpp"

namespace cogging {

template <class Scalar = double>
struct CascadeParameters {
  static constexpr std::string_view description = "Gains and feedforward of a Cascade.";

  double sample_rate = 1000.0;  // Hz
  Scalar kp = 0.0;              // 1/s
  Scalar kv = 0.0;              // V/(m/s)
  Scalar mass = 0.0;            // V/(m/s^2)
  Scalar viscous = 0.0;         // V/(m/s)
  Scalar coulomb = 0.0;         // V
  Scalar coulomb_width = 0.0;   // m/s
  std::string feedforward_velocity = "reference";
  double command_limit = 0.0;  // V

  static constexpr auto fields() {
    using P = CascadeParameters;
    return std::tuple_cat(std::tuple{Field{"sample_rate", &P::sample_rate, "Hz", "samples a second", Rule::positive},
                                     Field{"kp", &P::kp, "1/s", "gain of the position loop", Rule::not_negative},
                                     Field{"kv", &P::kv, "V/(m/s)", "gain of the velocity loop", Rule::not_negative}},
                          feedforward_fields<P>());
  }

  void validate() const { validate_feedforward(*this); }
};

/// The law of `description`. A sample that is no measurement is refused (see SampleGuard).
template <class Scalar = double>
class Cascade : public GuardedController<CascadeParameters<Scalar>, Scalar> {
  using Base = GuardedController<CascadeParameters<Scalar>, Scalar>;
  using Base::guard_, Base::parameters_;

 public:
  using typename Base::Parameters;
  static constexpr std::string_view name = "cascade";
  static constexpr std::string_view description =
      "u = kv (kp (reference - reading) - v) + feedforward, v the backward difference of the reading.";

  explicit Cascade(const Parameters& parameters = {}) : Base(parameters), feedforward_(parameters) {}

  /// What changes while it runs (see Pid::state).
  auto state() noexcept { return std::tie(feedforward_, guard_); }

  Scalar command(const ReferencePoint& reference, Scalar reading) noexcept {
    return guard_.command(guard_.usable(reference), reading, [&](const auto& sample, const Scalar& y) {
      const Scalar forward = feedforward_(sample, reference, y);
      const Scalar wanted = parameters_.kp * (reference.position - y);
      return parameters_.kv * (wanted - feedforward_.measured_velocity()) + forward;
    });
  }

  void update(Scalar) noexcept {}

 private:
  Feedforward<Scalar> feedforward_;
};

}  // namespace cogging
