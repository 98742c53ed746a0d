"""Many runs of one closed loop: the core beside other libraries that run such loops, on the same machines.

The problem: a PID controller at 5 kHz holds an axis with cogging (three harmonics) and smooth friction on a motion; one
Runge-Kutta step of order 4 a sample with the command held. Machines are drawn. Each library does the same arithmetic,
written once below, in its own idiom (numba: a loop over runs; JAX: vmap of lax.scan; CasADi: map of a fold; numpy: rows
over all runs at once). The position at the end and the rms error of every
run are compared with the core's before anything is timed. Each library runs in a process of its own, on one thread, in
turns, few runs before many; the time of the first call beyond a later one (compilation) and the peak memory of the
process are listed beside.
"""

from __future__ import annotations

import importlib.util
import math
import os
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.benchmarks import child

RATE, SECONDS = 5000.0, 0.4  # Hz; s of one move there and back
HARMONICS, PITCH, WIDTH = (1, 2, 3), 0.03, 1.0 / 900.0
KP, KI, KD = 9600.0, 1e5, 48.0
CLOSE = 1e-6  # m
LONG = 1.0  # s, of a call that is timed once in a round


@dataclass(frozen=True)
class Problem:
    """Machines and the motion.

    Attributes:
        machines: mass, viscous, coulomb, then sine and cosine of each harmonic, (runs, 9).
        reference: position and acceleration at each sample, (rows, 2).
    """

    machines: np.ndarray
    reference: np.ndarray

    @classmethod
    def drawn(cls, runs: int, rows: int) -> Problem:
        """The first machines of one seed."""
        random = np.random.default_rng(8)
        size = np.array([0.12, 0.17, 0.15]) * np.exp(random.uniform(-0.3, 0.3, (runs, 3)))
        waves = random.normal(0.0, [0.1, 0.1, 0.05, 0.05, 0.02, 0.02], (runs, 6))
        time = np.arange(rows) / RATE
        turn = 2.0 * np.pi / SECONDS
        position = 0.02 * (1.0 - np.cos(turn * time))
        return cls(np.hstack([size, waves]), np.stack([position, 0.02 * turn**2 * np.cos(turn * time)], axis=1))

    def answer(self, position: Any, squares: Any) -> Answer:
        """The answer from positions at the end and sums of squared errors over all samples but the last."""
        position = np.asarray(position)
        last = position - self.reference[-1, 0]
        return position, np.sqrt((np.asarray(squares) + last * last) / len(self.reference))


Answer = tuple[np.ndarray, np.ndarray]  # position at the end, m; rms error, m; one a run
Run = Callable[[], Answer]


def by_cogging(problem: Problem) -> Run:
    """cogging: a batch on one thread."""
    import cogging

    basis = cogging.SplineHarmonics(pitch=PITCH, harmonics=list(HARMONICS))
    plants, controllers = [], []
    for mass, viscous, coulomb, *waves in problem.machines:
        axis = cogging.AxisParameters(mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=WIDTH)
        map_of_force = cogging.CoggingModel(basis, np.array(waves[0::2])[:, None], np.array(waves[1::2])[:, None])
        plants.append(cogging.Plant(axis, cogging=map_of_force))
        controllers.append(cogging.Pid(cogging.PidParameters(sample_rate=RATE, kp=KP, ki=KI, kd=KD, mass=0.12)))
    position, acceleration = problem.reference.T
    motion = cogging.Sampled(np.arange(len(position)) / RATE, position, None, acceleration)
    kept = ["true_error_final", "true_error_rms"]

    def run() -> Answer:
        batch = cogging.closed_loop_batch(plants, controllers, motion, threads=1, reductions=kept)
        return position[-1] + batch.indexes["true_error_final"], batch.indexes["true_error_rms"]

    return run


def loop_of(sin: Any, cos: Any, atan: Any, compiled: Callable = lambda function: function) -> Callable:
    """One sample of the loop, of numbers, arrays or symbols."""

    @compiled
    def acceleration(machine, x, v, u):
        s1, c1 = sin(2.0 * math.pi / PITCH * x), cos(2.0 * math.pi / PITCH * x)
        s2, c2 = 2.0 * s1 * c1, c1 * c1 - s1 * s1
        s3, c3 = s2 * c1 + c2 * s1, c2 * c1 - s2 * s1
        force = machine[3] * s1 + machine[4] * c1 + machine[5] * s2 + machine[6] * c2
        force = force + machine[7] * s3 + machine[8] * c3
        friction = machine[1] * v + machine[2] * (2.0 / math.pi) * atan(v * (1.0 / WIDTH))
        return (u - friction - force) * (1.0 / machine[0])

    @compiled
    def sample(machine, state, at):
        h = 1.0 / RATE
        x, v, total, before, squares = state
        error = x - at[0]
        total = total + error * (1.0 / RATE)
        u = 0.12 * at[1] - KP * error - KI * total - KD * (error - before) * RATE
        a1 = acceleration(machine, x, v, u)
        v2 = v + 0.5 * h * a1
        a2 = acceleration(machine, x + 0.5 * h * v, v2, u)
        v3 = v + 0.5 * h * a2
        a3 = acceleration(machine, x + 0.5 * h * v2, v3, u)
        v4 = v + h * a3
        a4 = acceleration(machine, x + h * v3, v4, u)
        x_next = x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        return x_next, v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4), total, error, squares + error * error

    return sample


