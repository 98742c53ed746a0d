// The C3 loop of the X axis of Lu et al. 2008, written by hand for this one case: what the core is measured against.
// The same arithmetic and the same columns as the core, its structure fixed: harmonics 1, 2, 3, 6, 12 in the plant and
// 1, 2, 3 in the controller, splines of order 3 with 13 control points, one Runge-Kutta step a sample. With LANES
// defined, so many machines side by side, in a register of the core.

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "cogging/registers.hpp"

#ifndef LANES
#define LANES 1
#endif

#ifdef LIBRARY_FUNCTIONS  // the mathematics library's, to see what the core's own sine and arctangent change
struct Scalar : cogging::Register<1> {
  static double atan(double a) { return std::atan(a); }
  static void sin_cos(double angle, double& sine, double& cosine) {
    sine = std::sin(angle);
    cosine = std::cos(angle);
  }
};
#else
using Scalar = cogging::Register<1>;
#endif
using Register = std::conditional_t<LANES == 1, Scalar, cogging::Register<LANES>>;
using Number = Register::Numbers;

struct Setup {  // all double, in the order of lu2008_loop.py
  double mass, viscous, coulomb, coulomb_width, pitch, resolution;
  double start, distance, velocity, acceleration, jerk, dwell, repeats;
  double sample_rate, error_gain, feedback_gain;
  double mass_adaptation, viscous_adaptation, coulomb_adaptation, disturbance_adaptation, cogging_adaptation;
  double mass_min, mass_max, viscous_min, viscous_max, coulomb_min, coulomb_max;
  double disturbance_min, disturbance_max, cogging_min, cogging_max;
};

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr int control_points = 13, spans = control_points - 2;

struct ReferencePoint {
  double position, velocity, acceleration;
};

// Jerk-limited, there and back; the acceleration and the velocity limit are both reached.
struct PointToPoint {
  const Setup& q;
  double jerk_time = q.acceleration / q.jerk;
  double ramp = q.velocity / q.acceleration + jerk_time;
  double move = ramp + q.distance / q.velocity;
  double period = 2.0 * (move + q.dwell);

  ReferencePoint first_half(double t) const {
    const double a = q.acceleration, v = q.velocity;
    if (t < jerk_time) return {q.jerk * t * t * t / 6.0, 0.5 * q.jerk * t * t, q.jerk * t};
    if (t < ramp - jerk_time) {
      const double s = t - jerk_time, v0 = 0.5 * a * jerk_time;
      return {a * jerk_time * jerk_time / 6.0 + v0 * s + 0.5 * a * s * s, v0 + a * s, a};
    }
    if (t < ramp) {
      const double s = ramp - t;
      return {0.5 * v * ramp - v * s + q.jerk * s * s * s / 6.0, v - 0.5 * q.jerk * s * s, q.jerk * s};
    }
    return {0.5 * v * ramp + v * (t - ramp), v, 0.0};
  }

  ReferencePoint at(double time) const {
    if (time <= 0.0 || time >= q.repeats * period) return {q.start, 0.0, 0.0};
    double t = std::fmod(time, period);
    const bool back = t >= 0.5 * period;
    if (back) t -= 0.5 * period;
    if (t >= move) return {back ? q.start : q.start + q.distance, 0.0, 0.0};
    ReferencePoint p = first_half(std::min(t, move - t));
    if (t > 0.5 * move) p = {q.distance - p.position, p.velocity, -p.acceleration};
    if (back) return {q.start + q.distance - p.position, -p.velocity, -p.acceleration};
    return {q.start + p.position, p.velocity, p.acceleration};
  }
};

struct Spline {
  int first;
  double w0, w1, w2;
};

Spline spline(double u) {  // position in pitches
  u = std::clamp(u, 0.0, double(spans));
  const int span = std::min(static_cast<int>(u), spans - 1);
  const double t = u - span, s = 1.0 - t;
  return {span, 0.5 * s * s, 0.5 + s * t, 0.5 * t * t};
}

