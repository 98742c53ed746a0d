"""Which names the search gives machines that lack two large effects.

Each of COUNT machines is the axis of the tests of `diagnose` with two laws, drawn with their sizes: each makes a good part
of the command. A row is right where the search names the two and nothing else, up to alternatives. A wrong name has a
probability of 0.95 or more, and no hidden law among its alternatives. With --strokes each log has strokes of one speed.
"""

import argparse
import sys

import numpy as np

import cogging
from cogging.diagnosis.balance.decision import search
from cogging.resources import on_one_blas_thread
from cogging_command import run_command
from tests.fixtures import moving_axis

ENDS = [-0.15, 0.15]  # m
NODES = [-0.15, -0.05, 0.05, 0.15]


def drawn(random):
    """A law of each kind, of some 3 to 12 V."""
    size, other = random.uniform(3.0, 12.0) * random.choice([-1.0, 1.0]), random.uniform(-3.0, 3.0)
    return {
        "constant_force": {"force": size},
        "cable_spring": {"stiffness": 12.0 * abs(size), "center": random.uniform(-0.1, 0.1)},
        "end_effect": {"force": 2.0 * size, "decay_length": random.uniform(0.02, 0.05), "travel": ENDS},
        "local_force": {"force": size, "center": random.uniform(-0.08, 0.08), "width": random.uniform(0.005, 0.03)},
        "cogging_harmonic": {"period": random.uniform(0.035, 0.08), "sine": size, "cosine": other},
        "coulomb_asymmetry": {"difference": size},
        "viscous_asymmetry": {"difference": 5.0 * size},
        "position_dependent_friction": {"nodes": NODES, "levels": random.uniform(0.0, abs(size), 4).tolist()},
        "quadratic_drag": {"coefficient": 15.0 * abs(size)},
        "force_constant_drift": {"change": random.uniform(0.5, 2.0), "time_constant": random.uniform(1.0, 4.0)},
        "command_dead_zone": {"width": abs(size)},
        "disturbance_step": {"force": size, "start": random.uniform(1.0, 3.0), "stop": random.uniform(4.0, 7.0)},
        "disturbance_tone": {"frequency": np.exp(random.uniform(-1.5, 3.0)), "sine": size, "cosine": other},
    }


@on_one_blas_thread(scipy=True)
def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=48, metavar="COUNT")
    parser.add_argument("--strokes", action="store_true")
    given, right, found, wrong = parser.parse_args(), 0, 0, 0
    plain = moving_axis.machine()
    stated = plain.replace(axis=plain.axis.replace(mass=2.02, coulomb=1.6, coulomb_width=3e-3))
    for seed in range(given.count):
        random = np.random.default_rng(seed)
        laws = [drawn(random) for _ in range(2)]
        true = random.choice(list(laws[0]), 2, replace=False).tolist()
        hidden = [cogging.EFFECTS[name](**law[name]) for name, law in zip(true, laws, strict=True)]
        machine = moving_axis.machine(hidden)
        logs = []
        for one in (1000 + 10 * seed + k for k in (1, 2)):
            speed = np.exp(random.uniform(np.log(0.1), np.log(0.5)))
            logs.append(moving_axis.record(machine, one, moving_axis.strokes(speed, 0.24) if given.strokes else None))
        accepted = search(logs[:1], logs[1:], stated).accepted
        names = [{a.found.name, *(name for name, _ in a.alternatives)} for a in accepted]
        met = sum(any(name in own for own in names) for name in true)
        false = sum(a.share >= 0.95 and not own & set(true) for a, own in zip(accepted, names, strict=True))
        right, found, wrong = right + (met == 2 == len(names)), found + met, wrong + false
        said = ", ".join(f"{a.found.name} {a.share:.2f}" for a in accepted)
        print(f"{seed}: {' + '.join(true)}: {said}", flush=True)
    print(f"exactly the two names: {right} of {given.count}; named: {found} of {2 * given.count}; wrong names: {wrong}")
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main))
