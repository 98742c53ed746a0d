"""What is scored: `cogging.diagnose` or a naive baseline, on one case in a worker process."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

#: `careful` is the naive baseline with a practical floor and confirmation on the other motion.
RUNNERS = ("diagnose", "naive", "careful")


def run_case(task: tuple[str, str, str]) -> tuple[str, dict[str, Any], float]:
    """Run one case and keep its result: (runner, folder of the case, file of the result); seconds do not count imports.

    A failure is a result too: {"error": "type: text"}; it counts as an error in the table.
    """
    runner, folder, target = task
    case = Path(folder)
    if runner == "diagnose":
        import cogging

        def answer() -> dict[str, Any]:
            result = cogging.diagnose(case / "log.csv", case / "model.toml", confirm=[case / "confirm.csv"])  # type: ignore[attr-defined]
            return dict(result.to_dict())
    else:
        from .naive import diagnose_naively

        def answer() -> dict[str, Any]:
            confirm = [case / "confirm.csv"]
            return diagnose_naively(case / "log.csv", case / "model.toml", confirm, careful=runner == "careful")

    begin = time.perf_counter()
    try:
        result = answer()
    except Exception as error:
        result = {"error": f"{type(error).__name__}: {error}"}
    seconds = time.perf_counter() - begin
    Path(target).write_text(json.dumps({"seconds": seconds, "result": result}, indent=1))
    return case.name, result, seconds
