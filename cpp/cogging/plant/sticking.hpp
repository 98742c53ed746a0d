#pragma once
// Exact Coulomb friction: a body that sticks and slips, its steps cut where it stops or breaks away.

#include <algorithm>
#include <cmath>

#include "cogging/plant/state.hpp"
#include "cogging/plant/step_control.hpp"

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

/// Moves the state from offset `from` to offset `until` of the integration step that starts at `time`.
///
/// The step is a sequence of pieces, in each of which the body either slides one way or rests; each ends where
/// the velocity comes to zero, where the force on the resting body reaches its level, or where one Runge-Kutta step
/// would not be accurate (StepControl). A body has
///   slide(state, drive, time, offset, length, direction)  // slides in one direction; whether the step is accurate
///   rest(state, drive, time, offset, length)              // rests; whether the step is accurate
///   breakaway(state, drive, time, offset)                 // -1 or +1: the way it breaks away; 0: it sticks
///   quickest(state, drive)                                // 1/s, at which the force on it may change at rest
template <class Body>
void advance_sticking(const Body& body, AxisState<double>& state, const Drive<double>& drive, double time, double from,
                      double until) {
  constexpr int stops_max = 64;
  StepControl control(until - from);
  int stops = 0;
  double done = from;
  while (done < until && stops < stops_max) {
    double direction = sign(state.velocity);
    if (direction == 0.0) {
      direction = body.breakaway(state, drive, time, done);
      if (direction == 0.0) {
        const double start = done;
        const AxisState<double> resting = state;
        AxisState<double> end;
        const double length = control.step(until - start, [&](double tried) {
          end = resting;
          return body.rest(end, drive, time, start, tried);
        });
        const auto rests_until = [&](double offset) {
          AxisState<double> moved = resting;
          body.rest(moved, drive, time, start, offset - start);
          return body.breakaway(moved, drive, time, offset) == 0.0;
        };
        // Look at four places or more: a force that comes and goes within the step must not be missed.
        const int looks = std::max(4, static_cast<int>(std::min(1e4, 4.0 * body.quickest() * length)));
        done = length == until - start ? until : start + length;
        double rests_at = start;
        for (int look = 1; look <= looks; ++look) {
          const double at = look == looks ? done : start + length * look / looks;
          if (rests_until(at)) {
            rests_at = at;
            continue;
          }
          done = bisect(rests_at, at, rests_until);
          end = resting;
          body.rest(end, drive, time, start, done - start);
          ++stops;
          break;
        }
        state = end;
        continue;
      }
    }
    const AxisState<double> start = state;
    const double left = until - done;
    const double length = control.step(left, [&](double tried) {
      state = start;
      return body.slide(state, drive, time, done, tried, direction);
    });
    if (!std::isfinite(state.velocity)) return;  // never a rest: the run says that it diverged
    if (state.velocity * direction >= 0.0) {
      done = length == left ? until : done + length;
      continue;
    }
    const auto slid = [&](double tried) {
      AxisState<double> end = start;
      body.slide(end, drive, time, done, tried, direction);
      return end;
    };
    const double stop = bisect(0.0, length, [&](double tried) { return slid(tried).velocity * direction >= 0.0; });
    state = slid(stop);
    state.velocity = 0.0;
    done += std::max(stop, 1e-12 * (until - from));
    ++stops;
  }
  if (done < until) state.velocity = 0.0;  // endless reversals within one step: the body is at rest
}

}  // namespace cogging