def by_numpy(problem: Problem) -> Run:
    """numpy: all runs of one row at once."""
    sample = loop_of(np.sin, np.cos, np.arctan)
    machines, nothing = problem.machines.T, np.zeros(len(problem.machines))

    def run() -> Answer:
        state = (nothing + problem.reference[0, 0], nothing, nothing, nothing, nothing)
        for at in problem.reference[:-1]:
            state = sample(machines, state, at)
        return problem.answer(state[0], state[4])

    return run


def by_numba(problem: Problem) -> Run:
    """numba: a compiled loop over runs and rows."""
    import numba

    sample = loop_of(math.sin, math.cos, math.atan, numba.njit)

    @numba.njit
    def loops(machines, reference):
        last, squares = np.empty(len(machines)), np.empty(len(machines))
        for i in range(len(machines)):
            state = (reference[0, 0], 0.0, 0.0, 0.0, 0.0)
            for k in range(len(reference) - 1):
                state = sample(machines[i], state, reference[k])
            last[i], squares[i] = state[0], state[4]
        return last, squares

    return lambda: problem.answer(*loops(problem.machines, problem.reference))


def by_jax(problem: Problem) -> Run:
    """JAX: vmap of a lax.scan, in 64 bits, on one thread."""
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    sample = loop_of(jnp.sin, jnp.cos, jnp.arctan)

    def one(machine: jax.Array, reference: jax.Array) -> tuple[jax.Array, jax.Array]:
        start = (reference[0, 0], 0.0, 0.0, 0.0, 0.0)
        state, _ = jax.lax.scan(lambda state, at: (sample(machine, state, at), None), start, reference[:-1])
        return state[0], state[4]

    many = jax.jit(jax.vmap(one, in_axes=(0, None)))
    machines, reference = jnp.asarray(problem.machines), jnp.asarray(problem.reference)
    return lambda: problem.answer(*many(machines, reference))


def by_casadi(problem: Problem) -> Run:
    """CasADi: a fold over the rows, mapped over the runs, by its own virtual machine."""
    import casadi

    sample = loop_of(casadi.sin, casadi.cos, casadi.atan)
    state, at, machine = casadi.SX.sym("state", 5), casadi.SX.sym("at", 2), casadi.SX.sym("machine", 9)
    after = casadi.vertcat(*sample(machine, casadi.vertsplit(state), at))
    rows, runs = len(problem.reference) - 1, len(problem.machines)
    rowed = casadi.Function("step", [state, at, machine], [after]).fold(rows)
    references, known = casadi.MX.sym("references", 2, rows), casadi.MX.sym("machine", 9)
    start = casadi.DM([problem.reference[0, 0], 0.0, 0.0, 0.0, 0.0])
    whole = casadi.Function("whole", [references, known], [rowed(start, references, casadi.repmat(known, 1, rows))])
    many = whole.map(runs, "serial")
    machines, along = problem.machines.T, casadi.repmat(casadi.DM(problem.reference[:-1].T), 1, runs)

    def run() -> Answer:
        ends = np.array(many(along, machines))
        return problem.answer(ends[0], ends[4])

    return run


PEERS = {"cogging": by_cogging, "numba": by_numba, "JAX": by_jax, "CasADi": by_casadi, "numpy": by_numpy}


def differences(names: list[str], runs: int, rows: int) -> dict[str, float]:
    """Largest difference of each answer from the core's, m."""
    problem = Problem.drawn(runs, rows)
    expected = by_cogging(problem)()
    answers = {name: PEERS[name](problem)() for name in names}
    return {name: float(np.abs(np.subtract(answer, expected)).max()) for name, answer in answers.items()}


# Timing ---------------------------------------------------------------------------------------------------------------


def measured(name: str, rows: int, repeats: int, counts: list[int]) -> list[dict[str, float]]:
    """For each number of runs: median seconds of all runs, seconds of the first call beyond that, peak MB so far."""
    found = []
    for runs in counts:
        problem = Problem.drawn(runs, rows)
        begin = time.perf_counter()
        run = PEERS[name](problem)
        run()
        first = time.perf_counter() - begin
        usual = child.measure({name: run}, 1 if first > LONG else repeats)[name]
        found.append({"seconds": usual, "compile": max(first - usual, 0.0), "megabytes": child.peak_megabytes()})
    return found


def figures(counts: list[int], rows: int, rounds: int, repeats: int) -> list[tuple[int, str, float, float, float]]:
    """Runs, library, time relative to the core, s to compile, peak MB; of each that gives the core's answer."""
    names = [name for name in PEERS if importlib.util.find_spec(name.lower()) is not None]
    off = child.call(differences, names, 8, min(rows, 501))
    wrong = {name: value for name, value in off.items() if value > CLOSE}
    if wrong:
        raise SystemExit(f"answers differ by more than {CLOSE:g} m, nothing is timed: {wrong}")
    print(f"the same answers: {max(off.values()):.1e} m at most\n")
    found: dict[tuple[int, str], list[dict[str, float]]] = {}
    for number in range(1, rounds + 1):
        for name in names:
            print(f"  round {number} of {rounds}: {name}", file=sys.stderr, flush=True)
            for runs, one in zip(counts, child.call(measured, name, rows, repeats, counts), strict=True):
                found.setdefault((runs, name), []).append(one)
    answer = []
    for (runs, name), some in sorted(found.items(), key=lambda one: counts.index(one[0][0])):
        of_core = statistics.median(one["seconds"] for one in found[runs, "cogging"])
        ratio = statistics.median(one["seconds"] for one in some) / of_core
        compiling = statistics.median(one["compile"] for one in some)
        answer.append((runs, name, ratio, compiling, max(one["megabytes"] for one in some)))
    return answer
