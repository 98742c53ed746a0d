"""The fixed cases of `diagnose` and `identify` that golden.py runs: written once, as a user's files, then only read.

A case is a folder with its logs and model and `arguments.json`: what stands after `cogging` on the command line. The
blind generator is asked once, when a baseline is recorded.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[1]
DATA = ROOT / ".." / "shared" / "data"
SEED = 7  # of the blind suite's tuning: nothing here is a rate to report
CALM = ["plain", "coloured_noise", "pink_noise", "wrong_nominals", "fine_steps", "poor_motion"]
EASY = ["cable_spring", "disturbance_tone", "viscous_asymmetry", "command_dead_zone", "cogging_harmonic"]
STRONG = [300.0, 1000.0]
#: Of the suite that `drawn` plans, what runs in seconds and shows most verdicts; 22 without a controller, 38 for the
#: empirical term, 13 with a wrong gain.
DRAWN = (1, 3, 4, 6, 7, 8, 10, 11, 12, 13, 14, 17, 18, 19, 20, 24, 25, 27, 36, 39)
GAIN = 35.15065  # N/V of EMPS
READING = ["--columns", "time=t,position=qm,reference=qg,command=vir", "--scale", f"command={GAIN}"]
CASCADE = {"type": "cascade", "sample_rate": 1000.0, "kp": 160.18, "kv": 243.45 * GAIN, "command_limit": 10.0 * GAIN}
UNCERTAINTY = {"mass": 0.03, "viscous": 0.2, "coulomb": 0.2}
PRIOR = {"mass": 90.0, "viscous": 180.0, "coulomb": 25.0, "coulomb_width": 0.0}
PUBLISHED = {"mass": 95.11, "viscous": 203.5, "coulomb": 20.39, "coulomb_width": 0.0, "uncertainty": UNCERTAINTY}
CONFIRMED = ["diagnose", "log.csv", "--model", "model.toml", "--confirm", "confirm.csv"]


def write_cases(folder: Path) -> None:
    """Write every case into a folder of its own."""
    identify_emps(folder / "identify_emps")
    for name, controller in (("emps_cascade", CASCADE), ("emps_no_controller", None)):
        diagnose_emps(folder / name, controller)
    diagnose_laas(folder / "laas")
    written = {index: write_drawn(folder / f"blind_{index:02d}", index) for index in (*DRAWN, 22, 38)}
    written[22].rename(folder / "blind_unknown_controller")
    written[38].rename(folder / "blind_empirical")
    put_arguments(folder / "blind_empirical", [*CONFIRMED, "--empirical"])
    change_model(folder / "blind_unknown_controller", {"controller": None})
    wrong_gain(written[13], folder / "blind_wrong_gain")
    at_rest(folder / "blind_at_rest")


def put_arguments(case: Path, arguments: list[str]) -> None:
    """Say what stands after `cogging` for this case; files are beside it."""
    (case / "arguments.json").write_text(json.dumps(arguments) + "\n")


def change_model(case: Path, sections: Mapping[str, Any]) -> None:
    """Replace sections of a case's model; None takes one out."""
    document = tomllib.loads((case / "model.toml").read_text()) | dict(sections)
    (case / "model.toml").write_text(tomli_w.dumps({k: v for k, v in document.items() if v is not None}))


def put_model(case: Path, sections: Mapping[str, Any]) -> None:
    """Write a case's model."""
    case.mkdir(parents=True, exist_ok=True)
    (case / "model.toml").write_text(tomli_w.dumps({k: v for k, v in sections.items() if v is not None}))


# Measured -------------------------------------------------------------------------------------------------------------


def identify_emps(case: Path) -> None:
    """The README's fit: wrong parameters and the published controller."""
    put_model(case, {"axis": PRIOR, "effects": [{"name": "constant_force"}], "controller": CASCADE})
    shutil.copy(DATA / "emps" / "DATA_EMPS.mat", case)
    put_arguments(case, ["identify", "DATA_EMPS.mat", "--model", "model.toml", *READING])


def diagnose_emps(case: Path, controller: Mapping[str, Any] | None) -> None:
    """The published model, confirmed on the second log."""
    offset = [{"name": "constant_force", "force": 3.16}]
    put_model(case, {"axis": PUBLISHED, "effects": offset, "controller": controller})
    for name in ("DATA_EMPS", "DATA_EMPS_PULSES"):
        shutil.copy(DATA / "emps" / f"{name}.mat", case)
    told = ["diagnose", "DATA_EMPS.mat", "--model", "model.toml", "--confirm", "DATA_EMPS_PULSES.mat"]
    put_arguments(case, [*told, *READING])


def diagnose_laas(case: Path) -> None:
    """A direct-drive motor with the axis that another of its logs gives; rows that its maker's own loop left alone."""
    sys.path.insert(0, str(ROOT / "tests"))
    import laas

    axis = laas.axis_from_acceleration(laas.read("acc_current"))
    fields = {name: float(axis[name].value) for name in ("mass", "viscous", "coulomb")}
    put_model(case, {"axis": fields | {"coulomb_width": 0.0, "uncertainty": UNCERTAINTY}})
    rows = laas.read("speed_test1")
    put_log(case / "log.csv", {"time": rows.time, "position": rows.position, "command": rows.current})
    put_arguments(case, ["diagnose", "log.csv", "--model", "model.toml"])


def put_log(path: Path, columns: Mapping[str, Any]) -> None:
    """Write a log without loss."""
    rows = np.column_stack(list(columns.values())).tolist()
    path.write_text("\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows)]) + "\n")


# Drawn ----------------------------------------------------------------------------------------------------------------


def write_drawn(case: Path, index: int) -> Path:
    """Draw one case of the blind suite that this module plans."""
    sys.path.insert(0, str(ROOT))
    from tests.blind.cases import draw_case
    from tests.blind.suite import plan_suite, write_case

    plan = plan_suite(SEED, 6, kinds=["null"], families=CALM)
    plan += plan_suite(SEED, 5, kinds=["effect"], effects=EASY, ratios=[1000.0])
    plan += plan_suite(SEED, 24, kinds=["effect"], ratios=STRONG)
    plan += plan_suite(SEED, 10, kinds=["outside"], ratios=STRONG)
    drawn = draw_case([SEED, index, 0], plan[index])
    write_case(drawn, case)
    put_arguments(case, CONFIRMED)
    (case / "hidden.json").write_text(json.dumps(drawn.key, indent=1) + "\n")
    return case


def wrong_gain(drawn: Path, case: Path) -> None:
    """The model states a controller that did not make the log."""
    shutil.copytree(drawn, case)
    controller = tomllib.loads((drawn / "model.toml").read_text())["controller"]
    change_model(case, {"controller": controller | {"kp": 1.6 * controller["kp"]}})


def at_rest(case: Path) -> None:
    """Nothing moves: friction hides every force."""
    put_model(case, {"axis": {"mass": 0.12, "viscous": 0.166, "coulomb": 0.15, "coulomb_width": 0.0}})
    time = np.arange(0.0, 3.0, 5e-4)
    put_log(case / "log.csv", {"time": time, "position": np.full(time.size, 0.1), "command": np.zeros(time.size)})
    put_arguments(case, ["diagnose", "log.csv", "--model", "model.toml"])
