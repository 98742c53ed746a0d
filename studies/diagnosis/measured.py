"""The measured logs one by one: `python -m studies.diagnosis.measured FOLDER [NAME ...]`; FOLDER has the public data."""

import sys
import time
from pathlib import Path

import numpy as np

import cogging
from cogging.datasets import emps, laas
from studies.laas.motor import axis_from_acceleration

LOOSE = {"mass": 0.3, "viscous": 1.0, "coulomb": 1.0}
NEAR = {"mass": 0.03, "viscous": 0.2, "coulomb": 0.2}


def model(mass, viscous, coulomb, width, command="A", uncertainty=LOOSE):
    axis = cogging.AxisParameters(mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=width)
    return cogging.Model(axis=axis, uncertainty=uncertainty, units=cogging.Units(command=command, position="rad"))


def log(rows, *names):
    """One row an instant: clocks of a computer that polls a drive stand still now and then.

    `names`: of the columns time, position, command and, where there is one, reference.
    """
    columns = [np.asarray(rows[name], dtype=float) for name in names]
    keep = np.concatenate([[True], np.diff(np.maximum.accumulate(columns[0])) > 0])
    time_, *others = (column[keep] for column in columns)
    return cogging.Log(time_ - time_[0], *others)


def table(path):
    return np.genfromtxt(path, delimiter=",", names=True)


def ball_screw(folder):
    logs = [emps.read(name, folder / "emps") for name in ("DATA_EMPS", "DATA_EMPS_PULSES")]
    return logs[:1], logs[1:], emps.published().replace(uncertainty=NEAR)


def cogging_motor(folder):
    axis = axis_from_acceleration(laas.read("acc_current", folder / "laas"))
    values = [axis[name].value for name in ("mass", "viscous", "coulomb")]
    rows = laas.read("speed_test1", folder / "laas")
    return [rows.log()], [], model(*values, 0.0, uncertainty=NEAR)


def hobby_motor(folder):
    logs = []
    for name in ("slow2_slower_nocomp_0", "slow2_nocomp_0"):
        time_, counts, current = np.load(folder / "odrive" / f"{name}.npy")
        logs.append(log((time_, counts * 2 * np.pi / 8192, current), 0, 1, 2))
    return logs[:1], logs[1:], model(3.5e-3, 0.001, 0.2, 0.0)


def pendulum(folder):
    tables = [table(folder / "pendulum" / f"{name}.csv") for name in ("ddp", "direct_collocation")]
    logs = [log(rows, "time", "position", "torque") for rows in tables]
    return logs[:1], logs[1:], model(0.147, 0.02, 0.18, 0.05, "Nm")


def two_mass(folder):
    from scipy.io import loadmat

    logs = []
    for kind in "AB":
        rows = loadmat(folder / "two_mass" / f"MultisineType{kind}.mat")
        column = {name: np.ravel(rows[name]).astype(float)[2500:17500] for name in ("time", "theta_mx", "iq_adx")}
        logs.append(cogging.Log((column["time"] - column["time"][0]) * 1e-6, column["theta_mx"], column["iq_adx"]))
    return logs[:1], logs[1:], model(0.0096, 0.02, 0.1, 0.1)


def diagnose(*machines):
    """Diagnose the machines that the command names, or all, from the data in its FOLDER."""
    folder, names = Path(sys.argv[1]), sys.argv[2:]
    for make in machines:
        if names and make.__name__ not in names:
            continue
        print(f"== {make.__name__}")
        given, confirm, stated = make(folder)
        begin = time.perf_counter()
        try:
            told = cogging.diagnose(given, stated, confirm=confirm).text()
        except (ValueError, ZeroDivisionError) as error:  # a trial tells of every machine
            told = f"{type(error).__name__}: {error}"
        print(f"{time.perf_counter() - begin:.1f} s\n{told}\n", flush=True)


if __name__ == "__main__":
    diagnose(ball_screw, cogging_motor, hobby_motor, pendulum, two_mass)
