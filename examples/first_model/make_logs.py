"""How run.csv and other.csv of this folder were made: a simulated axis, written as a drive's logger writes it.

A linear motor of 3.2 kg moves 0.34 m at up to 0.4 m/s under a PID at 1 kHz. Its cogging has a period of 24 mm. The
cable chain pulls it towards the middle, as a spring would: that is what nobody wrote down.

    python make_logs.py FOLDER
"""

import sys
from pathlib import Path

import cogging

GAINS = dict(zip(("kp", "ki", "kd"), cogging.pid_gains([-90.0] * 3, 3.2), strict=True))
MACHINE = cogging.Model(
    axis=cogging.AxisParameters(mass=3.2, viscous=9.0, coulomb=4.5, coulomb_width=2e-3, travel=[0.0, 0.4]),
    cogging=cogging.CoggingModel(cogging.SplineHarmonics(pitch=0.024, harmonics=[1]), [[2.4]], [[0.9]]),
    effects=[cogging.effects.CableSpring(stiffness=14.0, center=0.2)],
    encoder=cogging.EncoderParameters(resolution=2e-7),
    noise=cogging.NoiseParameters(force=0.08, bandwidth=60.0),
    controller=cogging.PidParameters(
        sample_rate=1000.0, mass=3.2, viscous=9.0, coulomb=4.5, coulomb_width=2e-3, **GAINS
    ),
    controller_type="pid",
    units=cogging.Units(command="N"),
)
RUN = {"type": "point_to_point", "start": 0.03, "distance": 0.34, "velocity": 0.4, "acceleration": 4.0, "jerk": 80.0}
OTHER = {"type": "point_to_point", "start": 0.08, "distance": 0.22, "velocity": 0.25, "acceleration": 2.5, "jerk": 50.0}
REST = {"dwell": 0.15, "repeats": 2}


def write(path, motion, seed):
    """Write one log: milliseconds, millimetres, newtons, and names of its own."""
    log = cogging.simulate(MACHINE, {**motion, **REST}, seed=seed)
    columns = zip(1e3 * log.time, 1e3 * log.position, 1e3 * log.reference, log.command, strict=True)
    rows = [f"{t:.0f},{x:.4f},{r:.5f},{f:.4f}\n" for t, x, r, f in columns]
    path.write_text("t [ms],x [mm],x_ref [mm],F [N]\n" + "".join(rows), encoding="utf-8")


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    write(folder / "run.csv", RUN, seed=1)
    write(folder / "other.csv", OTHER, seed=2)
