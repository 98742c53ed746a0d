#pragma once
// Exact Coulomb friction: a body that sticks and slips, its steps cut where it stops or breaks away.

#include <algorithm>

#include "cogging/plant/state.hpp"

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
/// the velocity comes to zero or where the force on the resting body reaches its level. A body has
///   slide(state, drive, time, offset, length, direction)  // the state after sliding in one direction
///   rest(state, drive, time, offset, length)              // the state after resting
///   breakaway(state, drive, time, offset)                 // -1 or +1: the way it breaks away; 0: it sticks
template <class Body>
void advance_sticking(const Body& body, AxisState<double>& state, const Drive<double>& drive, double time, double from,
                      double until) {
  constexpr int pieces_max = 64;
  double done = from;
  for (int piece = 0; piece < pieces_max && done < until; ++piece) {
    const double left = until - done;
    double direction = sign(state.velocity);
    if (direction == 0.0) {
      direction = body.breakaway(state, drive, time, done);
      if (direction == 0.0) {
        const double start = done;
        const auto rested = [&](double offset) { return body.rest(state, drive, time, start, offset - start); };
        const auto rests_until = [&](double offset) {
          return body.breakaway(rested(offset), drive, time, offset) == 0.0;
        };
        // Look at quarters of what is left: a force that comes and goes within the step must not be missed.
        for (int quarter = 1; quarter <= 4 && done == start; ++quarter) {
          const double look = quarter == 4 ? until : start + 0.25 * quarter * left;
          if (!rests_until(look)) done = bisect(start, look, rests_until);
        }
        state = rested(done == start ? until : done);
        if (done == start) return;
        continue;
      }
    }
    const auto slide = [&](double length) { return body.slide(state, drive, time, done, length, direction); };
    const AxisState<double> end = slide(left);
    if (end.velocity * direction >= 0.0) {
      state = end;
      return;
    }
    const double length = bisect(0.0, left, [&](double l) { return slide(l).velocity * direction >= 0.0; });
    state = slide(length);
    state.velocity = 0.0;
    done += std::max(length, 1e-12 * (until - from));
  }
  if (done < until) state.velocity = 0.0;  // endless reversals within one step: the body is at rest
}

}  // namespace cogging
