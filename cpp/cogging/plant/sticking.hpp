#pragma once
// Exact Coulomb friction: a body that sticks and slips, its steps cut where it stops or breaks away.

#include "cogging/plant/state.hpp"
#include "cogging/plant/step_control.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// The point between a and b up to which `holds`, to the last bit that a time can show.
template <class Predicate>
double bisect(double a, double b, const Predicate& holds) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (a + b);
    if (middle <= a || middle >= b) break;
    (holds(middle) ? a : b) = middle;
  }
  return b;
}

/// The way of a body from offset `from` to offset `until` of the integration step that starts at `time`.
///
/// It is a sequence of pieces, in each of which the body either slides one way or rests; each ends where
/// the velocity comes to zero, where the force on the resting body reaches its level, or where one Runge-Kutta step
/// would not be accurate (StepControl). A body has
///   slide(state, drive, time, offset, length, direction)  // slides in one direction; whether the step is accurate
///   rest(state, drive, time, offset, length)              // rests; whether the step is accurate
///   breakaway(state, drive, time, offset)                 // -1 or +1: the way it breaks away; 0: it sticks
///   quickest(state, drive)                                // 1/s, at which the force on it may change at rest
template <class Body>
class StickSlip {
 public:
  StickSlip(const Body& body, const Drive<double>& drive, double time, double from, double until)
      : body_(body),
        drive_(drive),
        time_(time),
        from_(from),
        until_(until),
        done_(from),
        control_(time, until - from, until - from) {}

  void advance(AxisState<double>& state) {
    while (done_ < until_ && stops_ < stops_max) {
      double direction = sign(state.velocity);
      if (direction == 0.0) direction = body_.breakaway(state, drive_, time_, done_);
      if (direction == 0.0)
        rest(state);
      else
        slide(state, direction);
      if (!std::isfinite(state.velocity)) return;  // never a rest: the run says that it diverged
    }
    if (done_ < until_) state.velocity = 0.0;  // endless reversals within one step: the body is at rest
  }

 private:
  static constexpr int stops_max = 64;

  // Until the end of a piece, or until the body breaks away within it.
  void rest(AxisState<double>& state) {
    const double start = done_;
    const AxisState<double> resting = state;
    const double length = control_.step(until_ - start, [&](double tried) {
      state = resting;
      return body_.rest(state, drive_, time_, start, tried);
    });
    done_ = length == until_ - start ? until_ : start + length;
    const auto rested = [&](double offset) {
      AxisState<double> moved = resting;
      body_.rest(moved, drive_, time_, start, offset - start);
      return moved;
    };
    const auto sticks_at = [&](double offset) { return body_.breakaway(rested(offset), drive_, time_, offset) == 0.0; };
    // Look at four places or more: a force that comes and goes within the step must not be missed.
    const int looks = std::max(4, whole_part(std::min(1e4, 4.0 * body_.quickest() * length)));
    double stuck_at = start;
    for (int look = 1; look <= looks; ++look) {
      const double at = look == looks ? done_ : start + length * look / looks;
      if (sticks_at(at)) {
        stuck_at = at;
        continue;
      }
      done_ = bisect(stuck_at, at, sticks_at);
      state = rested(done_);
      ++stops_;
      return;
    }
  }

  // Until the end of a piece, or until the body stops within it.
  void slide(AxisState<double>& state, double direction) {
    const AxisState<double> start = state;
    const double left = until_ - done_;
    const double length = control_.step(left, [&](double tried) {
      state = start;
      return body_.slide(state, drive_, time_, done_, tried, direction);
    });
    if (!std::isfinite(state.velocity)) return;
    if (state.velocity * direction >= 0.0) {
      done_ = length == left ? until_ : done_ + length;
      return;
    }
    const auto slid = [&](double tried) {
      AxisState<double> end = start;
      body_.slide(end, drive_, time_, done_, tried, direction);
      return end;
    };
    const double stop = bisect(0.0, length, [&](double tried) { return slid(tried).velocity * direction >= 0.0; });
    state = slid(stop);
    state.velocity = 0.0;
    done_ += std::max(stop, 1e-12 * (until_ - from_));
    ++stops_;
  }

  const Body& body_;
  const Drive<double>& drive_;
  double time_, from_, until_, done_;
  StepControl control_;
  int stops_ = 0;
};

}  // namespace cogging