Number all(double value) {
  return Register::of(value);
}
Number clamp_of(Number a, double low, double high) {
  a = all(low) > a ? all(low) : a;
  return all(high) < a ? all(high) : a;
}

struct NumberSpline {
  Number first, w0, w1, w2;
};

template <class N>
auto spline_of(N u) {
  if constexpr (std::is_same_v<N, double>) {
    return spline(u);
  } else {
    u = clamp_of(u, 0.0, double(spans));
    const N first = clamp_of(Register::trunc(u), 0.0, spans - 1.0), t = u - first, s = 1.0 - t;
    return NumberSpline{first, 0.5 * s * s, 0.5 + s * t, 0.5 * t * t};
  }
}

// The rows of the table that act; the machines are nearly always within one pitch of the magnets.
template <int columns>
const Number* active(const Spline& b, const Number* table, Number*) {
  return table + columns * b.first;
}
template <int columns>
const Number* active(const NumberSpline& b, const Number* table, Number* gathered) {
  const auto row = [&](int lane) { return columns * int(Register::get(b.first, lane)); };
  if (Register::all(b.first == Register::get(b.first, 0))) [[likely]]
    return table + row(0);
  for (int i = 0; i < 3 * columns; ++i)
    for (int lane = 0; lane < LANES; ++lane)
      Register::set(gathered[i], lane, Register::get(table[row(lane) + i], lane));
  return gathered;
}

void store(double* column, int rows, int k, Number value) {
  for (int lane = 0; lane < LANES; ++lane) column[lane * rows + k] = Register::get(value, lane);
}
void load(Number& value, const double* machines, int columns, int column) {
  for (int lane = 0; lane < LANES; ++lane) Register::set(value, lane, machines[lane * columns + column]);
}

}  // namespace

