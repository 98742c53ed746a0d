"""The loop of peers.py in Python, compiled by numba: over runs and rows, scalars alone."""

import math

import numba
import numpy as np


@numba.njit
def acceleration(machine, x, v, u, wave, width):
    s1, c1 = math.sin(wave * x), math.cos(wave * x)
    s2, c2 = 2.0 * s1 * c1, c1 * c1 - s1 * s1
    s3, c3 = s2 * c1 + c2 * s1, c2 * c1 - s2 * s1
    cogging = machine[3] * s1 + machine[4] * c1 + machine[5] * s2 + machine[6] * c2 + machine[7] * s3 + machine[8] * c3
    friction = machine[1] * v + machine[2] * (2.0 / math.pi) * math.atan(v * (1.0 / width))
    return (u - friction - cogging) * (1.0 / machine[0])


@numba.njit
def loops(machines, reference, sample_rate, pitch, width, gains):
    """Position at the end and rms error of each run."""
    kp, ki, kd = gains
    h, wave, rows = 1.0 / sample_rate, 2.0 * math.pi / pitch, len(reference)
    last, rms = np.empty(len(machines)), np.empty(len(machines))
    for i in range(len(machines)):
        machine = machines[i]
        x, v, total, before, squares = reference[0, 0], 0.0, 0.0, 0.0, 0.0
        for k in range(rows):
            error = x - reference[k, 0]
            squares += error * error
            if k + 1 == rows:
                break
            total += error * h
            u = 0.12 * reference[k, 1] - kp * error - ki * total - kd * (error - before) * sample_rate
            before = error
            a1 = acceleration(machine, x, v, u, wave, width)
            v2 = v + 0.5 * h * a1
            a2 = acceleration(machine, x + 0.5 * h * v, v2, u, wave, width)
            v3 = v + 0.5 * h * a2
            a3 = acceleration(machine, x + 0.5 * h * v2, v3, u, wave, width)
            v4 = v + h * a3
            a4 = acceleration(machine, x + h * v3, v4, u, wave, width)
            x, v = x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        last[i], rms[i] = x, math.sqrt(squares / rows)
    return last, rms
