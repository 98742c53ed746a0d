"""Which names the search gives machines that lack two large effects: `python -m studies.diagnosis.two_effects [SEEDS]`.

Each pair stands on the axis of the tests of `diagnose`, whose motions and noise belong to a seed (0 to SEEDS - 1; 4 by
default). The two effects make most of the command. A row is right where the search names the two and nothing else.
"""

import sys

import cogging
from cogging.diagnosis.balance.decision import search
from cogging_command import run_command
from tests.fixtures import moving_axis

OFFSET = ("constant_force", {"force": 6.0})
STEP = ("disturbance_step", {"force": 6.0, "start": 2.0, "stop": 5.0})
FRICTION = ("position_dependent_friction", {"nodes": [-0.15, -0.05, 0.05, 0.15], "levels": [1.0, 6.0, 0.5, 4.0]})
PAIRS = (
    (FRICTION, OFFSET),
    (
        ("disturbance_tone", {"frequency": 1.3, "sine": 5.0}),
        ("local_force", {"center": 0.03, "width": 0.02, "force": 9.0}),
    ),
    (("cable_spring", {"stiffness": 40.0, "center": 0.05}), STEP),
    (STEP, ("coulomb_asymmetry", {"difference": 5.0})),
    (("quadratic_drag", {"coefficient": 10.0}), ("disturbance_tone", {"frequency": 0.4, "sine": 5.0})),
    (("constant_force", {"force": 5.0}), ("disturbance_tone", {"frequency": 0.2, "sine": 6.0})),
)


def main() -> int:
    seeds, right = int(sys.argv[1]) if len(sys.argv) > 1 else 4, 0
    plain = moving_axis.machine()
    stated = plain.replace(axis=plain.axis.replace(mass=2.02, coulomb=1.6, coulomb_width=3e-3))
    for pair in PAIRS:
        true = moving_axis.machine([cogging.EFFECTS[name](**fields) for name, fields in pair])
        for seed in range(seeds):
            logs = [moving_axis.record(true, 10 * seed + k) for k in (1, 2)]
            names = [one.found.name for one in search(logs[:1], logs[1:], stated).accepted]
            right += sorted(names) == sorted(name for name, _ in pair)
            print(f"{' + '.join(name for name, _ in pair)}, seed {seed}: {', '.join(names)}", flush=True)
    print(f"exactly the two names: {right} of {seeds * len(PAIRS)}")
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main))
