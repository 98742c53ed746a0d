"""The trials of a tuning: what Optuna proposes, what was reached, and which are the best."""

from __future__ import annotations

import importlib
import json
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging.design.tuning.gains import Gain
from cogging.design.tuning.limits import ALL_END, kept_all
from cogging.design.tuning.reached import INDEXES, Reached
from cogging.files import InputError
from cogging.outputs import target_of, write_text

WORST = 1e9  # stands for an infinite objective, of trials that break a limit anyway
WRITTEN_EVERY = 0.5  # s: how much work a kill may cost
RULE = "a rule of the controller"


@dataclass(frozen=True)
class Trial:
    """One set of gains and what it reached.

    Attributes:
        gains: by path.
        reached: on the machines tuned with.
        excess: by how much each limit is broken, relative; 0 or less where it is kept.
    """

    gains: Mapping[str, float]
    reached: Reached
    excess: Mapping[str, float]

    @property
    def kept(self) -> bool:
        """Whether all limits are kept."""
        return kept_all(self.excess)

    @property
    def broken(self) -> float:
        """By how much limits are broken, together."""
        return sum(max(value, 0.0) for value in self.excess.values())


def optuna() -> Any:
    """The library that proposes gains.

    Raises:
        ImportError: it is not there; names the extra.
    """
    try:
        return importlib.import_module("optuna")
    except ImportError as error:
        raise ImportError("optuna is needed for this and is not there: pip install 'cogging[tune]'") from error


def run_trials(
    gains: Sequence[Gain],
    count: int,
    seed: int,
    against: str | None,
    judged: Callable[[Mapping[str, float]], Trial],
    kept: KeptTrials | None,
    step: Callable[[str], None],
    micro: str,
) -> Iterator[Trial]:
    """Let Optuna propose gains, by its TPE sampler with constraints, and judge them one by one; the present first.

    The same arguments give the same trials. Those that are kept are not judged again: the sampler is told of them as of
    any other, and goes on as it would have.
    """
    library = optuna()
    with _quiet(library):
        sampler = library.samplers.TPESampler(seed=seed)
        other = [] if against is None else ["minimize" if INDEXES[against][1] else "maximize"]
        study = library.create_study(sampler=sampler, directions=["minimize", *other])
        if all(gain.inside for gain in gains):
            study.enqueue_trial({gain.path: _exact(gain, gain.present) for gain in gains})
        space = {gain.path: _distribution(library, gain) for gain in gains}
    best = math.inf
    for number in range(count):
        with _quiet(library):
            proposed = study.ask(space)
        values = {gain.path: float(proposed.params[gain.path]) for gain in gains}
        trial = kept.read(number, values) if kept is not None else None
        if trial is None:
            trial = judged(values)
            if kept is not None:
                kept.keep(trial)
        with _quiet(library):
            for name, value in trial.excess.items():
                proposed.set_constraint(name, value)
            objectives = [trial.reached.error_rms]
            if against is not None:
                objectives.append(getattr(trial.reached, against))
            study.tell(proposed, [value if math.isfinite(value) else WORST for value in objectives])
        if trial.kept:
            best = min(best, trial.reached.error_rms)
        step(f"trial {number + 1}, best {1e6 * best:.4g} {micro}" if math.isfinite(best) else f"trial {number + 1}")
        yield trial


@contextmanager
def _quiet(library: Any) -> Iterator[None]:
    """Without what the library says of each trial on standard error."""
    before = library.logging.get_verbosity()
    library.logging.set_verbosity(library.logging.ERROR)
    try:
        yield
    finally:
        library.logging.set_verbosity(before)


def _distribution(library: Any, gain: Gain) -> Any:
    if gain.whole:
        return library.distributions.IntDistribution(int(gain.low), int(gain.high), log=gain.logarithmic)
    return library.distributions.FloatDistribution(gain.low, gain.high, log=gain.logarithmic)


def _exact(gain: Gain, value: float) -> float | int:
    return int(value) if gain.whole else value


