// The loop of hand_written.cpp for many machines side by side, written by hand for this one case with the compiler's
// vector types: what the lanes of the core are measured against. One pack of LANES machines: each has its own mass,
// viscous and Coulomb friction and cogging; reference, gains and bounds are shared.

#include <cmath>
#include <cstdint>

#include "hand_written.cpp"

#ifndef LANES
#define LANES 8
#endif

namespace {

typedef double Pack __attribute__((vector_size(LANES * sizeof(double))));
typedef std::int64_t Mask __attribute__((vector_size(LANES * sizeof(double))));

const Mask sign_bit = Mask{} + INT64_MIN;

Pack trunc_of(Pack a) {
  // Exact below 2^51; what is rounded here is some 1e6 counts.
  const Pack shift = 6755399441055744.0 - Pack{};
  const Pack size = (Pack)((Mask)a & ~sign_bit), near = (size + shift) - shift;
  const Pack down = near > size ? near - 1.0 : near;
  return (Pack)((Mask)down | ((Mask)a & sign_bit));
}

Pack clamp_of(Pack a, Pack low, Pack high) {
  a = low > a ? low : a;
  return high < a ? high : a;
}

bool all_of(Mask mask) {
  std::int64_t together = -1;
  for (int i = 0; i < LANES; ++i) together &= mask[i];
  return together != 0;
}

void sin_cos_of(Pack angle, Pack& sine, Pack& cosine) {
  const Pack shifted = angle * 0.63661977236758134308 + 6755399441055744.0, turns = shifted - 6755399441055744.0;
  const Mask quadrant = (Mask)shifted;
  const Pack r = ((angle - turns * 1.57079632673412561417) - turns * 6.07710050630396597660e-11) -
                 turns * 2.02226624879595063154e-21;
  const Pack z = r * r, half = 0.5 * z, rest = 1.0 - half;
  const Pack sine_r = r + r * z *
                              (-1.66666666666666324348e-01 +
                               z * (8.33333333332248946124e-03 +
                                    z * (-1.98412698298579493134e-04 +
                                         z * (2.75573137070700676789e-06 +
                                              z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
  const Pack cosine_r =
      rest + (((1.0 - rest) - half) +
              z * z *
                  (4.16666666666666019037e-02 +
                   z * (-1.38888888888741095749e-03 +
                        z * (2.48015872894767294178e-05 +
                             z * (-2.75573143513906633035e-07 +
                                  z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))))));
  const Mask odd = (quadrant & 1) != 0;
  sine = (Pack)((Mask)(odd ? cosine_r : sine_r) ^ ((quadrant & 2) << 62));
  cosine = (Pack)((Mask)(odd ? sine_r : cosine_r) ^ (((quadrant + 1) & 2) << 62));
}

Pack atan_of(Pack value) {
  const Pack x = (Pack)((Mask)value & ~sign_bit), one = 1.0 - Pack{}, zero = Pack{};
  const Mask b1 = x >= 0.4375, b2 = x >= 0.6875, b3 = x >= 1.1875, b4 = x >= 2.4375;
  const Pack above = b4 ? -one : b3 ? x - 1.5 : b2 ? x - 1.0 : b1 ? 2.0 * x - 1.0 : x;
  const Pack below = b4 ? x : b3 ? 1.0 + 1.5 * x : b2 ? x + 1.0 : b1 ? 2.0 + x : one;
  const Pack high = b4   ? 1.57079632679489655800e+00 + zero
                    : b3 ? 9.82793723247329054082e-01 + zero
                    : b2 ? 7.85398163397448278999e-01 + zero
                    : b1 ? 4.63647609000806093515e-01 + zero
                         : zero;
  const Pack low = b4   ? 6.12323399573676603587e-17 + zero
                   : b3 ? 1.39033110312309984516e-17 + zero
                   : b2 ? 3.06161699786838301793e-17 + zero
                   : b1 ? 2.26987774529616870924e-17 + zero
                        : zero;
  const Pack t = above / below, z = t * t, w = z * z;
  const Pack odd = z * (3.33333333333329318027e-01 +
                        w * (1.42857142725034663711e-01 +
                             w * (9.09088713343650656196e-02 +
                                  w * (6.66107313738753120669e-02 +
                                       w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const Pack even =
      w *
      (-1.99999999998764832476e-01 +
       w * (-1.11111104054623557880e-01 +
            w * (-7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  const Pack result = high - ((t * (odd + even) - low) - t);
  return value < 0.0 ? -result : result;
}

struct PackSpline {
  Pack first, w0, w1, w2;
};

PackSpline spline_of(Pack u) {
  u = clamp_of(u, Pack{}, double(spans) - Pack{});
  const Pack whole = trunc_of(u), first = whole > spans - 1.0 ? spans - 1.0 - Pack{} : whole;
  const Pack t = u - first, s = 1.0 - t;
  return {first, 0.5 * s * s, 0.5 + s * t, 0.5 * t * t};
}

struct Machines {
  Pack mass, viscous, coulomb;
  Pack cogging[10 * control_points];
};

// (sum_j w_j a_jq) harmonic_q; the machines are nearly always within one pitch of the magnets.
template <int columns>
Pack combine(const PackSpline& b, const Pack* table, const Pack* harmonic) {
  const Pack* a = table + columns * int(b.first[0]);
  Pack gathered[3 * columns];
  if (!all_of(b.first == b.first[0])) [[unlikely]] {
    for (int i = 0; i < 3 * columns; ++i)
      for (int lane = 0; lane < LANES; ++lane) gathered[i][lane] = table[columns * int(b.first[lane]) + i][lane];
    a = gathered;
  }
  Pack sine = Pack{}, cosine = Pack{};
  for (int i = 0; i < columns; i += 2) {
    sine += (b.w0 * a[i] + b.w1 * a[i + columns] + b.w2 * a[i + 2 * columns]) * harmonic[i];
    cosine += (b.w0 * a[i + 1] + b.w1 * a[i + 1 + columns] + b.w2 * a[i + 1 + 2 * columns]) * harmonic[i + 1];
  }
  return sine + cosine;
}

}  // namespace

// `machines`: LANES rows of mass, viscous, coulomb and the coefficients. The four columns of the result have a row a
// machine; `reference` has three rows.
extern "C" void lu2008_lanes(const Setup* setup, const double* machines, int rows, double* reference, double* position,
                             double* command, double* true_position, double* true_velocity) {
  const Setup& q = *setup;
  const double h = 1.0 / q.sample_rate, inverse_pitch = 1.0 / q.pitch, wavenumber = 2.0 * pi / q.pitch;
  const double inverse_width = 1.0 / q.coulomb_width, two_over_pi = 2.0 / pi;

  const PointToPoint motion{q};
  double *reference_velocity = reference + rows, *reference_acceleration = reference + 2 * rows;
  for (int k = 0; k < rows; ++k) {
    const ReferencePoint point = motion.at(k / q.sample_rate);
    reference[k] = point.position, reference_velocity[k] = point.velocity;
    reference_acceleration[k] = point.acceleration;
  }

  static thread_local Machines m;
  for (int lane = 0; lane < LANES; ++lane) {
    const double* one = machines + lane * (3 + 10 * control_points);
    m.mass[lane] = one[0], m.viscous[lane] = one[1], m.coulomb[lane] = one[2];
    for (int c = 0; c < 10 * control_points; ++c) m.cogging[c][lane] = one[3 + c];
  }
  const Pack inverse_mass = 1.0 / m.mass;

  const auto acceleration = [&](Pack x, Pack v, Pack u) {
    Pack s1, c1;
    sin_cos_of(wavenumber * x, s1, c1);
    const Pack s2 = 2.0 * s1 * c1, c2 = c1 * c1 - s1 * s1;
    const Pack s3 = s2 * c1 + c2 * s1, c3 = c2 * c1 - s2 * s1;
    const Pack s6 = 2.0 * s3 * c3, c6 = c3 * c3 - s3 * s3;
    const Pack s12 = 2.0 * s6 * c6, c12 = c6 * c6 - s6 * s6;
    const Pack harmonic[10] = {s1, c1, s2, c2, s3, c3, s6, c6, s12, c12};
    const Pack force = combine<10>(spline_of(x * inverse_pitch), m.cogging, harmonic);
    const Pack friction = m.viscous * v + m.coulomb * two_over_pi * atan_of(v * inverse_width);
    return (u - friction - force) * inverse_mass;
  };

  Pack mass = q.mass - Pack{}, viscous = q.viscous - Pack{}, coulomb = q.coulomb - Pack{}, disturbance = Pack{};
  Pack estimate[6 * control_points] = {};
  Pack x = reference[0] - Pack{}, v = Pack{}, reading_previous = Pack{};
  for (int k = 0; k < rows; ++k) {
    const Pack counts = x / q.resolution;
    const Pack below_half = 0.49999999999999994 - Pack{};
    const Pack reading = q.resolution * trunc_of(counts + (Pack)((Mask)below_half | ((Mask)counts & sign_bit)));
    const Pack measured_velocity = k == 0 ? Pack{} : (reading - reading_previous) * q.sample_rate;
    reading_previous = reading;

    const double xd = reference[k], vd = reference_velocity[k], ad = reference_acceleration[k];
    const Pack p = measured_velocity - vd + q.error_gain * (reading - xd);
    double s1, c1;
    functions::sin_cos(wavenumber * xd, s1, c1);
    const double s2 = 2.0 * s1 * c1, c2 = c1 * c1 - s1 * s1;
    const double harmonic[6] = {s1, c1, s2, c2, s2 * c1 + c2 * s1, c2 * c1 - s2 * s1};
    const Spline b = spline(xd * inverse_pitch);
    Pack* a = estimate + 6 * b.first;
    Pack cogging_estimate = Pack{};
    for (int i = 0; i < 6; ++i) cogging_estimate += (b.w0 * a[i] + b.w1 * a[i + 6] + b.w2 * a[i + 12]) * harmonic[i];
    const double direction = two_over_pi * functions::atan(vd * inverse_width);
    const Pack u =
        mass * ad + viscous * vd + coulomb * direction - disturbance + cogging_estimate - q.feedback_gain * p;

    const Pack step = h * p;
    const auto adapt = [&](Pack& value, Pack change, double low, double high) {
      value = clamp_of(value + change, low - Pack{}, high - Pack{});
    };
    adapt(mass, -q.mass_adaptation * ad * step, q.mass_min, q.mass_max);
    adapt(viscous, -q.viscous_adaptation * vd * step, q.viscous_min, q.viscous_max);
    adapt(coulomb, -q.coulomb_adaptation * direction * step, q.coulomb_min, q.coulomb_max);
    adapt(disturbance, q.disturbance_adaptation * step, q.disturbance_min, q.disturbance_max);
    for (int i = 0; i < 6; ++i) {
      const Pack change = -q.cogging_adaptation * step * harmonic[i];
      adapt(a[i], b.w0 * change, q.cogging_min, q.cogging_max);
      adapt(a[i + 6], b.w1 * change, q.cogging_min, q.cogging_max);
      adapt(a[i + 12], b.w2 * change, q.cogging_min, q.cogging_max);
    }

    for (int lane = 0; lane < LANES; ++lane) {
      position[lane * rows + k] = reading[lane], command[lane * rows + k] = u[lane];
      true_position[lane * rows + k] = x[lane], true_velocity[lane * rows + k] = v[lane];
    }

    const Pack a1 = acceleration(x, v, u);
    const Pack v2 = v + 0.5 * h * a1, a2 = acceleration(x + 0.5 * h * v, v2, u);
    const Pack v3 = v + 0.5 * h * a2, a3 = acceleration(x + 0.5 * h * v2, v3, u);
    const Pack v4 = v + h * a3, a4 = acceleration(x + h * v3, v4, u);
    x += h / 6.0 * (v + 2.0 * (v2 + v3) + v4);
    v += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4);
  }
}
