"""EMPS: a ball-screw axis under cascade control, two logs of 24.8 s at 1 kHz.

Source: A. Janot, M. Gautier, M. Brunot, "Data Set and Reference Models of EMPS", Workshop on Nonlinear System
Identification Benchmarks, 2019; public at nonlinearbenchmark.org, also through the package `nonlinear-benchmarks`.
Licence: none is stated; cite the authors.

The command is recorded in volts. Here the command is the force in N, FORCE_CONSTANT times the voltage, so that masses
are in kilograms.
"""

from __future__ import annotations

import os
from pathlib import Path
from types import MappingProxyType

from cogging._core import AxisParameters, CascadeParameters, effects
from cogging.arrays import FloatArray
from cogging.datasets.source import Source
from cogging.files import InputError
from cogging.logs.columns import read_columns
from cogging.logs.log import Log, read_log
from cogging.model.model import Model
from cogging.model.units import Units

SOURCE = Source("emps", "nonlinearbenchmark.org", "no licence stated: cite Janot, Gautier and Brunot 2019")
FILES = ("DATA_EMPS", "DATA_EMPS_PULSES")  # the second has another motion, and pulses added to the command
COLUMNS = MappingProxyType({"time": "t", "position": "qm", "reference": "qg", "command": "vir"})  # in the files
FORCE_CONSTANT = 35.15065  # N/V, amplifier, motor and screw
SCREW_LEAD = 2.5e-3  # m, one turn of the screw
PULSE = 1.08  # V of the command for each unit of the column `pulses_N`; 1.06 to 1.1 in the log
#: Published least-squares estimates by parameter path, kg, N s/m, N and N.
PUBLISHED = MappingProxyType(
    {"axis.mass": 95.11, "axis.viscous": 203.5, "axis.coulomb": 20.39, "effects.constant_force.force": 3.16}
)
#: Errors of the authors' own closed-loop simulation, relative to the norm of the measured column, by file.
AUTHORS_ERRORS = MappingProxyType(
    {
        "DATA_EMPS": {"position": 1.38e-4, "velocity": 2.3e-3, "command": 5.85e-2},
        "DATA_EMPS_PULSES": {"position": 8.0e-5, "velocity": 4.8e-3, "command": 8.94e-2},
    }
)


def files(folder: str | os.PathLike[str] | None = None) -> dict[str, Path]:
    """Return the paths of the two files by their names without `.mat`.

    Args:
        folder: of the data (see cogging.datasets). Without it, and if COGGING_DATA does not contain them, the package
            `nonlinear-benchmarks`, if installed, downloads them once (2 MB) into its own folder.

    Raises:
        InputError: a file is missing or could not be fetched; names source and licence.
    """
    return {name: _find(name, folder) for name in FILES}


def read(name: str = "DATA_EMPS", folder: str | os.PathLike[str] | None = None) -> Log:
    """Read one of the two logs, 24,841 rows: time s, position and reference m, command N.

    Args:
        name: one of FILES.
        folder: see `files`.

    Raises:
        ValueError: an unknown name.
        InputError: the file is missing or invalid.
    """
    SOURCE.require_name(name, FILES)
    return read_log(_find(name, folder), columns=COLUMNS, scale={"command": FORCE_CONSTANT})


def pulses(folder: str | os.PathLike[str] | None = None) -> FloatArray:
    """Read the pulses in the command of DATA_EMPS_PULSES, N, one for each row.

    Args:
        folder: see `files`.

    Raises:
        InputError: the file is missing or has no pulses.
    """
    units = read_columns(_find("DATA_EMPS_PULSES", folder), ["pulses_N"])["pulses_N"]
    return PULSE * FORCE_CONSTANT * units


def controller() -> CascadeParameters:
    """Return the published controller, u = kv (kp (reference - position) - velocity), for a command in newtons.

    Its limit is 10 V. A fit to the logs gives an inner gain 4 % larger.
    """
    kp, kv, limit = 160.18, 243.45 * FORCE_CONSTANT, 10.0 * FORCE_CONSTANT  # 1/s, N s/m, N
    return CascadeParameters(sample_rate=1000.0, kp=kp, kv=kv, command_limit=limit)


def published() -> Model:
    """Return the published model: mass, viscous and exact Coulomb friction, a constant force, the cascade."""
    mass, viscous, coulomb, force = PUBLISHED.values()
    axis = AxisParameters(mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=0.0)
    push, units = (effects.ConstantForce(force=force),), Units(command="N")
    return Model(axis=axis, effects=push, controller=controller(), controller_type="cascade", units=units)


def _find(name: str, folder: str | os.PathLike[str] | None) -> Path:
    file = f"{name}.mat"
    try:
        return SOURCE.find(file, folder)
    except InputError:
        if folder is not None:
            raise
    fetched: list[Path] = []
    try:
        import nonlinear_benchmarks

        fetched = [Path(path) for path in nonlinear_benchmarks.EMPS(data_file_locations=True)]  # downloads once
        note = ""
    except ImportError:
        note = "; pip install nonlinear-benchmarks fetches it"
    except Exception as error:  # any error of the download
        note = f"; nonlinear-benchmarks could not fetch it: {type(error).__name__}: {error}"
    for path in fetched:
        if path.name == file and path.is_file():
            return path
    raise SOURCE.absent(file, [*SOURCE.folders(), *dict.fromkeys(path.parent for path in fetched)], note)
