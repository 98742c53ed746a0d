"""Many runs of one closed loop: the core beside what else runs such loops, on the same machines, with the same answer.

    python -m tests.benchmarks.peers [--runs 1 100 2000] [--rows 2001] [--rounds 2]

The problem: a PID controller at 5 kHz holds an axis with cogging (three harmonics) and smooth friction on a motion; one
Runge-Kutta step of order 4 a sample with the command held. Machines are drawn. Each library does the same arithmetic
in its own idiom (numba: a loop over runs; JAX: vmap of lax.scan; CasADi: map of a fold; numpy: rows over all runs at
once; python-control and scipy: one run at a time). What each gives, the position at the end and the rms error of every
run, is compared with the core's before anything is timed. Each library runs in a process of its own, on one thread, in
turns, few runs before many; the time of the first call beyond a later one (compilation) and the most memory that the
process has held until then are listed beside.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.memory import peak_megabytes

ROOT = Path(__file__).resolve().parents[2]
RATE, SECONDS = 5000.0, 0.4  # Hz; s of one move there and back
HARMONICS, PITCH, WIDTH = (1, 2, 3), 0.03, 1.0 / 900.0
GAINS = (9600.0, 1e5, 48.0)  # kp, ki, kd
CLOSE = 1e-6  # m
ONE_BY_ONE = 3  # runs at most, of what takes seconds for one
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


Answer = tuple[np.ndarray, np.ndarray]  # position at the end, m; rms error, m; one a run
Run = Callable[[], Answer]


def core(problem: Problem) -> Run:
    """cogging: a batch on one thread."""
    import cogging

    kp, ki, kd = GAINS
    basis = cogging.SplineHarmonics(pitch=PITCH, harmonics=list(HARMONICS))
    plants, controllers = [], []
    for mass, viscous, coulomb, *waves in problem.machines:
        axis = cogging.AxisParameters(mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=WIDTH)
        cogged = cogging.CoggingModel(basis, np.array(waves[0::2])[:, None], np.array(waves[1::2])[:, None])
        plants.append(cogging.Plant(axis, cogging=cogged))
        controllers.append(cogging.Pid(cogging.PidParameters(sample_rate=RATE, kp=kp, ki=ki, kd=kd, mass=0.12)))
    position, acceleration = problem.reference.T
    moments = np.arange(len(position)) / RATE
    motion = cogging.Sampled(moments, position, None, acceleration)
    asked = ["true_error_final", "true_error_rms"]

    def run() -> Answer:
        batch = cogging.closed_loop_batch(plants, controllers, motion, threads=1, reductions=asked)
        return position[-1] + batch.indexes["true_error_final"], batch.indexes["true_error_rms"]

    return run


def after_a_sample(acceleration: Callable, x: Any, v: Any, u: Any) -> tuple[Any, Any]:
    """Position and velocity one sample later, by a Runge-Kutta step of order 4, of arrays or symbols."""
    h = 1.0 / RATE
    a1 = acceleration(x, v, u)
    v2 = v + 0.5 * h * a1
    a2 = acceleration(x + 0.5 * h * v, v2, u)
    v3 = v + 0.5 * h * a2
    a3 = acceleration(x + 0.5 * h * v2, v3, u)
    v4 = v + h * a3
    a4 = acceleration(x + h * v3, v4, u)
    return x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


def by_numpy(problem: Problem) -> Run:
    """numpy: all runs of one row at once."""
    return lambda: stepped(problem)


def stepped(problem: Problem) -> Answer:
    """The loop on arrays over the runs."""
    kp, ki, kd = GAINS
    mass, viscous, coulomb = problem.machines.T[:3]
    waves = problem.machines.T[3:]
    h = 1.0 / RATE

    def acceleration(x: np.ndarray, v: np.ndarray, u: np.ndarray) -> np.ndarray:
        force = viscous * v + coulomb * (2.0 / np.pi) * np.arctan(v / WIDTH)
        for i, n in enumerate(HARMONICS):
            angle = 2.0 * np.pi * n / PITCH * x
            force = force + waves[2 * i] * np.sin(angle) + waves[2 * i + 1] * np.cos(angle)
        return (u - force) / mass

    x, v = np.full(len(mass), problem.reference[0, 0]), np.zeros(len(mass))
    total, before, squares = np.zeros(len(mass)), None, np.zeros(len(mass))
    for k, (position, wanted) in enumerate(problem.reference):
        error = x - position
        squares = squares + error * error
        if k + 1 == len(problem.reference):
            break
        total = total + error * h
        rate = (error - (error if before is None else before)) * RATE
        before = error
        u = 0.12 * wanted - kp * error - ki * total - kd * rate
        x, v = after_a_sample(acceleration, x, v, u)
    return x, np.sqrt(squares / len(problem.reference))


def by_numba(problem: Problem) -> Run:
    """numba: a compiled loop over runs and rows."""
    from tests.benchmarks.peers_numba import loops

    def run() -> Answer:
        return loops(problem.machines, problem.reference, RATE, PITCH, WIDTH, GAINS)

    return run


def by_jax(problem: Problem) -> Run:
    """JAX: vmap of a lax.scan, in 64 bits, on one thread."""
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    kp, ki, kd = GAINS
    h = 1.0 / RATE
    harmonics = jnp.array(HARMONICS, dtype=float)

    def one(machine: jax.Array, reference: jax.Array) -> tuple[jax.Array, jax.Array]:
        mass, viscous, coulomb = machine[0], machine[1], machine[2]
        sines, cosines = machine[3::2], machine[4::2]

        def acceleration(x: jax.Array, v: jax.Array, u: jax.Array) -> jax.Array:
            angles = 2.0 * jnp.pi / PITCH * harmonics * x
            cogging = jnp.sum(sines * jnp.sin(angles) + cosines * jnp.cos(angles))
            return (u - viscous * v - coulomb * (2.0 / jnp.pi) * jnp.arctan(v / WIDTH) - cogging) / mass

        def row(state: tuple, at: jax.Array) -> tuple[tuple, None]:
            x, v, total, before, squares = state
            error = x - at[0]
            total = total + error * h
            u = 0.12 * at[1] - kp * error - ki * total - kd * (error - before) * RATE
            x, v = after_a_sample(acceleration, x, v, u)
            return (x, v, total, error, squares + error * error), None

        start = (reference[0, 0], 0.0, 0.0, 0.0, 0.0)
        (x, _, _, _, squares), _ = jax.lax.scan(row, start, reference[:-1])
        return x, jnp.sqrt((squares + (x - reference[-1, 0]) ** 2) / len(reference))

    many = jax.jit(jax.vmap(one, in_axes=(0, None)))
    machines, reference = jnp.asarray(problem.machines), jnp.asarray(problem.reference)

    def run() -> Answer:
        x, rms = many(machines, reference)
        return np.asarray(x), np.asarray(rms)

    return run


def by_casadi(problem: Problem) -> Run:
    """CasADi: a fold over the rows, mapped over the runs, by its own virtual machine."""
    import casadi

    kp, ki, kd = GAINS
    h = 1.0 / RATE
    state, at, machine = casadi.SX.sym("state", 5), casadi.SX.sym("at", 2), casadi.SX.sym("machine", 9)
    x, v, total, before, squares = casadi.vertsplit(state)

    def acceleration(x: casadi.SX, v: casadi.SX, u: casadi.SX) -> casadi.SX:
        force = machine[1] * v + machine[2] * (2.0 / np.pi) * casadi.atan(v / WIDTH)
        for i, n in enumerate(HARMONICS):
            angle = 2.0 * np.pi * n / PITCH * x
            force += machine[3 + 2 * i] * casadi.sin(angle) + machine[4 + 2 * i] * casadi.cos(angle)
        return (u - force) / machine[0]

    error = x - at[0]
    summed = total + error * h
    u = 0.12 * at[1] - kp * error - ki * summed - kd * (error - before) * RATE
    after = casadi.vertcat(
        *after_a_sample(acceleration, x, v, u),
        summed,
        error,
        squares + error * error,
    )
    step = casadi.Function("step", [state, at, machine], [after])
    rows, runs = len(problem.reference) - 1, len(problem.machines)
    rowed = step.fold(rows)
    references, known = casadi.MX.sym("references", 2, rows), casadi.MX.sym("machine", 9)
    start = casadi.DM([problem.reference[0, 0], 0.0, 0.0, 0.0, 0.0])
    whole = casadi.Function("whole", [references, known], [rowed(start, references, casadi.repmat(known, 1, rows))])
    many = whole.map(runs, "serial")
    machines, along = problem.machines.T, problem.reference[:-1].T

    def run() -> Answer:
        ends = np.array(many(casadi.repmat(casadi.DM(along), 1, runs), machines))
        last = ends[0] - problem.reference[-1, 0]
        return ends[0], np.sqrt((ends[4] + last * last) / len(problem.reference))

    return run


def by_scipy(problem: Problem) -> Run:
    """scipy: solve_ivp (RK45 at 1e-9) over each sample, one run after the other."""
    from scipy.integrate import solve_ivp

    kp, ki, kd = GAINS

    def one(machine: np.ndarray) -> tuple[float, float]:
        rates = rates_of(machine)
        state, total, before, squares = np.array([problem.reference[0, 0], 0.0]), 0.0, None, 0.0
        for k, (position, wanted) in enumerate(problem.reference):
            error = float(state[0]) - position
            squares += error * error
            if k + 1 == len(problem.reference):
                break
            total += error / RATE
            rate = (error - (error if before is None else before)) * RATE
            before = error
            u = 0.12 * wanted - kp * error - ki * total - kd * rate
            over = (k / RATE, (k + 1) / RATE)
            state = solve_ivp(lambda _, s, u=u: rates(s, u), over, state, rtol=1e-9, atol=1e-12).y[:, -1]
        return float(state[0]), float(np.sqrt(squares / len(problem.reference)))

    return lambda: tuple(np.array([one(machine) for machine in problem.machines]).T)


def rates_of(machine: np.ndarray) -> Callable[[np.ndarray, float], list[float]]:
    """Derivative of position and velocity under a command."""
    import math

    mass, viscous, coulomb, *waves = machine

    def rates(state: np.ndarray, u: float) -> list[float]:
        x, v = float(state[0]), float(state[1])
        force = viscous * v + coulomb * (2.0 / math.pi) * math.atan(v / WIDTH)
        for i, n in enumerate(HARMONICS):
            angle = 2.0 * math.pi * n / PITCH * x
            force += waves[2 * i] * math.sin(angle) + waves[2 * i + 1] * math.cos(angle)
        return [v, (u - force) / mass]

    return rates


def by_control(problem: Problem) -> Run:
    """python-control: a nonlinear system in discrete time, one run after the other."""
    import control

    kp, ki, kd = GAINS
    h = 1.0 / RATE

    def one(machine: np.ndarray) -> tuple[float, float]:
        rates = rates_of(machine)

        def after(_: float, state: np.ndarray, at: np.ndarray, __: dict) -> np.ndarray:
            error = state[0] - at[0]
            total = state[2] + error * h
            u = 0.12 * at[1] - kp * error - ki * total - kd * (error - state[3]) * RATE
            s = state[:2]
            k1 = np.array(rates(s, u))
            k2 = np.array(rates(s + 0.5 * h * k1, u))
            k3 = np.array(rates(s + 0.5 * h * k2, u))
            k4 = np.array(rates(s + h * k3, u))
            moved = s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            return np.array([*moved, total, error])

        loop = control.nlsys(after, lambda _, state, at, __: state[0], inputs=2, outputs=1, states=4, dt=h)
        moments = np.arange(len(problem.reference)) * h
        start = [problem.reference[0, 0], 0.0, 0.0, 0.0]
        found = control.input_output_response(loop, moments, problem.reference.T, start)
        error = np.ravel(found.outputs) - problem.reference[:, 0]
        return float(np.ravel(found.outputs)[-1]), float(np.sqrt(np.mean(error**2)))

    return lambda: tuple(np.array([one(machine) for machine in problem.machines]).T)


PEERS: dict[str, tuple[Callable[[Problem], Run], str]] = {
    "cogging": (core, "cogging"),
    "numba": (by_numba, "numba"),
    "JAX": (by_jax, "jax"),
    "CasADi": (by_casadi, "casadi"),
    "numpy": (by_numpy, "numpy"),
    "python-control": (by_control, "control"),
    "scipy": (by_scipy, "scipy"),
}
SLOW = ("python-control", "scipy")  # seconds a run: one alone is timed


def installed() -> list[str]:
    """The peers that are there."""
    return [name for name, (_, module) in PEERS.items() if importlib.util.find_spec(module) is not None]


def differences(names: list[str], runs: int, rows: int) -> dict[str, float]:
    """By how much each answer is off the core's at most, m: of what takes seconds a run, the first runs alone."""
    problem = Problem.drawn(runs, rows)
    expected = core(problem)()
    found = {}
    for name in names:
        count = min(runs, ONE_BY_ONE) if name in SLOW else runs
        answer = PEERS[name][0](Problem(problem.machines[:count], problem.reference))()
        found[name] = max(float(np.abs(a - b[:count]).max()) for a, b in zip(answer, expected, strict=True))
    return found


