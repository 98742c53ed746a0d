"""What an audit found that bears on what is concluded from a log, in sentences."""

from __future__ import annotations

from cogging.log_check.audit import Audit
from cogging.model.model import Model

SATURATED = 0.02  # of the rows, at the limit of the command
AT_REST = 0.5  # of the rows
MISSING = 0.005  # of the time, in gaps ...
PLACES = 5  # ... of which there are so many: fewer are pauses, not lost samples
JITTER_SHARE, JITTER = 0.05, 0.02  # of the steps that are uneven, and their rms, of the step
SLOW = 0.1  # s from row to row: what friction and cogging do lies between such rows
QUANTUM = 1.5  # by which the step of the readings may be larger than the stated one


def hints(found: Audit, model: Model) -> list[str]:
    """Sentences on saturation, rest, lost samples, slow or uneven rows and a coarse encoder; none where none matters.

    Args:
        found: audit of the log.
        model: whose encoder is compared, and whose units count.

    Returns:
        What to bear in mind, each with its figure.
    """
    said, of = [], model.units.of
    if found.saturation_share > SATURATED:
        top = max(abs(value) for value in found.command)
        said.append(
            f"the command stands at its limit ({top:.4g} {of('V')}) in {100 * found.saturation_share:.2g} % of the "
            "rows: what the controller asked for beyond it is not known"
        )
    if found.share_at_rest > AT_REST:
        said.append(
            f"{100 * found.share_at_rest:.0f} % of the rows are at rest, where friction hides every force, and do not "
            "count"
        )
    missing = _missing(found)
    if missing > MISSING:
        said.append(
            f"rows are missing in {found.gaps} places, {100 * missing:.2g} % of the time, at most "
            f"{found.gap_longest:.3g} s on end: what happened there is not known"
        )
    step = 1.0 / found.rate
    if step > SLOW:
        said.append(
            f"rows are {step:.3g} s apart, and what friction and cogging do lies between them: give --scale time=0.001 "
            "if the time is in ms"
        )
    if found.jitter_share > JITTER_SHARE and found.jitter_rms > JITTER * step:
        said.append(
            f"rows are uneven by {found.jitter_rms:.2g} s rms ({100 * found.jitter_rms / step:.2g} % of a step): "
            "delays and lags below that cannot be told"
        )
    stated = model.encoder.resolution
    if stated > 0.0 and found.encoder_quantum > QUANTUM * stated:
        said.append(
            f"readings step by {found.encoder_quantum:.4g} {of('m')}, the model's encoder by {stated:.4g} {of('m')}"
        )
    return said


def _missing(found: Audit) -> float:
    """Share of the time in which there are no rows; 0 where that is a few pauses."""
    if found.duration <= 0.0 or found.gaps < PLACES:
        return 0.0
    return max(0.0, 1.0 - (found.rows - 1) / found.rate / found.duration)
