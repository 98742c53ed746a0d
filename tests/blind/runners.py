"""What is scored: `cogging.diagnose` on one case in a worker process. The only module here that knows the package."""

from __future__ import annotations

import json
import multiprocessing
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any


def run_case(task: tuple[str, str]) -> tuple[str, dict[str, Any], float]:
    """Diagnose one case and keep its result: (folder of the case, file of the result); seconds do not count imports.

    A failure is a result too: {"error": "type: text"}; it counts as an error in the table.
    """
    import cogging

    case, begin = Path(task[0]), time.perf_counter()
    try:
        found = cogging.diagnose(case / "log.csv", case / "model.toml", confirm=[case / "confirm.csv"])  # type: ignore[attr-defined]
        result = dict(found.to_dict())
    except Exception as error:
        result = {"error": f"{type(error).__name__}: {error}"}
    seconds = time.perf_counter() - begin
    Path(task[1]).write_text(json.dumps({"seconds": seconds, "result": result}, indent=1))
    return case.name, result, seconds


def within(limit: float, call: Callable[..., Any], *arguments: Any) -> Any:
    """What a call gives, in a process of its own; None where it takes more than `limit` seconds; errors in words."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)

    def send() -> None:
        try:
            sender.send(call(*arguments))
        except Exception as error:
            sender.send(f"{type(error).__name__}: {error}")

    process = context.Process(target=send, daemon=True)
    process.start()
    sender.close()
    try:
        answer = receiver.recv() if receiver.poll(limit) else None
    except EOFError:
        answer = "the process ended without an answer"
    process.kill()
    process.join()
    return answer