class KeptTrials:
    """Keeps the trials of a tuning beside its output, so that one that was ended goes on where it was."""

    def __init__(self, out: str | os.PathLike[str], digest: str) -> None:
        """Open the file that an earlier call of the same tuning left, if it did.

        Raises:
            InputError: it holds another tuning's trials, or cannot be used.
        """
        target = target_of(out)
        self._path = target.with_name(f"{target.name}.trials")
        self._called = f"{os.fspath(out)}.trials"
        self._digest = digest
        self._trials: list[Trial] = []
        self._written = time.monotonic()
        if not self._path.exists():
            return
        try:
            document = json.loads(self._path.read_text(encoding="utf-8"))
            digest, trials = document["digest"], [_trial_of(entry) for entry in document["trials"]]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InputError(f"{self._called}: cannot be used: {error}") from None
        if digest != self._digest:
            raise InputError(
                f"{self._called}: holds trials of another tuning, or of another version: "
                "remove it, or write to another file"
            )
        self._trials = trials

    def read(self, number: int, values: Mapping[str, float]) -> Trial | None:
        """A trial that was finished, or None."""
        if number < len(self._trials) and self._trials[number].gains == values:
            return self._trials[number]
        del self._trials[number:]
        return None

    def keep(self, trial: Trial) -> None:
        """Keep one more.

        Raises:
            InputError: it cannot be written, as on a full disk; those before it stand.
        """
        self._trials.append(trial)
        if time.monotonic() - self._written > WRITTEN_EVERY:
            self.write()

    def write(self) -> None:
        """Write those that there are.

        Raises:
            InputError: they cannot be written.
        """
        entries = [[dict(t.gains), t.reached.to_dict(), dict(t.excess)] for t in self._trials]
        try:
            write_text(self._path, json.dumps({"digest": self._digest, "trials": entries}) + "\n")
        except InputError as error:
            raise InputError(f"{error}; {self.stands}") from None
        self._written = time.monotonic()

    def remove(self) -> None:
        """Take the file away."""
        with suppress(OSError):
            self._path.unlink(missing_ok=True)

    @property
    def stands(self) -> str:
        """What to tell of the finished trials where a tuning has ended before its time."""
        return f"finished trials stand in {self._called}, the same call goes on from there"


def _trial_of(entry: Any) -> Trial:
    gains, reached, excess = entry
    return Trial(gains, Reached(**reached), excess)


def best_of(trials: Sequence[Trial]) -> Trial | None:
    """The trial with the smallest rms error of those that keep all limits, or None."""
    kept = [trial for trial in trials if trial.kept]
    return min(kept, key=lambda trial: trial.reached.error_rms, default=None)


def nearest_of(trials: Sequence[Trial]) -> Trial:
    """The trial that breaks the limits least."""
    return min(trials, key=lambda trial: trial.broken)


def front_of(trials: Sequence[Trial], against: str) -> list[int]:
    """Which trials keep all limits and are beaten by none in both rms error and an index, by falling error."""
    sign = 1.0 if INDEXES[against][1] else -1.0
    places = [place for place, trial in enumerate(trials) if trial.kept]
    places.sort(key=lambda place: (trials[place].reached.error_rms, sign * getattr(trials[place].reached, against)))
    front: list[int] = []
    least = math.inf
    for place in places:
        value = sign * getattr(trials[place].reached, against)
        if value < least:
            front.append(place)
            least = value
    return front[::-1]


def failures_of(trials: Sequence[Trial], names: Sequence[str]) -> dict[str, tuple[int, float]]:
    """How many trials break each limit, and the least by which one does or does not, relative."""
    return {
        name: (
            sum(trial.excess.get(name, 0.0) > 0.0 for trial in trials),
            min((trial.excess[name] for trial in trials if name in trial.excess), default=0.0),
        )
        for name in (*names, ALL_END, RULE)
    }


def some_of(places: Sequence[int], most: int) -> list[int]:
    """At most so many, evenly, the first and the last among them."""
    if len(places) <= most:
        return list(places)
    return [places[i] for i in np.unique(np.linspace(0, len(places) - 1, most).round().astype(int))]
