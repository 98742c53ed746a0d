"""What many runs of one machine take: time and memory on Lu et al.'s X axis, and what a million of them would.

The C3 loop of the X axis (tests/benchmarks/lu2008_loop.py) with the mass drawn, one thread, by closed_loop_batch and by
sweep, each in a process of its own: its processor time, and its peak memory when it is done. The cost of a million is
calculated.

    python -m tests.benchmarks.million [--runs 100 200] [--rows 192001]
"""

import argparse
import json
import platform
import subprocess
import sys

CHILD = """
import json, sys, time
import numpy as np
import cogging
from tests.benchmarks.memory import peak_megabytes as peak
from tests.benchmarks.million import model_and_motion

kind, runs, rows = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
model, motion = model_and_motion()
duration = (rows - 1) / model.controller.sample_rate
before, begin = peak(), time.process_time()
if kind == "sweep":
    varied = {"axis.mass": {"mean": 0.12, "deviation": 0.004}}
    found = cogging.sweep(model, motion, varied, method="random", runs=runs, duration=duration, threads=1)
    assert len(found) == runs and found.failed == 0
else:
    masses = np.random.default_rng(0).normal(0.12, 0.004, runs)
    plants = [model.replace(axis=model.axis.replace(mass=mass)).plant() for mass in masses]
    controllers = [model.make_controller() for _ in plants]
    found = cogging.closed_loop_batch(plants, controllers, motion, duration=duration, threads=1)
    assert len(found) == runs and not found.failures
print(json.dumps({"seconds": time.process_time() - begin, "before": before, "peak": peak()}))
"""


def model_and_motion():
    """The X axis under C3, and its reference."""
    import cogging
    from tests.benchmarks.lu2008_loop import SETUP, core_arguments, random_coefficients

    plant, controller, motion = core_arguments(SETUP, random_coefficients())
    return cogging.Model(
        axis=plant.axis,
        cogging=plant.cogging,
        encoder=plant.encoder,
        controller=controller.parameters,
        controller_type="dcarc",
    ), motion


def measured(kind, runs, rows):
    """Seconds and MB of so many runs in a process of its own."""
    call = [sys.executable, "-c", CHILD, kind, str(runs), str(rows)]
    return json.loads(subprocess.run(call, stdout=subprocess.PIPE, text=True, check=True).stdout)


def main(runs, rows):
    """Prints the table."""
    print(f"C3, X axis, {rows} rows a run, one thread of {platform.machine()}, processes of their own")
    print(f"{'':8}{'runs':>8}{'ms a run':>10}{'ns a row':>10}{'before, MB':>12}{'peak, MB':>10}{'million, core h':>17}")
    for count in runs:
        for kind in ("batch", "sweep"):
            found = measured(kind, count, rows)
            each = found["seconds"] / count
            print(
                f"{kind:8}{count:8}{1e3 * each:10.2f}{1e9 * each / rows:10.0f}{found['before']:12.0f}"
                f"{found['peak']:10.0f}{1e6 * each / 3600:17.1f}",
                flush=True,
            )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, nargs="+", default=[100, 200])
    parser.add_argument("--rows", type=int, default=192_001)
    given = parser.parse_args()
    main(given.runs, given.rows)
