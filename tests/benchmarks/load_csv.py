"""How fast and in how much memory a large CSV log is loaded, beside numpy and pandas on a part of it.

    python -m tests.benchmarks.load_csv [ROWS]     # default 20,000,000 rows: about 1 GB, in a temporary folder

The limits of the project: 1 GB in 30 s and 3 GB of memory. Each reader runs in a process of its own. numpy and, where
it is installed, pandas read the first twentieth of the rows; their time for all is that times twenty.
"""

import importlib.util
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import cogging
from cogging_command import run_command
from tests.benchmarks import child

PART = 20


def load(reader, path):
    """Seconds that a reader needs for a file, and the peak memory of this process, MB."""
    library, begin = importlib.import_module(reader), time.perf_counter()
    if reader == "numpy":
        library.loadtxt(path, delimiter=",", skiprows=1)
    elif reader == "pandas":
        library.read_csv(path)
    else:
        library.read_log(path)
    return time.perf_counter() - begin, child.peak_megabytes()


def write(path, rows):
    """A log of a sine with reading, command and reference, about 50 bytes a row."""
    phase = np.arange(rows) * 5e-5
    position = np.round(0.25 + 0.2 * np.sin(phase), 9)
    command = np.round(np.cos(phase) + 0.01 * np.sin(777.0 * phase), 9)
    reference = np.round(0.25 + 0.2 * np.sin(phase + 1e-4), 9)
    cogging.Log(time=phase, position=position, command=command, reference=reference).write(path)


def main(rows):
    """Write the file, load it in every way, print the figures; status 1 where a limit is exceeded."""
    with tempfile.TemporaryDirectory() as folder:
        path, part = Path(folder) / "log.csv", Path(folder) / "part.csv"
        begin = time.perf_counter()
        write(path, rows)
        size = path.stat().st_size
        print(f"{rows} rows, {size / 1e9:.3f} GB, written in {time.perf_counter() - begin:.1f} s")
        write(part, max(2, rows // PART))
        own, peak = child.call(load, "cogging", str(path))
        print(f"cogging: {own:.2f} s, {size / own / 1e6:.0f} MB/s, peak {peak / 1e3:.2f} GB")
        for reader in ("numpy", "pandas"):
            if importlib.util.find_spec(reader):
                seconds, _ = child.call(load, reader, str(part))
                print(f"{reader}: about {PART * seconds:.1f} s for all, {PART * seconds / own:.1f} times as long")
    return 0 if own < 30.0 * size / 1e9 and peak < 3e3 * max(1.0, size / 1e9) else 1


if __name__ == "__main__":
    sys.exit(run_command(lambda: main(int(sys.argv[1]) if len(sys.argv) > 1 else 20_000_000)))
