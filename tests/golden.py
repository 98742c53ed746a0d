"""What must not change while the package is rebuilt: record it once, compare any later state with it.

    python tests/golden.py record DIR [--only PART ...]
    python tests/golden.py compare DIR [--only PART ...]

Parts: `papers` (tables of the three papers and of `--compare`), `emps` (`identify`), `diagnose` (EMPS, LAAS, 24 blind
cases: result and patched model), `logs` (every controller, motion and effect). `record` writes the cases as files into
DIR/cases where there are none; `compare` reads these files.

Two numbers agree when they differ by at most 1e-9 of the larger or by 1e-15 (SI: a femtometre, far below any quantum
or fit). Labels are texts of up to three words (verdicts, names, units) and must be equal; longer texts are sentences,
only listed. What is new in a later state is only listed; what is missing, and a list of another length, is a failure.
Exit status 1 where a number or label does not agree.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cogging
import golden_cases
import golden_logs

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

RELATIVE, FLOOR = 1e-9, 1e-15
SHOWN = 10
JOBS = 2
LABEL_WORDS = 3
PAPERS = ("lu2008", "malaize2009", "xu2001")

# What is recorded -----------------------------------------------------------------------------------------------------


def command(arguments: list[str], folder: Path) -> None:
    """Run `cogging` on its own in a folder, on one thread of the linear algebra."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}
    run = subprocess.run(
        [sys.executable, "-m", "cogging", *arguments], cwd=folder, env=environment, capture_output=True, text=True
    )
    if run.returncode:
        raise SystemExit(f"{folder}: cogging {' '.join(arguments)}: status {run.returncode}: {run.stderr.strip()}")


def papers(folder: Path) -> dict[str, Any]:
    """The tables; a measured time is no figure."""
    calls = [["reproduce", paper] for paper in PAPERS] + [["reproduce", "--compare"]]
    with tempfile.TemporaryDirectory() as out, ThreadPoolExecutor(JOBS) as pool:
        list(pool.map(lambda call: command([*call, "--out", out], Path(out)), calls))
        told = {path.stem: json.loads(path.read_text()) for path in sorted(Path(out).glob("*.json"))}
    for table in told["comparison"]["tables"]:
        table["rows"] = [row for row in table["rows"] if row["index"] != "step"]
    return told


def answer(case: Path) -> dict[str, Any]:
    """Result and model of a case."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as out:
        result, model = Path(out) / "result.json", Path(out) / "model.toml"
        arguments = json.loads((case / "arguments.json").read_text())
        command([*arguments, "--json", str(result), "--out", str(model)], case)
        told = {"result": json.loads(result.read_text())}
        told["model"] = tomllib.loads(model.read_text()) if model.exists() else None
    verdict = told["result"].get("verdict", "fitted")
    names = ", ".join(effect["name"] for effect in told["result"].get("effects", []))
    print(f"  {case.name}: {verdict} {names} ({time.perf_counter() - begin:.1f} s)", flush=True)
    return told


def emps(folder: Path) -> dict[str, Any]:
    """`identify` on EMPS."""
    return answer(folder / "cases" / "identify_emps")


def diagnose(folder: Path) -> dict[str, Any]:
    """`diagnose` on every other case."""
    cases = [case for case in sorted((folder / "cases").iterdir()) if not case.name.startswith("identify")]
    cases.sort(key=lambda case: case.name.startswith("blind"))  # the long ones first
    with ThreadPoolExecutor(JOBS) as pool:
        return dict(zip([case.name for case in cases], pool.map(answer, cases), strict=True))


PARTS: dict[str, Callable[[Path], dict[str, Any]]] = {
    "papers": papers,
    "emps": emps,
    "diagnose": diagnose,
    "logs": lambda folder: golden_logs.summaries(),
}

# What is compared -----------------------------------------------------------------------------------------------------


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Every number and text with its path, and the length of every list that is not made of sentences."""
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from leaves(entry, f"{path}/{key}")
    elif isinstance(value, list):
        if not all(is_sentence(entry) for entry in value):
            yield f"{path}/length", len(value)
        for index, entry in enumerate(value):
            yield from leaves(entry, f"{path}/{index}")
    else:
        yield path, value


def is_sentence(value: Any) -> bool:
    """Whether a value is a text that may be put in other words."""
    return isinstance(value, str) and len(value.split()) > LABEL_WORDS


def is_number(value: Any) -> bool:
    """Whether a value is compared by size."""
    return isinstance(value, int | float) and not isinstance(value, bool)


