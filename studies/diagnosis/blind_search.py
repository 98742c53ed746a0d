"""Which names the search alone gives a drawn blind suite, judged as the answers of `diagnose` are.

DIR is the `--out` of `python -m tests.blind.benchmark --only-draw`. Logs that are misread are left out. With CASE, only those
cases are answered, and each round of their search is printed.
"""

import argparse
import json
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import cogging
from cogging.diagnosis.balance.decision import search
from cogging.resources import on_one_blas_thread
from cogging_command import run_command
from tests.blind.score import judge
from tests.blind.suite import mapped


@on_one_blas_thread(scipy=True)
def answer(task: tuple[Path, bool]) -> dict[str, Any]:
    """Search one case: its names in the form of `result.json`, or the error that ended it, its rounds and the seconds."""
    case, bare = task
    logs = [cogging.read_log(case / name) for name in ("log.csv", "confirm.csv")]
    if bare:
        logs = [cogging.Log(log.time, log.position, log.command) for log in logs]
    begin, found, rounds = time.process_time(), dict[str, Any](), list[str]()
    try:
        accepted = search(logs[:1], logs[1:], cogging.Model.read(case / "model.toml"), progress=rounds.append).accepted
        known = [a for a in accepted if not a.found.name.startswith("~")]  # the others are forces without a name
        found["verdict"] = "unlisted" if len(known) < len(accepted) else "named" if known else "no_gap"
        found["effects"] = [
            {"name": a.found.name, "alternatives": [name for name, _ in a.alternatives], "confidence": a.share}
            for a in known
        ]
    except Exception as error:
        found["error"] = f"{type(error).__name__}: {error}"
    return {**found, "rounds": rounds, "seconds": time.process_time() - begin}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("suite", type=Path, metavar="DIR")
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--without-reference", action="store_true", help="leave out the logs' reference")
    given = parser.parse_intermixed_args()
    key = json.loads((given.suite / "key" / "key.json").read_text())["cases"]
    chosen = given.cases or [name for name, entry in sorted(key.items()) if not entry.get("misreading")]
    tasks = [(given.suite / "cases" / name, given.without_reference) for name in chosen]
    total: Counter[str] = Counter()
    for name, found in zip(chosen, mapped(answer, tasks, given.jobs), strict=True):
        seen = judge(key[name], found, found["seconds"])
        total += Counter({"logs": 1, "errors": "error" in found, "detected": seen.detected, "right": seen.right,
                          "exact": seen.exact, "largest first": bool(seen.largest), "named": seen.found,
                          "hidden": len(seen.truths), "wrong": len(seen.wrong), "s of CPU": round(seen.seconds)})  # fmt: skip
        said = ", ".join(
            "/".join([one["name"], *one["alternatives"]]) + f" {one['confidence']:.2f}"
            for one in found.get("effects", ())
        )
        for line in found["rounds"] if given.cases else []:
            print(line)
        hidden = " + ".join(f"{one['name']} {one['shape']}" for one in key[name]["effects"]) or "nothing"
        print(f"{name} {seen.kind}, {key[name]['law']}: {hidden}: {found.get('error') or said or '-'}", flush=True)
    print(", ".join(f"{what} {number}" for what, number in total.items()))
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main))
