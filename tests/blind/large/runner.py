"""What is run on a case in the large: `cogging.diagnose`, in a process of its own that is ended when its time is up.

The only module here that knows the package under test.
"""

from __future__ import annotations

import multiprocessing
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import tomli_w

from .cases import Case, NotPhysical, draw_case

GAPS = ("floor", "given", "before", "after", "confirm_given", "confirm_before", "confirm_after")


@dataclass
class Answer:
    """What came of a case.

    Attributes:
        index: of the case; case: None where none could be drawn.
        seconds: of `diagnose`.
        verdict: also "no answer" (out of time), "error" (an exception, in `error`).
        effects: name, alternatives, confidence and parameters (field: value), in the order of the result.
        gap: of GAPS those that the result has.
        mismatch: what the result says of a misread log, or None.
    """

    index: int
    case: Case | None
    seconds: float
    verdict: str
    effects: list[dict[str, Any]] = field(default_factory=list)
    gap: dict[str, float] = field(default_factory=dict)
    mismatch: Any = None
    error: str = ""


def answers(seed: int, indexes: list[int], jobs: int, limit: float) -> Iterator[Answer]:
    """Draw and diagnose the cases, `jobs` at a time, each for at most `limit` seconds; in the order of their end."""
    import cogging  # noqa: F401  # once, for all processes that are forked from this one

    context = multiprocessing.get_context("fork")
    waiting, running = list(indexes), []
    while waiting or running:
        while waiting and len(running) < jobs:
            index = waiting.pop(0)
            try:
                case = draw_case(seed, index)
            except NotPhysical as error:
                yield Answer(index, None, 0.0, "not drawn", error=str(error))
                continue
            receiver, sender = context.Pipe(duplex=False)
            process = context.Process(target=_diagnose, args=(case, sender), daemon=True)
            process.start()
            sender.close()
            running.append((index, case, process, receiver, time.perf_counter()))
        for one in list(running):
            index, case, process, receiver, begin = one
            seconds = time.perf_counter() - begin
            if receiver.poll(0.02):
                yield Answer(index, case, seconds, **_received(receiver))
            elif seconds > limit:
                process.kill()
                yield Answer(index, case, seconds, "no answer")
            else:
                continue
            process.join()
            running.remove(one)


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


def _received(receiver: Connection) -> dict[str, Any]:
    try:
        return dict(receiver.recv())
    except EOFError:
        return {"verdict": "error", "error": "the process ended without an answer"}


def _diagnose(case: Case, sender: Connection) -> None:
    import cogging

    try:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "model.toml"
            path.write_text(tomli_w.dumps(case.model))
            model = cogging.Model.read(path)
        result = cogging.diagnose(cogging.Log(**case.log), model, confirm=cogging.Log(**case.confirm))
        told = _told(result)
    except Exception as error:
        told = {"verdict": "error", "error": f"{type(error).__name__}: {error}"}
    sender.send(told)


def _told(result: Any) -> dict[str, Any]:
    gaps = {name: getattr(result.gap, name, None) for name in GAPS}
    return {
        "verdict": result.verdict,
        "effects": [
            {
                "name": effect.name,
                "alternatives": list(effect.alternatives),
                "confidence": float(effect.confidence),
                "parameters": {name: p.value for name, p in effect.parameters.items()},
            }
            for effect in result.effects
        ],
        "gap": {name: float(value) for name, value in gaps.items() if value is not None},
        "mismatch": _plain(getattr(result, "mismatch", None)),
    }


def _plain(mismatch: Any) -> Any:
    """What can be sent to another process and printed."""
    return mismatch if mismatch is None or isinstance(mismatch, str | dict) else str(mismatch)
