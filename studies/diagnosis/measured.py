"""The measured logs one by one: `python -m studies.diagnosis.measured FOLDER [NAME ...]`; FOLDER has the public data."""

import sys
import time
from pathlib import Path

import numpy as np

import cogging
from cogging.datasets import emps, laas
from studies.laas.motor import axis_from_acceleration

RADIANS = cogging.Units(command="A", position="rad")
LOOSE = {"mass": 0.3, "viscous": 1.0, "coulomb": 1.0}


def model(mass, viscous, coulomb, width, uncertainty, units=RADIANS):
    axis = cogging.AxisParameters(mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=width)
    return cogging.Model(axis=axis, uncertainty=uncertainty, units=units)


def ball_screw(folder):
    logs = [emps.read(name, folder / "emps") for name in ("DATA_EMPS", "DATA_EMPS_PULSES")]
    return logs[:1], logs[1:], emps.published().replace(uncertainty={"mass": 0.03, "viscous": 0.2, "coulomb": 0.2})


def cogging_motor(folder):
    axis = axis_from_acceleration(laas.read("acc_current", folder / "laas"))
    values = [axis[name].value for name in ("mass", "viscous", "coulomb")]
    rows = laas.read("speed_test1", folder / "laas")
    return [rows.log()], [], model(*values, 0.0, {"mass": 0.03, "viscous": 0.2, "coulomb": 0.2})


def hobby_motor(folder):
    logs = []
    for name in ("slow2_slower_nocomp_0", "slow2_nocomp_0"):
        time_, counts, current = np.load(folder / "odrive" / f"{name}.npy")
        keep = np.concatenate([[True], np.diff(np.maximum.accumulate(time_)) > 0])
        logs.append(cogging.Log(time_[keep] - time_[0], counts[keep] * 2 * np.pi / 8192, current[keep]))
    return logs[:1], logs[1:], model(3.5e-3, 0.001, 0.2, 0.0, LOOSE)


def pendulum(folder):
    logs = []
    for name in ("ddp", "direct_collocation"):
        rows = np.genfromtxt(folder / "pendulum" / f"{name}.csv", delimiter=",", names=True)
        keep = np.concatenate([[True], np.diff(np.maximum.accumulate(rows["time"])) > 0])
        rows = rows[keep]
        logs.append(cogging.Log(rows["time"], rows["position"], rows["torque"]))
    return logs[:1], logs[1:], model(0.147, 0.02, 0.18, 0.05, LOOSE, cogging.Units(command="Nm", position="rad"))


def two_mass(folder):
    from scipy.io import loadmat

    logs = []
    for kind in "AB":
        rows = loadmat(folder / "two_mass" / f"MultisineType{kind}.mat")
        column = {name: np.ravel(rows[name]).astype(float)[2500:17500] for name in ("time", "theta_mx", "iq_adx")}
        logs.append(cogging.Log((column["time"] - column["time"][0]) * 1e-6, column["theta_mx"], column["iq_adx"]))
    return logs[:1], logs[1:], model(0.0096, 0.02, 0.1, 0.1, LOOSE)


def main():
    folder, names = Path(sys.argv[1]), sys.argv[2:]
    for make in (ball_screw, cogging_motor, hobby_motor, pendulum, two_mass):
        if names and make.__name__ not in names:
            continue
        given, confirm, stated = make(folder)
        begin = time.perf_counter()
        told = cogging.diagnose(given, stated, confirm=confirm)
        print(f"== {make.__name__}, {time.perf_counter() - begin:.1f} s\n{told.text()}\n", flush=True)


if __name__ == "__main__":
    main()
