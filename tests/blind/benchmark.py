"""Draw a fresh blind suite, run, score, print: `python -m tests.blind.benchmark --seed N --cases M --out DIR`.

DIR/cases holds what `cogging.diagnose` sees, DIR/key what only the scorer reads, DIR/results_diagnose the answers. A
second call with --rescore scores the answers that are there; with --keep it draws nothing and runs what is missing.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import cogging
from cogging.files import parse_toml
from cogging_command import run_command

from .score import format_table, judge, plain, table
from .suite import KINDS, LAMBDAS, SHARES, draw_suite, mapped, plan_suite


def tuning_seeds() -> list[int]:
    """Seeds that were looked at while the method was built."""
    return parse_toml(Path(__file__).with_name("seeds.toml").read_text())["tuning"]


def parse(arguments: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.blind.benchmark", description=__doc__)

    def kinds(text: str) -> list[str]:
        if unknown := set(text.split(",")) - set(KINDS):
            raise argparse.ArgumentTypeError(f"must be of {', '.join(KINDS)}, got {', '.join(sorted(unknown))}")
        return text.split(",")

    parser.add_argument("--seed", type=int, required=True, help="of the suite")
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--jobs", type=int, default=2, help="worker processes")
    parser.add_argument("--kinds", type=kinds, default=list(SHARES), help=f"{', '.join(KINDS)}; all but the last")
    parser.add_argument("--lambdas", type=lambda s: [float(v) for v in s.split(",")], default=list(LAMBDAS))
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only-draw", action="store_true")
    parser.add_argument("--keep", action="store_true", help="use the cases and answers that are in --out")
    parser.add_argument("--rescore", action="store_true", help="score the answers that are in --out, run nothing")
    parser.add_argument("--report", action="store_true", help="for a report: refuse the seeds of the tuning")
    options = parser.parse_args(arguments)
    if options.report and options.seed in tuning_seeds():
        parser.error(f"--seed: must not be one of the tuning (seeds.toml) in a report, got {options.seed}")
    return options


def run_case(task: tuple[Path, Path]) -> tuple[str, dict[str, Any], float]:
    """Diagnose one case and keep its result: (folder of the case, file of the result).

    A failure is a result too: {"error": "type: text"}; it counts as an error in the table.
    """
    (case, answer), begin = task, time.perf_counter()
    try:
        result = cogging.diagnose(case / "log.csv", case / "model.toml", confirm=[case / "confirm.csv"]).to_dict()
    except Exception as error:
        result = {"error": f"{type(error).__name__}: {error}"}
    seconds = time.perf_counter() - begin
    answer.write_text(json.dumps({"seconds": seconds, "result": result}, indent=1))
    return case.name, result, seconds


def run_suite(out: Path, jobs: int, *, again: bool) -> None:
    """Diagnose all cases of a folder; `again`: also where an answer is there."""
    answers = out / "results_diagnose"
    answers.mkdir(parents=True, exist_ok=True)
    tasks = [(case, answers / f"{case.name}.json") for case in sorted((out / "cases").glob("case_*"))]
    tasks = [(case, target) for case, target in tasks if again or not target.exists()]
    for count, (name, result, seconds) in enumerate(mapped(run_case, tasks, jobs), start=1):
        verdict = result.get("verdict", result.get("error"))
        print(f"{count}/{len(tasks)} {name} {seconds:.1f} s {verdict}", file=sys.stderr, flush=True)


def score_suite(out: Path) -> dict[str, Any]:
    """Judge the answers that are there by the key; write DIR/table_diagnose.json."""
    key = json.loads((out / "key" / "key.json").read_text())
    outcomes = []
    for name, entry in sorted(key["cases"].items()):
        path = out / "results_diagnose" / f"{name}.json"
        if path.exists():
            answer = json.loads(path.read_text())
            outcomes.append(judge(entry, answer["result"], answer["seconds"]))
    figures = table(outcomes)
    (out / "table_diagnose.json").write_text(json.dumps({"seed": key["seed"], **plain(figures)}, indent=1))
    return figures


def main(arguments: list[str] | None = None) -> int:
    options = parse(arguments)
    if not (options.keep or options.rescore):
        specifications = plan_suite(options.seed, options.cases, kinds=options.kinds, ratios=options.lambdas)
        key = draw_suite(options.seed, options.out / "cases", options.out / "key", specifications, options.jobs)
        print(f"{len(key['cases'])} cases in {options.out}", file=sys.stderr)
        for reason in key["unreachable"]:
            print(f"left out: {reason}", file=sys.stderr)
    if options.only_draw:
        return 0
    if not options.rescore:
        run_suite(options.out, options.jobs, again=not options.keep)
    figures = score_suite(options.out)
    title = f"== diagnose, seed {options.seed}" + (" (a seed of the tuning)" if options.seed in tuning_seeds() else "")
    print(format_table(figures, title))
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main))
