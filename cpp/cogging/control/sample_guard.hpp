#pragma once
// What every controller answers to a sample that is no measurement: a reading or a reference that is not finite.

#include <span>
#include <utility>

#include "cogging/parameters.hpp"
#include "cogging/reference/reference.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// A sample is refused where its reading or a part of its reference is not finite or is `size_max` or larger. The
/// controller then holds its last command, cut at its limit (0 V before the first), keeps what it has learned from
/// readings as it stands, and counts the sample. An applied command that is not finite is taken to have been its own.
///
/// The next sample that can be used knows how many have passed: differences of readings are taken over all of them, so
/// that a velocity does not kick. What goes by the applied commands alone goes on through the gap.
///
/// A law is a function of (sample, reading): `sample` is an Ordinary one or an Interrupted one, and everything that it
/// writes goes through the sample, so that lanes that are refused stay untouched beside lanes that are not.
template <class Scalar>
class SampleGuard {
 public:
  using Mask = decltype(std::declval<const Scalar&>() < std::declval<const Scalar&>());

  static constexpr double size_max = 1e12;  // SI: squares and fourth powers of it are still numbers
  static constexpr int gap_max = 16;        // samples that an estimator bridges; after a longer gap it starts anew

  /// Behind a sample that was taken, as nearly all are.
  struct Ordinary {
    static constexpr double steps = 1.0;  // samples since the last one that was taken
    static constexpr int bridged = 0;     // samples that were missed and are made up for

    template <class Value>
    COGGING_INLINE static void set(Value& state, const Value& value) {
      state = value;
    }
    COGGING_INLINE static const Scalar& per_sample(const Scalar& difference) { return difference; }
    COGGING_INLINE static const Scalar& mean(const Scalar& sum) { return sum; }
    COGGING_INLINE static void bridge(int, Scalar&, const Scalar&) {}
    COGGING_INLINE static void begin(Scalar&, const Scalar&) {}
    COGGING_INLINE static void start(Scalar&, const Scalar&) {}
  };

  /// The first sample, one behind a gap, or one that some of the lanes refuse.
  class Interrupted {
   public:
    Interrupted(const Mask& taken, const Scalar& passed)
        : steps(passed),
          taken_(taken),
          first_(select(taken, passed, Scalar(0.0)) > std::numeric_limits<double>::max()),
          anew_(select(taken, passed, Scalar(0.0)) > gap_max + 1.0),
          missed_(select(anew_, Scalar(0.0), select(taken, passed - 1.0, Scalar(0.0)))),
          bridged(whole_part(largest(missed_))) {}

    const Scalar steps;  // infinite in the first sample

    void set(Scalar& state, const Scalar& value) const { state = select(taken_, value, state); }
    /// The change of a reading by sample; 0 in the first.
    Scalar per_sample(const Scalar& difference) const { return select(first_, Scalar(0.0), difference / steps); }
    /// Of a sum over this sample and those that are made up for.
    Scalar mean(const Scalar& sum) const { return sum / (missed_ + 1.0); }
    /// Sets the state where the missed sample `number` (1 to `bridged`) is made up for.
    void bridge(int number, Scalar& state, const Scalar& value) const {
      state = select(missed_ >= double(number), value, state);
    }
    /// Sets the state in the first sample.
    void begin(Scalar& state, const Scalar& value) const { state = select(first_, value, state); }
    /// Sets the state in the first sample and behind a gap that is too long to be bridged.
    void start(Scalar& state, const Scalar& value) const { state = select(anew_, value, state); }

   private:
    Mask taken_, first_, anew_;
    Scalar missed_;

   public:
    const int bridged;
  };

  explicit SampleGuard(double command_limit) : limit_(command_limit) {}

  static bool usable(const ReferencePoint& reference) {
    return std::abs(reference.position) + std::abs(reference.velocity) + std::abs(reference.acceleration) < size_max;
  }

  /// The command of a sample: what the law gives for it, or the last one.
  template <class Law>
  COGGING_INLINE Scalar command(bool reference_usable, const Scalar& reading, const Law& law) noexcept {
    const Mask usable = abs(reading) < size_max;
    if (reference_usable && all(usable) && all(missed_ == 0.0)) [[likely]]
      return last_ = law(Ordinary{}, reading);
    return interrupted(reference_usable ? usable : Mask(false), reading, law);
  }

  /// After `command`: one value where its sample was taken, the other where it was refused.
  COGGING_INLINE Scalar if_taken(const Scalar& value, const Scalar& otherwise) const noexcept {
    if (all(missed_ == 0.0)) [[likely]]
      return value;
    return select(missed_ == 0.0, value, otherwise);
  }

  /// The command that acted, as far as it can be believed.
  COGGING_INLINE Scalar acted(const Scalar& applied) const noexcept {
    const Mask usable = abs(applied) < size_max;
    if (all(usable)) [[likely]]
      return applied;
    return select(usable, applied, limited(last_));
  }

  /// A command as it is held: cut at the limit, and a number.
  Scalar limited(const Scalar& command) const noexcept {
    const Scalar cut = limit_ > 0.0 ? clamp(command, Scalar(-limit_), Scalar(limit_)) : command;
    return select(abs(cut) <= std::numeric_limits<double>::max(), cut, Scalar(0.0));
  }

  /// What changes while it runs (see Pid::state).
  auto state() noexcept { return std::tie(missed_, refused_, last_); }

  /// How many samples were refused, a whole number.
  const Scalar& samples_refused() const { return refused_; }

 private:
  template <class Law>
  COGGING_COLD Scalar interrupted(const Mask& taken, const Scalar& reading, const Law& law) noexcept {
    const Scalar taken_count = select(taken, Scalar(1.0), Scalar(0.0));
    last_ = limited(last_);
    if (largest(taken_count) > 0.0)
      last_ = select(taken, law(Interrupted(taken, missed_ + 1.0), select(taken, reading, Scalar(0.0))), last_);
    missed_ = select(taken, Scalar(0.0), missed_ + 1.0);
    refused_ += 1.0 - taken_count;
    return last_;
  }

  double limit_;
  Scalar missed_ = infinity;  // samples since the last one that was taken
  Scalar refused_ = 0.0, last_ = 0.0;
};

/// What the controllers of the core have in common: parameters whose rules hold, and the guard of their samples.
template <class ItsParameters, class Scalar>
class GuardedController {
 public:
  using Parameters = ItsParameters;

  const Parameters& parameters() const { return parameters_; }
  double sample_rate() const { return parameters_.sample_rate; }
  double command_limit() const { return parameters_.command_limit; }
  std::span<const Scalar> estimates() const { return {}; }  // of one that does not adapt
  const Scalar& samples_refused() const { return guard_.samples_refused(); }

 protected:
  explicit GuardedController(const Parameters& parameters)
      : parameters_(validated(parameters)), guard_(parameters.command_limit) {}

  Parameters parameters_;
  SampleGuard<Scalar> guard_;
};

}  // namespace cogging
