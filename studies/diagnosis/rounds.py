"""Diagnose the cases of a drawn blind suite, with each round: `python -m studies.diagnosis.rounds DIR [CASE ...]`.

DIR is what `python -m tests.blind.benchmark --only-draw --out DIR` wrote. A line a case: what is hidden, what was found.
"""

import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path


def one(folder):
    import cogging
    from cogging.diagnosis.balance.decision import search

    begin, steps = time.perf_counter(), []
    logs = [[cogging.read_log(f"{folder}/{name}.csv")] for name in ("log", "confirm")]
    outcome = search(*logs, cogging.Model.read(f"{folder}/model.toml"), progress=steps.append)
    found = [" or ".join([a.found.name, *(n for n, _ in a.alternatives)]) + f" {a.share:.2f}" for a in outcome.accepted]
    return Path(folder).name, found, time.perf_counter() - begin, steps


def main():
    base, names = Path(sys.argv[1]), sys.argv[2:]
    key = json.loads((base / "key" / "key.json").read_text())["cases"]
    with ProcessPoolExecutor(2) as pool:
        for name, found, seconds, steps in pool.map(one, [f"{base}/cases/{n}" for n in names or sorted(key)]):
            hidden = [f"{e['name']} {e['shape']} {e['ratio']:.0f}" for e in key[name]["effects"]]
            print(f"{name} {hidden} ({key[name]['law']}) -> {found} {seconds:.1f} s", flush=True)
            if names:
                print("\n".join(steps), flush=True)


if __name__ == "__main__":
    main()
