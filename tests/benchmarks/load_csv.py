"""How fast and in how much memory a large CSV log is loaded, beside what numpy and pandas take for a part of it.

    python tests/benchmarks/load_csv.py [ROWS]     # 20,000,000 rows unless told otherwise: about 1 GB, in a temp folder

The limits of the project: 1 GB in 30 s and 3 GB of memory. Each reader runs in a process of its own, so that its peak
is its own. numpy and, where it is installed, pandas read the first twentieth of the rows; their time for all is that
times twenty.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import cogging
from cogging_command import run_command

PART = 20
READERS = {
    "cogging": "cogging.read_log({path!r})",
    "numpy": "numpy.loadtxt({part!r}, delimiter=',', skiprows=1)",
    "pandas": "pandas.read_csv({part!r})",
}


def main() -> None:
    """Write the file, load it in every way, print the figures; the exit status says whether the limits are kept."""
    rows = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000_000
    with tempfile.TemporaryDirectory() as folder:
        path, part = Path(folder) / "log.csv", Path(folder) / "part.csv"
        started = time.perf_counter()
        write(path, rows)
        size = path.stat().st_size
        print(f"{rows} rows, {size / 1e9:.3f} GB, written in {time.perf_counter() - started:.1f} s")
        write(part, max(2, rows // PART))
        kept = True
        for name, call in READERS.items():
            code = f"import {name}, resource, time; t = time.perf_counter(); x = " + call + "; "
            code += "print(time.perf_counter() - t, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
            code = code.format(path=str(path), part=str(part))
            done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
            if done.returncode:
                print(f"{name}: {done.stderr.strip().splitlines()[-1]}")
                continue
            seconds, memory = map(float, done.stdout.split())
            memory *= 1 if sys.platform == "darwin" else 1024
            if name == "cogging":
                own = seconds
                kept = seconds < 30.0 * size / 1e9 and memory < 3e9 * max(1.0, size / 1e9)
                print(f"{name}: {seconds:.2f} s, {size / seconds / 1e6:.0f} MB/s, peak {memory / 1e9:.2f} GB")
            else:
                print(f"{name}: about {PART * seconds:.1f} s for all, {PART * seconds / own:.1f} times as long")
    sys.exit(0 if kept else 1)


def write(path: Path, rows: int) -> None:
    """A log of a sine with reading, command and reference, about 50 bytes a row."""
    phase = np.arange(rows) * 5e-5
    position = np.round(0.25 + 0.2 * np.sin(phase), 9)
    command = np.round(np.cos(phase) + 0.01 * np.sin(777.0 * phase), 9)
    reference = np.round(0.25 + 0.2 * np.sin(phase + 1e-4), 9)
    cogging.Log(time=phase, position=position, command=command, reference=reference).write(path)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"writing {rows} rows: peak {peak:.2f} GB with the columns themselves")


if __name__ == "__main__":
    sys.exit(run_command(main))  # the file in the temporary folder goes
