"""Figures of the family in the large, from answers and truths."""

from __future__ import annotations

from dataclasses import dataclass

from .runner import Answer

SURE = 0.9  # a name of this confidence is a claim
GROWS = 1.01
AS_LARGE = 0.8  # an effect whose gap is so large a share of the largest may stand first too


@dataclass(frozen=True)
class Outcome:
    """How one answer stands against the truth.

    Attributes:
        first: the first name, or an alternative of it, is the largest effect; None where none is hidden or misread.
        wrong: names with confidence that are not hidden.
        grows: which gaps grew.
        said: a misreading was said as what it is: "kind" with its kind, "verdict" without; "" not; None where none is.
            A log that is refused with a message that says it counts too.
        found, hidden: how many of the true effects were named.
        accused: a log that is read rightly was said to be misread.
    """

    first: bool | None
    wrong: tuple[str, ...]
    grows: tuple[str, ...]
    said: str | None
    found: int
    hidden: int
    accused: bool


def judge(answer: Answer) -> Outcome:
    """Hold an answer against its case."""
    assert answer.case is not None
    truth = answer.case.truth
    named = [{effect["name"], *effect["alternatives"]} for effect in answer.effects]
    largest = {n for n, size in zip(truth.names, truth.sizes, strict=True) if size >= AS_LARGE * truth.sizes[0]}
    sure = [effect["name"] for effect in answer.effects if effect["confidence"] >= SURE]
    every = set().union(*named) if named else set()
    reading = truth.misreading
    said = None
    if reading is not None:
        told = f"{answer.mismatch} {answer.error}".lower()
        # an axis with the other sign of its command is one with the other sign of its position
        columns = ("command", "position") if reading.kind == "sign" else reading.columns
        kind = reading.kind in told and any(column in told for column in columns)
        said = ("kind" if kind else "verdict") if answer.verdict == "data_mismatch" else ""
        if answer.verdict == "error" and kind:  # refused at once, with the scale that would mend it
            said = "kind"
    return Outcome(
        first=bool(named and named[0] & largest) if truth.names and reading is None else None,
        wrong=tuple(name for name in sure if name not in truth.names),
        grows=growing(answer.gap),
        said=said,
        found=len(every & set(truth.names)) if reading is None else 0,
        hidden=len(set(truth.names)) if reading is None else 0,
        accused=reading is None and answer.verdict == "data_mismatch",
    )


def growing(gap: dict[str, float]) -> tuple[str, ...]:
    """Which gaps are larger than what they should lie under by more than a hundredth."""
    pairs = [("before", "given"), ("after", "given"), ("after", "before")]
    pairs += [(f"confirm_{one}", f"confirm_{other}") for one, other in pairs]
    return tuple(f"{a} > {b}" for a, b in pairs if a in gap and b in gap and gap[a] > GROWS * gap[b])


def figures(answers: list[Answer]) -> str:
    """The table of a run."""
    drawn = [answer for answer in answers if answer.case is not None]
    outcomes = [judge(answer) for answer in drawn]
    first = [o.first for o in outcomes if o.first is not None]
    said = [o.said for o in outcomes if o.said is not None]
    found, hidden = sum(o.found for o in outcomes), sum(o.hidden for o in outcomes)
    seconds = sorted(answer.seconds for answer in drawn)
    rows = [
        ("right first name, up to alternatives", sum(first), len(first)),
        ("true effects named, up to alternatives", found, hidden),
        ("confident and wrong", sum(bool(o.wrong) for o in outcomes), len(drawn)),
        ("a gap grows", sum(bool(o.grows) for o in outcomes), len(drawn)),
        ("misreadings said", sum(s != "" for s in said), len(said)),
        ("  with column and kind", sum(s == "kind" for s in said), len(said)),
        ("misreading said of a log that is read rightly", sum(o.accused for o in outcomes), len(drawn) - len(said)),
        ("no answer", sum(a.verdict == "no answer" for a in drawn), len(drawn)),
        ("errors", sum(a.verdict == "error" and not o.said for a, o in zip(drawn, outcomes, strict=True)), len(drawn)),
    ]
    lines = [f"{what:<46}{k:>4} of {n:>3}" + (f"{100 * k / n:>6.0f} %" if n else "") for what, k, n in rows]
    if seconds:
        lines.append(f"{'seconds a case, median and largest':<46}{seconds[len(seconds) // 2]:.1f}, {seconds[-1]:.1f}")
    return "\n".join(lines)


def line(answer: Answer) -> str:
    """One case on one line: what is true, and what was said."""
    if answer.case is None:
        return f"{answer.index:4d} {answer.error}"
    truth, outcome = answer.case.truth, judge(answer)
    sizes = ", ".join(f"{name} {size:.2g}" for name, size in zip(truth.names, truth.sizes, strict=True))
    hidden = f"{sizes or 'nothing'} ({100 * truth.share:.0f} %)"
    if truth.misreading is not None:
        hidden += f", {' '.join(truth.misreading.columns)} x {truth.misreading.factor:.4g}"
    known = "loop stated" if "controller" in answer.case.model else "no loop"
    columns = "with" if "reference" in answer.case.log else "without"
    what = f"{truth.kind}, {truth.machine.statement}, {known}, {columns} reference"
    names = ", ".join(" or ".join([e["name"], *e["alternatives"]]) + f" {e['confidence']:.2f}" for e in answer.effects)
    gaps = ", ".join(f"{name} {value:.3g}" for name, value in answer.gap.items())
    marks = [f"WRONG {', '.join(outcome.wrong)}"] if outcome.wrong else []
    marks += [f"GROWS {', '.join(outcome.grows)}"] if outcome.grows else []
    marks += ["first right" if outcome.first else "FIRST NOT RIGHT"] if outcome.first is not None else []
    marks += [f"misreading {outcome.said or 'NOT SAID'}"] if outcome.said is not None else []
    marks += ["MISREADING SAID OF A RIGHT LOG"] if outcome.accused else []
    reason = answer.error or answer.mismatch or ""
    return (
        f"{answer.index:4d} [{what}] {hidden}\n"
        f"     -> {answer.verdict} {names}{f' ({reason})' if reason else ''}; gap {gaps or 'none'}; "
        f"{answer.seconds:.1f} s; {'; '.join(marks)}"
    )