# Timing ---------------------------------------------------------------------------------------------------------------


def measured(name: str, rows: int, repeats: int, counts: list[int]) -> list[dict[str, float]]:
    """Seconds of all runs, median; of the first call beyond that; most MB held so far: for each number of runs."""
    found = []
    for runs in counts:
        problem, seconds = Problem.drawn(runs, rows), []
        begin = time.perf_counter()
        run = PEERS[name][0](problem)
        run()
        first = time.perf_counter() - begin
        for _ in range(1 if first > LONG else repeats):
            begin = time.perf_counter()
            run()
            seconds.append(time.perf_counter() - begin)
        usual = statistics.median(seconds)
        found.append({"seconds": usual, "compile": max(first - usual, 0.0), "megabytes": peak_megabytes()})
    return found


def in_a_process(*arguments: object) -> Any:
    """What this module prints for these arguments, in a process of its own, on one thread."""
    alone = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
    command = [sys.executable, "-m", "tests.benchmarks.peers", *map(str, arguments)]
    done = subprocess.run(command, cwd=ROOT, env={**os.environ, **alone}, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


@dataclass(frozen=True)
class Figure:
    """What a library takes for so many runs: ns a step and run, its ratio to the core, s to compile, most MB held."""

    name: str
    runs: int
    step: float
    ratio: float
    compile: float
    megabytes: float


def figures(counts: list[int], rows: int, rounds: int, repeats: int) -> list[Figure]:
    """Of all that are installed, once their answers are seen to be the core's."""
    names = installed()
    off = in_a_process("--compare", 8, min(rows, 501))
    wrong = {name: value for name, value in off.items() if value > CLOSE}
    if wrong:
        raise SystemExit(f"answers differ by more than {CLOSE:g} m, nothing is timed: {wrong}")
    print(f"the same answers: {max(off.values()):.1e} m at most\n")
    found: dict[tuple[str, int], list[dict[str, float]]] = {}
    for number in range(1, rounds + 1):
        for name in names:
            print(f"  round {number} of {rounds}: {name}", file=sys.stderr, flush=True)
            asked = [runs for runs in counts if name not in SLOW or runs == 1]
            for runs, one in zip(asked, in_a_process("--alone", name, rows, repeats, *asked), strict=True):
                found.setdefault((name, runs), []).append(one)
    usual = {which: statistics.median(one["seconds"] for one in some) for which, some in found.items()}
    return [
        Figure(
            name,
            runs,
            1e9 * usual[name, runs] / runs / (rows - 1),
            usual[name, runs] / usual["cogging", runs],
            statistics.median(one["compile"] for one in found[name, runs]),
            max(one["megabytes"] for one in found[name, runs]),
        )
        for runs in counts
        for name in names
        if (name, runs) in found
    ]


def table(found: list[Figure]) -> list[str]:
    """Lines of it."""
    lines = [f"{'':16}{'runs':>7}{'ns a step':>11}{'/ cogging':>11}{'compile, s':>12}{'peak, MB':>10}"]
    for one in found:
        numbers = f"{one.step:11.1f}{one.ratio:11.2f}{one.compile:12.2f}{one.megabytes:10.0f}"
        lines.append(f"{one.name:16}{one.runs:7}{numbers}")
    return lines


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, nargs="+", default=[1, 100, 2000])
    parser.add_argument("--rows", type=int, default=2001)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--alone", nargs="+", metavar="NAME ROWS REPEATS RUNS", help=argparse.SUPPRESS)
    parser.add_argument("--compare", nargs="+", metavar="RUNS ROWS NAMES", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.compare is not None:
        runs, rows, *names = options.compare
        print(json.dumps(differences(names or installed(), int(runs), int(rows))))
        return
    if options.alone is not None:
        name, rows, repeats, *counts = options.alone
        print(json.dumps(measured(name, int(rows), int(repeats), list(map(int, counts)))))
        return
    print("\n".join(table(figures(options.runs, options.rows, options.rounds, options.repeats))))


if __name__ == "__main__":
    main()
