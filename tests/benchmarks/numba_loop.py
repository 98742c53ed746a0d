"""The loop of hand_written.cpp in Python, compiled by numba: the same arithmetic line by line."""

import math

import numba
import numpy as np

SPANS = 11


@numba.njit
def clamp(value, lower, upper):
    return lower if value < lower else (upper if value > upper else value)


@numba.njit
def first_half(q, ramp, t):
    a, v, jerk = q.acceleration, q.velocity, q.jerk
    jerk_time = a / jerk
    if t < jerk_time:
        return jerk * t * t * t / 6.0, 0.5 * jerk * t * t, jerk * t
    if t < ramp - jerk_time:
        s, v0 = t - jerk_time, 0.5 * a * jerk_time
        return a * jerk_time * jerk_time / 6.0 + v0 * s + 0.5 * a * s * s, v0 + a * s, a
    if t < ramp:
        s = ramp - t
        return 0.5 * v * ramp - v * s + jerk * s * s * s / 6.0, v - 0.5 * jerk * s * s, jerk * s
    return 0.5 * v * ramp + v * (t - ramp), v, 0.0


@numba.njit
def reference_at(q, time):
    ramp = q.velocity / q.acceleration + q.acceleration / q.jerk
    move = ramp + q.distance / q.velocity
    period = 2.0 * (move + q.dwell)
    if time <= 0.0 or time >= q.repeats * period:
        return q.start, 0.0, 0.0
    t = time % period
    back = t >= 0.5 * period
    if back:
        t -= 0.5 * period
    if t >= move:
        return q.start if back else q.start + q.distance, 0.0, 0.0
    x, v, a = first_half(q, ramp, min(t, move - t))
    if t > 0.5 * move:
        x, a = q.distance - x, -a
    return (q.start + q.distance - x, -v, -a) if back else (q.start + x, v, a)


@numba.njit
def spline(u):
    u = clamp(u, 0.0, float(SPANS))
    span = min(int(u), SPANS - 1)
    t = u - span
    s = 1.0 - t
    return span, 0.5 * s * s, 0.5 + s * t, 0.5 * t * t


@numba.njit
def acceleration(q, cogging, x, v, u):
    angle = 2.0 * math.pi / q.pitch * x
    s1, c1 = math.sin(angle), math.cos(angle)
    s2, c2 = 2.0 * s1 * c1, c1 * c1 - s1 * s1
    s3, c3 = s2 * c1 + c2 * s1, c2 * c1 - s2 * s1
    s6, c6 = 2.0 * s3 * c3, c3 * c3 - s3 * s3
    s12, c12 = 2.0 * s6 * c6, c6 * c6 - s6 * s6
    sines, cosines = (s1, s2, s3, s6, s12), (c1, c2, c3, c6, c12)
    first, w0, w1, w2 = spline(x * (1.0 / q.pitch))
    force = 0.0
    for i in range(5):
        sine, cosine = 2 * i, 2 * i + 1
        force += (w0 * cogging[first, sine] + w1 * cogging[first + 1, sine] + w2 * cogging[first + 2, sine]) * sines[i]
        force += (
            w0 * cogging[first, cosine] + w1 * cogging[first + 1, cosine] + w2 * cogging[first + 2, cosine]
        ) * cosines[i]
    friction = q.viscous * v + q.coulomb * (2.0 / math.pi) * math.atan(v * (1.0 / q.coulomb_width))
    return (u - friction - force) * (1.0 / q.mass)


@numba.njit
def lu2008_loop(
    q,
    cogging,
    time,
    reference,
    reference_velocity,
    reference_acceleration,
    position,
    command,
    true_position,
    true_velocity,
):
    h = 1.0 / q.sample_rate
    rows = len(time)
    for k in range(rows):
        time[k] = k / q.sample_rate
        reference[k], reference_velocity[k], reference_acceleration[k] = reference_at(q, time[k])

    mass, viscous, coulomb, disturbance = q.mass, q.viscous, q.coulomb, 0.0
    estimate = np.zeros((SPANS + 2, 6))
    x, v, reading_previous = reference[0], 0.0, 0.0
    for k in range(rows):
        counts = x / q.resolution
        reading = q.resolution * math.copysign(math.floor(abs(counts) + 0.5), counts)
        measured_velocity = 0.0 if k == 0 else (reading - reading_previous) * q.sample_rate
        reading_previous = reading

        xd, vd, ad = reference[k], reference_velocity[k], reference_acceleration[k]
        p = measured_velocity - vd + q.error_gain * (reading - xd)
        angle = 2.0 * math.pi / q.pitch * xd
        s1, c1 = math.sin(angle), math.cos(angle)
        s2, c2 = 2.0 * s1 * c1, c1 * c1 - s1 * s1
        harmonic = (s1, c1, s2, c2, s2 * c1 + c2 * s1, c2 * c1 - s2 * s1)
        first, w0, w1, w2 = spline(xd * (1.0 / q.pitch))
        cogging_estimate = 0.0
        for i in range(6):
            cogging_estimate += (
                w0 * estimate[first, i] + w1 * estimate[first + 1, i] + w2 * estimate[first + 2, i]
            ) * harmonic[i]
        direction = 2.0 / math.pi * math.atan(vd * (1.0 / q.coulomb_width))
        u = mass * ad + viscous * vd + coulomb * direction - disturbance + cogging_estimate
        u -= q.feedback_gain * p

        step = h * p
        mass = clamp(mass - q.mass_adaptation * ad * step, q.mass_min, q.mass_max)
        viscous = clamp(viscous - q.viscous_adaptation * vd * step, q.viscous_min, q.viscous_max)
        coulomb = clamp(coulomb - q.coulomb_adaptation * direction * step, q.coulomb_min, q.coulomb_max)
        disturbance = clamp(disturbance + q.disturbance_adaptation * step, q.disturbance_min, q.disturbance_max)
        for i in range(6):
            change = -q.cogging_adaptation * step * harmonic[i]
            for j, weight in enumerate((w0, w1, w2)):
                moved = estimate[first + j, i] + weight * change
                estimate[first + j, i] = clamp(moved, q.cogging_min, q.cogging_max)

        position[k] = reading
        command[k] = u
        true_position[k] = x
        true_velocity[k] = v

        a1 = acceleration(q, cogging, x, v, u)
        v2 = v + 0.5 * h * a1
        a2 = acceleration(q, cogging, x + 0.5 * h * v, v2, u)
        v3 = v + 0.5 * h * a2
        a3 = acceleration(q, cogging, x + 0.5 * h * v2, v3, u)
        v4 = v + h * a3
        a4 = acceleration(q, cogging, x + h * v3, v4, u)
        x += h / 6.0 * (v + 2.0 * (v2 + v3) + v4)
        v += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
