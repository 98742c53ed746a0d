"""What must not change while the package is rebuilt: record it once, compare any later state with it.

    python tests/golden.py record DIR [--only PART ...]
    python tests/golden.py compare DIR [--only PART ...]
    python tests/golden.py small

Parts: `papers` (tables of the three papers and of `--compare`), `emps` (`identify`), `diagnose` (EMPS, LAAS, 24 blind
cases: result and patched model), `logs` (every controller, motion and effect). `record` writes the cases as files into
DIR/cases where there are none; `compare` reads these files. `small` rewrites golden_values.json, which test_golden.py
compares with. Exit status 1 where a number or label does not agree (golden_comparison.py).
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cogging
import golden_cases
import golden_logs
import golden_small
from golden_comparison import compare, leaves

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

JOBS = 2
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
    parser.add_argument("action", choices=("record", "compare", "small"))
    parser.add_argument("folder", type=Path, nargs="?", metavar="DIR")
    parser.add_argument("--only", nargs="+", choices=tuple(PARTS), default=list(PARTS), metavar="PART")
    options = parser.parse_args()
    if options.folder is None and options.action != "small":
        parser.error("DIR: must be given")
    print(f"the package at {Path(cogging.__file__).parent}", flush=True)
    if options.action == "small":
        golden_small.write()
        return 0
    action = record if options.action == "record" else compare_parts
    return action(options.folder.resolve(), options.only)


if __name__ == "__main__":
    sys.exit(main())
