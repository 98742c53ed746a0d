"""Public logs of four machines that the engine was not made on: `python -m studies.diagnosis.public_logs FOLDER [NAME ...]`.

FOLDER holds the data, which are not ours to pass on. One folder a machine, the files as they lie in the repositories
on GitHub at the named commits:

- servo/: bam/data.bak/raw/2026-01-15_*.json of Rhoban/bam at af2260462471ff45ac18af159b1327ea51d8db15 (Apache-2.0).
  A hobby servo, Dynamixel XL330, carries 0.49 kg on an arm of 0.1 m. Its P controller sets the duty.
- arm/: dataset/controller_20230828/*.csv of decargroup/closed_loop_koopman at
  0b64a62e7f302441ce3580143a44d9d87c83532c (MIT). The arm of a Quanser QUBE-Servo balances a free pendulum.
- shoulder/: data/experiment_records/design_C.1/sys_id/20230629/*/trajectory.csv of
  dfki-ric-underactuated-lab/double_pendulum at 1e8544e67f3da72a51ee52fbbb278e131ce2a43f (BSD-3-Clause), each under the
  name of its folder. Only the shoulder of a double pendulum is driven, by sines in open loop, in the first run near its
  natural frequency, where inertia and gravity all but cancel. Friction alone holds the elbow.
- gear/: src/TMotorCANControl/test/saved_logs/control_mode_tests/*/log.csv of neurobionics/TMotorCANControl at
  bb8d07102dc43fb39ea77d04020415dbfbc72de6 (GPL-3.0), each under the name of its folder. A motor with a planetary gear,
  AK80-9, without a load.
"""

import json

import numpy as np

from studies.diagnosis.measured import diagnose, log, model, table

PWM = 885  # counts of a full duty
GRAVITY = 9.81  # m/s^2


def servo(folder):
    logs = []
    for name in ("10h29m14", "10h29m37"):  # both at a gain of 400, of two shapes
        entries = json.loads((folder / "servo" / f"2026-01-15_{name}.json").read_text())["entries"]
        rows = {name: np.array([entry[name] for entry in entries], dtype=float) for name in entries[0]}
        duty = np.where(rows["load"] > 2**15, rows["load"] - 2**16, rows["load"]) / PWM  # a signed word, read unsigned
        rows["voltage"] = duty * rows["input_volts"]
        logs.append(log(rows, "timestamp", "position", "voltage", "goal_position"))
    torque_constant, resistance = 0.3867, 4.017  # bam/params/xl330/m1.json of a later commit, fitted by its authors
    inertia, viscous, coulomb = 0.0018 + 0.49 * 0.1**2, 0.00366, 0.0128
    volts = resistance / torque_constant  # a Nm
    print(f"said of it: gravity of {0.49 * GRAVITY * 0.1 * volts:.2f} V (0.48 Nm) at right angles, lowest at 0.03 rad")
    return logs[:1], logs[1:], model(inertia * volts, viscous * volts + torque_constant, coulomb * volts, 0.1, "V")


def arm(folder):
    runs = ("161809_536_603_090", "161843_650_565_746")
    tables = [table(folder / "arm" / f"qube_20230828T{name}.csv") for name in runs]
    logs = [log(rows, "t", "theta", "plant_input", "target_theta") for rows in tables]
    torque_constant, resistance = 0.042, 8.4  # the maker's data sheet
    inertia = 0.095 * 0.085**2 / 3 + 4.6e-6  # kg m^2, of the arm without the pendulum; with it at its tip 0.173e-3 more
    print("said of it: the pendulum pushes back on the arm; nothing of gravity, the arm lies level")
    return logs[:1], logs[1:], model(inertia * resistance / torque_constant, torque_constant, 0.05, 0.1, "V")


def shoulder(folder):
    logs = [
        log(table(folder / "shoulder" / f"20230629-{name}.csv"), "time", "pos_meas1", "tau_con1")
        for name in ("143906", "144115")  # the elbow stands still; it swings by 0.35 rad
    ]
    # data/system_identification/identified_parameters/design_C.1/model_1.0/model_parameters.yml, the elbow held fast
    inertia = 0.03189 + 0.05087 + 0.6256 * (0.2**2 + 2 * 0.2 * 0.2557) + 37 * 6.29e-5
    moment = 0.5235 * 0.2 + 0.6256 * (0.2 + 0.2557)
    print(f"said of it: gravity of {moment * GRAVITY:.2f} Nm at right angles, lowest at 0 rad")
    return logs[:1], logs[1:], model(inertia, 0.001, 0.16, 0.05, "Nm")


def gear(folder):
    runs = ("mit_poscon", "torque_step_1Nm")
    logs = [log(table(folder / "gear" / f"{name}.csv"), "pi_time", "angle", "current") for name in runs]
    torque = 9 * 1.156 * 0.115  # Nm an A at the output: mit_can.py there, as is friction; the rest is rough
    print(f"said of it: friction of {0.269 / torque:.2f} A and {0.049 / torque:.0%} of the current")
    return logs[:1], logs[1:], model(9**2 * 6.1e-5 / torque, 0.01, 0.269 / torque, 0.05, "A")


if __name__ == "__main__":
    diagnose(servo, arm, shoulder, gear)
