"""Which names the search alone gives a drawn blind suite: `python -m studies.diagnosis.blind_search DIR [JOBS [without]]`.

DIR is the `--out` of `python -m tests.blind.benchmark --only-draw`. Logs that are misread are left out; with `without`, logs
have no reference. A wrong name has a probability of 0.95 or more, and no hidden effect among its alternatives.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import cogging
from cogging.diagnosis.balance.decision import search
from cogging.resources import on_one_blas_thread
from cogging_command import run_command
from tests.blind.suite import mapped


@on_one_blas_thread(scipy=True)
def names_of(task: tuple[Path, bool]) -> tuple[list[tuple[str, list[str], float]], float]:
    """Search one case: name, alternatives and probability of each effect, and the seconds that it took."""
    case, bare = task
    logs = [cogging.read_log(case / name) for name in ("log.csv", "confirm.csv")]
    if bare:
        logs = [cogging.Log(log.time, log.position, log.command) for log in logs]
    begin = time.process_time()
    try:
        found = search(logs[:1], logs[1:], cogging.Model.read(case / "model.toml")).accepted
    except Exception as error:
        return [(f"~{type(error).__name__}: {error}", [], 0.0)], time.process_time() - begin
    names = [(a.found.name, [name for name, _ in a.alternatives], a.share) for a in found]
    return names, time.process_time() - begin


def judged(entry: dict[str, Any], names: list[tuple[str, list[str], float]]) -> dict[str, int]:
    """Count by the key of a case."""
    truths = {one["name"] for one in entry["effects"]}
    fine = truths.union(*(one["tolerated"] for one in entry["effects"]))
    own = [{name, *others} for name, others, _ in names]
    false = {name for (name, _, share), one in zip(names, own, strict=True) if share >= 0.95 and not one & fine}
    met = sum(any(name in one for one in own) for name in truths)
    all_named = bool(truths) and met == len(truths)
    return {
        "something": bool(names),
        "first": bool(own and own[0] & set(entry.get("largest", truths))),
        "all": all_named,
        "exactly": all_named and len(names) == len(truths),
        "named": met,
        "hidden": len(truths),
        "wrong": len({name for name in false if not name.startswith("~")}),
    }


def main() -> int:
    out, jobs = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 2
    key = json.loads((out / "key" / "key.json").read_text())["cases"]
    chosen = [name for name, entry in sorted(key.items()) if not entry.get("misreading")]
    answers = mapped(names_of, [(out / "cases" / name, "without" in sys.argv) for name in chosen], jobs)
    total: dict[str, int] = {}
    seconds = 0.0
    for name, (names, took) in zip(chosen, answers, strict=True):
        counts = judged(key[name], names)
        total = {what: total.get(what, 0) + number for what, number in counts.items()}
        seconds += took
        truths = " + ".join(one["name"] for one in key[name]["effects"]) or "nothing"
        said = ", ".join(f"{one}{'/' + '/'.join(more) if more else ''} {share:.2f}" for one, more, share in names)
        print(f"{name} {key[name]['kind']}: {truths}: {said or '-'}", flush=True)
    print(f"{len(chosen)} logs: " + ", ".join(f"{what} {number}" for what, number in total.items()))
    print(f"{seconds:.0f} s of CPU")
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main))
