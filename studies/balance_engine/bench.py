"""Diagnose the cases of a drawn blind suite: `python -m cogging.diagnosis.balance.bench DIR [CASE ...]`.

DIR is what `python -m tests.blind.benchmark --only-draw --out DIR` wrote. A line a case: what is hidden, what was found.
"""

import json
import sys
import time
import traceback
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path


def one(folder):
    import cogging
    from cogging.diagnosis.balance.decision import run

    begin, steps = time.perf_counter(), []
    try:
        logs = [[cogging.read_log(f"{folder}/{name}.csv")] for name in ("log", "confirm")]
        result = run(*logs, cogging.Model.read(f"{folder}/model.toml"), steps.append)
    except Exception as error:
        result = {"error": f"{type(error).__name__}: {error}"}
        steps.append(traceback.format_exc())
    return Path(folder).name, result, time.perf_counter() - begin, steps


def main():
    base, names = Path(sys.argv[1]), sys.argv[2:]
    key = json.loads((base / "key" / "key.json").read_text())["cases"]
    answers = base / "results_balance"
    answers.mkdir(exist_ok=True)
    with ProcessPoolExecutor(2) as pool:
        for name, result, seconds, steps in pool.map(one, [f"{base}/cases/{n}" for n in names or sorted(key)]):
            (answers / f"{name}.json").write_text(json.dumps({"seconds": seconds, "result": result, "steps": steps}))
            hidden = [f"{e['name']} {e['shape']} {e['ratio']:.0f}" for e in key[name]["effects"]]
            found = [" or ".join([e["name"], *e["alternatives"]]) for e in result.get("effects", [])]
            verdict = result.get("verdict", result.get("error"))
            print(f"{name} {hidden} ({key[name]['law']}) -> {verdict} {found} {seconds:.1f} s", flush=True)
            if names:
                print("\n".join(steps), flush=True)


if __name__ == "__main__":
    main()
