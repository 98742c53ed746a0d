#pragma once
// The one Runge-Kutta step, the pieces that make it accurate, and the way from event to event.

#include <array>

#include "cogging/plant/state.hpp"
#include "cogging/plant/step_control.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// The slopes of a step: at its start, twice in its middle, at its end.
template <class Slope>
struct Stages {
  Slope first, second, third, fourth;

  /// Six times the mean of one part of the slope over the step.
  template <class Value>
  COGGING_INLINE Value sum(Value Slope::* part) const {
    return first.*part + 2.0 * (second.*part + third.*part) + fourth.*part;
  }

  template <class Value>
  std::array<Value, 4> each(Value Slope::* part) const {
    return {first.*part, second.*part, third.*part, fourth.*part};
  }
};

/// The classical Runge-Kutta step of fourth order, of length h from where the slope is `first`.
///
/// moved(slope, length) gives the point that lies that far along a slope from the start; slope_at(point, input) the
/// slope there, `input` being what acts on the law from outside: in the middle of the step, and at its end. A law that
/// jumps at the end must not be felt before: give what acts just before. Where the last point is known,
/// before_last(first, second, third, point) is called, so that what follows from it need not wait for the last slope.
template <class Slope, class Input, class Moved, class SlopeAt, class BeforeLast>
COGGING_INLINE Stages<Slope> runge_kutta(const Slope& first, double h, const Input& middle, const Input& end,
                                         const Moved& moved, const SlopeAt& slope_at, const BeforeLast& before_last) {
  const Slope second = slope_at(moved(first, 0.5 * h), middle);
  const Slope third = slope_at(moved(second, 0.5 * h), middle);
  const auto last = moved(third, h);
  before_last(first, second, third, last);
  return {first, second, third, slope_at(last, end)};
}

/// Moves the state from offset `from` to offset `until` of the step that begins at `time`, in as many pieces as are
/// accurate, while its velocity is finite. step(state, offset, length) makes a piece and says whether it is accurate;
/// the first is at most as long as `first`.
template <class Step>
void advance_in_pieces(AxisState<double>& state, double time, double from, double until, double first,
                       const Step& step) {
  StepControl control(time, until - from, first);
  double done = from;
  while (done < until && std::isfinite(state.velocity)) {
    const AxisState<double> start = state;
    const double left = until - done;
    const double length = control.step(left, [&](double tried) {
      state = start;
      return step(state, done, tried);
    });
    done = length == left ? until : done + length;
  }
}

/// Moves the axis from `from` to `to`, s, while one command acts, from event to event: where a force law jumps a step
/// ends, and while the current loop settles steps are short. steps_of(start, end) says in how many steps of the
/// integrator each part is made. The drive settles along the way.
template <class Axis, class AnyAmplifier, class Scalar, class StepsOf>
void advance_through_events(Axis& axis, AnyAmplifier& amplifier, AxisState<Scalar>& state, Drive<Scalar>& drive,
                            double from, double to, const StepsOf& steps_of) {
  double now = from;
  while (now < to) {
    const double next = std::min({to, axis.next_event(now), amplifier.followed_until(now, from)});
    const int steps = steps_of(now, next);
    const double h = (next - now) / steps;
    for (int step = 0; step < steps; ++step) {
      axis.advance(state, drive, now + step * h, h);
      amplifier.settle(drive, h);
    }
    now = next;
  }
}

}  // namespace cogging