// `machines`: for each machine a row of mass, viscous, coulomb and the coefficients. `reference` has four rows: time,
// position, velocity, acceleration; the four columns of the result have a row for each machine.
extern "C" void lu2008_loop(const Setup* setup, const double* machines, int rows, double* reference, double* position,
                            double* command, double* true_position, double* true_velocity) {
  const Setup& q = *setup;
  const double h = 1.0 / q.sample_rate, inverse_pitch = 1.0 / q.pitch, wavenumber = 2.0 * pi / q.pitch;
  const double inverse_width = 1.0 / q.coulomb_width, two_over_pi = 2.0 / pi;

  const PointToPoint motion{q};
  double *time = reference, *reference_position = time + rows;
  double *reference_velocity = time + 2 * rows, *reference_acceleration = time + 3 * rows;
  for (int k = 0; k < rows; ++k) {
    time[k] = k / q.sample_rate;
    const ReferencePoint point = motion.at(time[k]);
    reference_position[k] = point.position;
    reference_velocity[k] = point.velocity;
    reference_acceleration[k] = point.acceleration;
  }

  constexpr int columns = 3 + 10 * control_points;
  static thread_local Number m[columns];
  for (int c = 0; c < columns; ++c) load(m[c], machines, columns, c);
  const Number inverse_mass = 1.0 / m[0], plant_viscous = m[1], plant_coulomb = m[2] * two_over_pi;
  const Number* cogging = m + 3;

  const auto acceleration = [&](Number x, Number v, Number u) {
    Number s1, c1;
    Register::sin_cos(wavenumber * x, s1, c1);
    const Number s2 = 2.0 * s1 * c1, c2 = c1 * c1 - s1 * s1;
    const Number s3 = s2 * c1 + c2 * s1, c3 = c2 * c1 - s2 * s1;
    const Number s6 = 2.0 * s3 * c3, c6 = c3 * c3 - s3 * s3;
    const Number s12 = 2.0 * s6 * c6, c12 = c6 * c6 - s6 * s6;
    const Number harmonic[10] = {s1, c1, s2, c2, s3, c3, s6, c6, s12, c12};
    const auto b = spline_of(x * inverse_pitch);
    Number gathered[30];
    const Number* a = active<10>(b, cogging, gathered);
    Number sine = all(0.0), cosine = all(0.0);
    for (int i = 0; i < 10; i += 2) {
      sine += (b.w0 * a[i] + b.w1 * a[i + 10] + b.w2 * a[i + 20]) * harmonic[i];
      cosine += (b.w0 * a[i + 1] + b.w1 * a[i + 11] + b.w2 * a[i + 21]) * harmonic[i + 1];
    }
    const Number friction = plant_viscous * v + plant_coulomb * Register::atan(v * inverse_width);
    return (u - friction - (sine + cosine)) * inverse_mass;
  };

  Number mass = all(q.mass), viscous = all(q.viscous), coulomb = all(q.coulomb), disturbance = all(0.0);  // estimates
  Number estimate[6 * control_points] = {};
  Number x = all(reference_position[0]), v = all(0.0), reading_previous = all(0.0);
  for (int k = 0; k < rows; ++k) {
    const Number reading = q.resolution * Register::round(x / q.resolution);
    const Number measured_velocity = k == 0 ? all(0.0) : (reading - reading_previous) * q.sample_rate;
    reading_previous = reading;

    const double xd = reference_position[k], vd = reference_velocity[k], ad = reference_acceleration[k];
    const Number p = measured_velocity - vd + q.error_gain * (reading - xd);
    double s1, c1;
    Scalar::sin_cos(wavenumber * xd, s1, c1);
    const double s2 = 2.0 * s1 * c1, c2 = c1 * c1 - s1 * s1;
    const double harmonic[6] = {s1, c1, s2, c2, s2 * c1 + c2 * s1, c2 * c1 - s2 * s1};
    const Spline b = spline(xd * inverse_pitch);
    Number* a = estimate + 6 * b.first;
    Number cogging_estimate = all(0.0);
    for (int i = 0; i < 6; ++i) cogging_estimate += (b.w0 * a[i] + b.w1 * a[i + 6] + b.w2 * a[i + 12]) * harmonic[i];
    const double direction = two_over_pi * Scalar::atan(vd * inverse_width);
    const Number u =
        mass * ad + viscous * vd + coulomb * direction - disturbance + cogging_estimate - q.feedback_gain * p;

    const Number step = h * p;
    mass = clamp_of(mass - q.mass_adaptation * ad * step, q.mass_min, q.mass_max);
    viscous = clamp_of(viscous - q.viscous_adaptation * vd * step, q.viscous_min, q.viscous_max);
    coulomb = clamp_of(coulomb - q.coulomb_adaptation * direction * step, q.coulomb_min, q.coulomb_max);
    disturbance = clamp_of(disturbance + q.disturbance_adaptation * step, q.disturbance_min, q.disturbance_max);
    for (int i = 0; i < 6; ++i) {
      const Number change = -q.cogging_adaptation * step * harmonic[i];
      a[i] = clamp_of(a[i] + b.w0 * change, q.cogging_min, q.cogging_max);
      a[i + 6] = clamp_of(a[i + 6] + b.w1 * change, q.cogging_min, q.cogging_max);
      a[i + 12] = clamp_of(a[i + 12] + b.w2 * change, q.cogging_min, q.cogging_max);
    }

    store(position, rows, k, reading), store(command, rows, k, u);
    store(true_position, rows, k, x), store(true_velocity, rows, k, v);

    const Number a1 = acceleration(x, v, u);
    const Number v2 = v + 0.5 * h * a1, a2 = acceleration(x + 0.5 * h * v, v2, u);
    const Number v3 = v + 0.5 * h * a2, a3 = acceleration(x + 0.5 * h * v2, v3, u);
    const Number v4 = v + h * a3, a4 = acceleration(x + h * v3, v4, u);
    x += h / 6.0 * (v + 2.0 * (v2 + v3) + v4);
    v += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4);
  }
}