@dataclass
class Comparison:
    """How a part differs from what was recorded.

    Attributes:
        values: numbers, hashes and labels that were compared.
        differ: of these, not the same in every bit.
        largest: relative difference of numbers.
        first: the first paths that differ, with both values.
        failures: numbers beyond the tolerance, labels that differ, what is missing.
        sentences: that differ.
        new: paths that were not recorded.
    """

    values: int = 0
    differ: int = 0
    largest: float = 0.0
    first: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    sentences: list[str] = field(default_factory=list)
    new: list[str] = field(default_factory=list)

    def number(self, line: str, was: float, now: float) -> None:
        """Take in two numbers that differ."""
        size = max(abs(was), abs(now))
        self.differ += 1
        self.first.append(line)
        relative = abs(was - now) / size
        if abs(was - now) > FLOOR:
            self.largest = max(self.largest, relative)
        if not abs(was - now) <= max(RELATIVE * size, FLOOR):
            self.failures.append(f"{line} (relative {relative:.2g})")

    def text(self) -> str:
        """What was found, in lines."""
        lines = [
            f"{self.values} values, {self.differ} differ in some bit, largest relative difference {self.largest:.3g}, "
            f"{len(self.failures)} failures, {len(self.sentences)} sentences differ, {len(self.new)} new values"
        ]
        parts = (("differs", self.first), ("FAILS", self.failures), ("sentence", self.sentences), ("new", self.new))
        for word, found in parts:
            lines += [f"  {word} {line}" for line in found[:SHOWN]]
            if len(found) > SHOWN:
                lines.append(f"  ... {len(found) - SHOWN} more of: {word}")
        return "\n".join(lines)


def compare(was: Any, now: Any) -> Comparison:
    """Compare what was recorded with what is."""
    found, after = Comparison(), dict(leaves(now))
    before = dict(leaves(was))
    for path, old in before.items():
        sentence = is_sentence(old)
        found.values += not sentence
        if path not in after:
            (found.sentences if sentence else found.failures).append(f"{path}: {old!r} is missing")
            continue
        new = after[path]
        if same(old, new):
            continue
        line = f"{path}: {old!r} -> {new!r}"
        if is_number(old) and is_number(new):
            found.number(line, old, new)
        elif sentence and isinstance(new, str):
            found.sentences.append(line)
        else:
            found.differ += 1
            found.first.append(line)
            if not path.endswith("/sha256"):  # the numbers beside a hash say how far its bytes are off
                found.failures.append(line)
    found.new = [f"{path}: {after[path]!r}" for path in after if path not in before]
    return found


def same(old: Any, new: Any) -> bool:
    """Equal in every bit; a whole number may be written as a float."""
    if is_number(old) and is_number(new):
        return old == new and math.copysign(1.0, old) == math.copysign(1.0, new)
    return bool(old == new)


# The command ----------------------------------------------------------------------------------------------------------


def record(folder: Path, parts: list[str]) -> int:
    """Write what is now."""
    listed = golden_logs.known()
    mine = {"controllers": golden_logs.CONTROLLERS, "motions": golden_logs.MOTIONS, "effects": golden_logs.EFFECTS}
    for kind, names in mine.items():
        if listed[kind] != set(names):
            raise SystemExit(f"{kind}: golden_logs.py must have {', '.join(sorted(listed[kind] ^ set(names)))}")
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "cases").exists():
        golden_cases.write_cases(folder / "cases")
    for part in parts:
        begin = time.perf_counter()
        told = PARTS[part](folder)
        (folder / f"{part}.json").write_text(json.dumps(told, indent=1) + "\n")
        print(f"{part}: {len(dict(leaves(told)))} values recorded in {time.perf_counter() - begin:.1f} s", flush=True)
    return 0


def compare_parts(folder: Path, parts: list[str]) -> int:
    """Say how what is now differs from what was recorded."""
    failed = False
    for part in parts:
        begin = time.perf_counter()
        was, now = json.loads((folder / f"{part}.json").read_text()), PARTS[part](folder)
        found = compare(was, json.loads(json.dumps(now)))
        print(f"{part}: {found.text()}\n  {time.perf_counter() - begin:.1f} s", flush=True)
        failed |= bool(found.failures)
    return int(failed)


def main() -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("action", choices=("record", "compare"))
    parser.add_argument("folder", type=Path, nargs="?", metavar="DIR")
    parser.add_argument("--only", nargs="+", choices=tuple(PARTS), default=list(PARTS), metavar="PART")
    options = parser.parse_args()
    if options.folder is None:
        parser.error("DIR: must be given")
    print(f"the package at {Path(cogging.__file__).parent}", flush=True)
    action = record if options.action == "record" else compare_parts
    return action(options.folder.resolve(), options.only)


if __name__ == "__main__":
    sys.exit(main())
