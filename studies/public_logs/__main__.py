"""Public logs of three machines, from the file to the diagnosis, as a user would: `python -m studies.public_logs [NAME ...]`.

Each log is fetched from its public source at a fixed commit (`--data FOLDER` reads copies instead, which lie there as
OWNER/REPOSITORY/COMMIT/PATH), written as CSV into a folder of its own below `--out`, and given to `cogging init`,
`identify` and `diagnose`, each called by the line that the one before printed behind `next:`. What they print stands
beside the CSV files, and one table at the end. README.md describes the machines and what was seen. No data are committed.
"""

import argparse
import io
import json
import resource
import shlex
import subprocess
import sys
import urllib.parse
import urllib.request
from pathlib import Path

import numpy as np

PUBLIC = "https://raw.githubusercontent.com"
PANDA = "marcocognetti/FrankaEmikaPandaDynModel/24d85ce4e648e2e894c832bfeee9b16711eb1a1a"  # GPL-3.0
#: CC BY-SA 4.0
DAMPER = "ARTS-Laboratory/Dataset-Friction-Damper-with-Backlash/0e09aa9d950760277e31c08cd93fd01f39a5af09"
SCREW = "BlueAsuka/RAVEN/4d724223922e98bfe6e4928fb184229cd1c8ccc2"  # MIT
JOINT = 7  # the last: it carries the flange only
KILONEWTON = 4.4482216  # a kip
MILLIMETRE = 25.4  # an inch
REPEATS = 4  # of the motion of 13 s, in one log
SHOWN = {  # of what a command prints: lines that begin so
    "init": ("together", "mass"),
    "identify": ("explains", "axis"),
    "diagnose": ("verdict", "The model", "gap:", "confirm"),
}


def read(base, source, path):
    with urllib.request.urlopen(f"{base}/{urllib.parse.quote(f'{source}/{path}')}") as answer:
        return answer.read().decode()


def joint(base):
    folder = "matlab/data/Exciting_Traj/Trajectory_1/rbt_log/exciting_traj"
    time, position, torque = (
        np.array(read(base, PANDA, f"{folder}_{name}.txt").split(), dtype=float)
        for name in ("time", "positions", "torques")
    )
    rows = np.column_stack([time, position.reshape(-1, 7)[:, JOINT - 1], torque.reshape(-1, 7)[:, JOINT - 1]])
    first = time < time[-1] / 2
    return "time [s],position [rad],torque [Nm]", rows[first], rows[~first]


def damper(base):
    logs = []
    for name in ("0.5Hz30lbtension1amplitude", "0.25Hz30lbtension1.5amplitude"):
        text = read(base, DAMPER, f"data/dataset-2/characterization datasets/{name}.json")
        logs.append(np.array(json.loads(text)["data"])[:, :3] * [1, MILLIMETRE, KILONEWTON])
    return "time [s],position [mm],force [kN]", *logs


def screw(base):
    """The current as it was logged: never negative, whichever way the axis moves."""
    text = read(base, SCREW, "data/linear_acuator/raw/normal.csv")
    table = np.genfromtxt(io.StringIO(text), delimiter=",", names=True, dtype=None, encoding=None)
    table = table[table["load"] == 40]
    groups = np.unique(table["group"])
    logs = []
    for chosen in (groups[:REPEATS], groups[-REPEATS:]):
        rows = table[np.isin(table["group"], chosen)]
        position = rows["set_point"] - rows["position_error"]
        logs.append(np.column_stack([0.04 * np.arange(len(rows)), position, rows["current"], rows["set_point"]]))
    return "time [s],position [mm],current [A],set_point [mm]", *logs


def screw_signed(base):
    """The same with the sign of the wanted speed; at rest, that of the last move."""
    header, *logs = screw(base)
    for log in logs:
        way = np.sign(np.diff(log[:, 3], prepend=log[0, 3] - 1))
        last = np.maximum.accumulate(np.where(way == 0, 0, np.arange(len(way))))
        log[:, 2] *= way[last]
    return header, *logs


MACHINES = (joint, damper, screw, screw_signed)


def write(folder, header, given, confirm):
    folder.mkdir(parents=True, exist_ok=True)
    for name, rows in (("given", given), ("confirm", confirm)):
        rows = np.column_stack([rows[:, 0] - rows[0, 0], rows[:, 1:]])
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", fmt="%.10g", header=header, comments="")


def run(folder, words):
    """What a command prints, the seconds of processor that it took, and the line behind its last `next:`."""
    call, output = [sys.executable, "-m", "cogging", *words], {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(call, cwd=folder, text=True, **output)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    (folder / f"{words[0]}.txt").write_text(f"$ cogging {shlex.join(words)}\n{done.stdout}")
    following = [line for line in done.stdout.splitlines() if line.startswith("next: cogging ")]
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return done.stdout, seconds, shlex.split(following[-1])[2:] if following else []


def follow(folder):
    """Rows of the table: the command, its seconds, and what it said."""
    for path in ("model.toml", "reference.toml", "reference.csv", "fitted.toml", "better.toml", "result.json"):
        (folder / path).unlink(missing_ok=True)
    words = ["init", "given.csv"]
    for command, begins in SHOWN.items():
        if words[:1] != [command]:
            yield command, 0.0, [f"not run: next is {shlex.join(words) or 'not said'}"]
            return
        if command == "diagnose":
            words += ["--confirm", "confirm.csv", "--out", "better.toml", "--json", "result.json", "--verbose"]
        text, seconds, words = run(folder, words)
        lines = [line.strip() for line in text.splitlines()]
        shown = [line for line in lines if line.startswith(begins)]
        yield command, seconds, shown or lines[-1:]  # an error is the last line


def main():
    parser = argparse.ArgumentParser(prog="python -m studies.public_logs", description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="of " + ", ".join(make.__name__ for make in MACHINES))
    parser.add_argument("--data", type=Path, help="folder of copies; default: the public source")
    parser.add_argument("--out", type=Path, default=Path("public_logs"), help="folder for what is written")
    arguments = parser.parse_args()
    base = PUBLIC if arguments.data is None else arguments.data.resolve().as_uri()
    print(f"{'machine':<14}{'command':<10}{'s':>6}  said")
    for make in MACHINES:
        if arguments.names and make.__name__ not in arguments.names:
            continue
        folder = arguments.out / make.__name__
        write(folder, *make(base))
        for command, seconds, lines in follow(folder):
            for number, line in enumerate(lines):
                left = f"{make.__name__:<14}{command:<10}{seconds:6.1f}" if number == 0 else " " * 30
                print(f"{left}  {line}", flush=True)


if __name__ == "__main__":
    main()
