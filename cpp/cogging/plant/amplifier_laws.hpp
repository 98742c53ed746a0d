#pragma once
// What the effects of a plant say of its amplifier.

#include "cogging/plant/effects/list.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// A moment, or a length of time, on the grid of the samples: so many whole ones, and the rest of one, s.
struct SampleMoment {
  std::int64_t sample = 0;
  double since = 0.0;

  /// Two moments closer than a billionth of a sample are one.
  void carry(double sample_time) {
    if (since > sample_time * (1.0 - 1e-9)) ++sample, since = std::max(0.0, since - sample_time);
    if (since < sample_time * 1e-9) since = 0.0;
  }
};

/// The laws of an amplifier, collected from the effects: shapes without memory in their order, delays that add, and
/// one current loop.
template <class Scalar = double>
class AmplifierLaws {
 public:
  /// Raises std::invalid_argument for a parameter that breaks its rule, and where there is more than one current loop.
  explicit AmplifierLaws(const std::vector<Effect<Scalar>>& effects) {
    validate_effects(effects);
    for_each_law(effects, [&](const HasShapeCommand<Scalar> auto& law) { shapes_.push_back(law); });
    for_each_law(effects, [&](const HasCommandDelay auto& law) { delay_ += law.command_delay(); });
    for_each_law(effects, [&](const HasLag auto& law) {
      require(!lagging_, law.name, "may stand once among the effects, count", 2);
      const Scalar rate = Scalar(1.0) / law.lag_time_constant();
      lagging_ = all_finite(rate);  // of a loop that is faster than numbers can say nothing is seen
      for (std::size_t i = 0; i < lanes_of<Scalar>; ++i)
        require(std::isfinite(lane(rate, i)) == lagging_, law.name,
                "must have a current loop in every lane or in none, time_constant", lane(law.lag_time_constant(), i));
      if (lagging_) rate_ = rate;
    });
  }

  Scalar shaped(Scalar command) const {
    for_each_law(shapes_, [&](const HasShapeCommand<Scalar> auto& law) { command = law.shape_command(command); });
    return command;
  }

  /// Raises std::invalid_argument for a delay of a million samples.
  SampleMoment delay_in_samples(double sample_time) const {
    const double samples = delay_ / sample_time;
    require(samples < 1e6, "command_delay.delay", "must be below a million samples", delay_);
    const auto whole = whole_part<std::int64_t>(samples);
    SampleMoment delay{whole, (samples - static_cast<double>(whole)) * sample_time};
    delay.carry(sample_time);
    return delay;
  }

  double delay() const { return delay_; }       // s
  bool lagging() const { return lagging_; }     // whether there is a current loop
  const Scalar& rate() const { return rate_; }  // 1/s, of the current loop; 0 without one

  /// The end, s, of a step from `now` that is short enough to follow the current loop, which began to settle at
  /// `changed`; infinite where it need not be followed. Always behind `now`, also where the time constant is shorter
  /// than what a time that late can tell apart.
  double followed_until(double now, double changed) const {
    if (!lagging_) return infinity;
    const double time_constant = 1.0 / largest(rate_);
    if (!(now - changed < settled * time_constant)) return infinity;
    const double end = now + time_constant;
    return end > now ? end : std::nextafter(now, infinity);
  }

 private:
  static constexpr double settled = 12.0;  // time constants, after which 6e-6 is left

  std::vector<Effect<Scalar>> shapes_;
  double delay_ = 0.0;
  bool lagging_ = false;
  Scalar rate_ = 0.0;
};

}  // namespace cogging
