"""Many runs in one call."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import overload

from cogging import _core
from cogging._core import Plant, Reference
from cogging.calls import takes
from cogging.logs.log import Log
from cogging.model.controller import AnyController
from cogging.simulation.arguments import MOTION
from cogging.values import ByValue


@dataclass(frozen=True, eq=False, repr=False)
class Batch(ByValue, Sequence[Log]):
    """The runs of closed_loop_batch, in the order of their plants: a sequence of logs, and what each was made of.

    Attributes:
        logs: one Log a run.
        plants: the machine of each run.
        controllers: the controller of each run, as it was given.
        seeds: of each run's noise.
        in_lanes: of each run, whether it went through the processor side by side with others of its course.

    Example:
        >>> plant = cogging.Plant(cogging.AxisParameters(mass=0.12, viscous=0.2))
        >>> pid = cogging.Pid(cogging.PidParameters(kp=9600.0, kd=48.0))
        >>> move = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=2.0))
        >>> batch = cogging.closed_loop_batch([plant, plant], [pid, pid], move, duration=0.1, seeds=[1, 2])
        >>> len(batch), batch.seeds, max(len(log) for log in batch)
        (2, (1, 2), 501)
    """

    logs: tuple[Log, ...]
    plants: tuple[Plant, ...]
    controllers: tuple[AnyController, ...]
    seeds: tuple[int, ...]
    in_lanes: tuple[bool, ...]

    def _brief(self) -> str:
        return f"{len(self.logs)} runs" + (f" of {len(self.logs[0])} rows" if self.logs else "")

    def __len__(self) -> int:
        return len(self.logs)

    def __iter__(self) -> Iterator[Log]:
        return iter(self.logs)

    @overload
    def __getitem__(self, which: int) -> Log: ...
    @overload
    def __getitem__(self, which: slice) -> Batch: ...
    def __getitem__(self, which: int | slice) -> Log | Batch:
        """The log of a run, or a batch of some of them."""
        if isinstance(which, slice):
            made_of = self.plants[which], self.controllers[which], self.seeds[which]
            return Batch(self.logs[which], *made_of, self.in_lanes[which])
        return self.logs[which]


@takes(reference=MOTION)
def closed_loop_batch(
    plants: Sequence[Plant],
    controllers: Sequence[AnyController],
    reference: Reference,
    *,
    duration: float = 0.0,
    seeds: Sequence[int] = (),
    steps_per_sample: int = 1,
    threads: int = 0,
) -> Batch:
    """Run many plants under their controllers along one reference: the bits of closed_loop for each.

    Runs of one course go side by side through the lanes of the processor's vectors; `in_lanes` of the result says which
    did. They have controllers of one type and rate, as they were made, whose settings without a lane of their own
    (lists, bounds, limits) are equal, and machines with the same travel, knots of the cogging and kinds of effects,
    whose friction is smooth. Others run alone: machines that stick or have a state of their own, effects and
    controllers of one's own. The environment variable COGGING_INSTRUCTIONS chooses the instructions: v2, v3, v4 (x86-64
    with SSE4.2, AVX2, AVX-512), neon, or none. No result depends on it.

    Args:
        plants: one a run.
        controllers: one for each plant; they are copied, not changed. Those of Python run one at a time, beside those
            of the core and compiled ones.
        reference: the motion of all runs.
        duration: s; 0 = the reference's own end.
        seeds: of force and encoder noise, one for each plant; none: 0 for all.
        steps_per_sample: the fewest integration steps between two samples.
        threads: that share the runs; 0 = all cores. The result does not depend on it.

    Returns:
        The logs in the order of the plants.

    Raises:
        ValueError: lists of different lengths, a reference that leaves the travel, no duration for a motion without
            an end; COGGING_INSTRUCTIONS names what this machine lacks.
        TypeError: a controller is none, or cannot be copied; says what it lacks.
        DivergedError: a run left its travel by half its length, or is not finite; says when and where.
        ControllerError: a controller of one's own raised, or gave no finite number; says when and in which row.

    Example:
        >>> plants = [cogging.Plant(cogging.AxisParameters(mass=mass)) for mass in (0.1, 0.2)]
        >>> pids = [cogging.Pid(cogging.PidParameters(kp=9600.0, kd=48.0))] * 2
        >>> move = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=2.0))
        >>> batch = cogging.closed_loop_batch(plants, pids, move, duration=0.5)
        >>> [f"{1e6 * abs(log.error).max():.0f} um" for log in batch]
        ['181 um', '306 um']
    """
    runs, in_lanes = _core.closed_loop_batch(
        plants,
        controllers,
        reference,
        duration=duration,
        seeds=seeds,
        steps_per_sample=steps_per_sample,
        threads=threads,
    )
    told = tuple(seeds) or (0,) * len(runs)
    return Batch(tuple(Log.of(columns) for columns in runs), tuple(plants), tuple(controllers), told, tuple(in_lanes))
