"""The text of a first model file: every number with how it was found, or that it is to be filled in or assumed."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence

from cogging.first_model.pitch import Wave
from cogging.first_model.sizes import WIDTH, Sizes
from cogging.log_check.audit import Audit
from cogging.log_check.recovery import RecoveredController
from cogging.model.units import Units

MARGIN = 0.05  # of the travel that was seen, to either side
CROSSOVER = 0.01  # of the sample rate: closed-loop poles, rad/s over 2 pi, of gains that are proposed for trying


def model_lines(
    name: str,
    units: Units,
    told_units: Sequence[str],
    sizes: Sizes,
    travel: tuple[float, float],
    audit: Audit,
    controller: RecoveredController | None,
    wave: Wave | None,
) -> list[str]:
    """The lines of the file.

    Args:
        name: of the log.
        units: labels of command and position.
        told_units: how they are known, command first.
        sizes: mass and friction.
        travel: m, of the axis.
        audit: of the log.
        controller: that reproduces the log's command, if one does.
        wave: that stands out over position, if one does.
    """
    lines = [
        f"## A first model of the axis that made {name}, by `cogging init`.",
        "## found: from the log. assumed: by nobody's measurement, replace it where you know better.",
        "## A line behind a single # is a proposal: take the # away to have it.",
        "## Check each line, then fit it: cogging identify. (A fitted model is written without these comments.)",
        "",
        *_axis(units, sizes, travel, audit),
        "",
        "[encoder]",
        *_encoder(units, audit),
        "",
        "[units]                     # labels only: no number is converted by them",
        _line("command", json.dumps(units.command), told_units[0]),
        _line("position", json.dumps(units.position), told_units[1]),
    ]
    if units.command == "%":
        lines.append("## % of what? The scale of the drive makes newtons or amperes of it: --scale command=...")
    return [*lines, "", *_cogging(units, wave, travel), "", *_controller(units, sizes, audit, controller)]


def _axis(units: Units, sizes: Sizes, travel: tuple[float, float], audit: Audit) -> list[str]:
    law = "mass x'' = command - viscous x' - coulomb S(x') - cogging(x)"
    lines = [f"[axis]                      # {law}"]
    for name, unit in (("mass", "V/(m/s^2)"), ("viscous", "V/(m/s)"), ("coulomb", "V")):
        size = sizes.sizes[name]
        lines.append(_line(name, number(size.value), f"{units.of(unit)}; {size.told}"))
    width = WIDTH * sizes.speed if sizes.speed > 0.0 else 1e-3
    lines += [
        _line("coulomb_width", number(width), f"{units.of('m/s')}; assumed: {100 * WIDTH:g} % of the top speed"),
        _line("travel", f"[{number(travel[0], 6)}, {number(travel[1], 6)}]", f"{units.of('m')}; {_seen(units, audit)}"),
        "",
        "[axis.uncertainty]          # relative, 1 sigma; 0 = exact; left out = unknown within a factor of three",
    ]
    for name, size in sizes.sizes.items():
        if size.uncertainty is None:
            lines.append(f"# {name} = 0.2              # not told by this log: fill in what you know")
        else:
            lines.append(_line(name, number(size.uncertainty, 2), "how far the first balance can be trusted"))
    return lines


def _seen(units: Units, audit: Audit) -> str:
    low, high = audit.travel
    return f"found: {low:.5g} to {high:.5g} {units.of('m')} in this log, and a margin; fill in the axis' own"


def _encoder(units: Units, audit: Audit) -> list[str]:
    quantum = audit.encoder_quantum
    found = "found: the readings differ by multiples of it (the last digit of the file, if that is coarser)"
    none = "no step could be told from the readings; fill in"
    return [_line("resolution", number(quantum), f"{units.of('m')}; {found if quantum else none}")]


def _cogging(units: Units, wave: Wave | None, travel: tuple[float, float]) -> list[str]:
    lines = ["# [cogging]                 # opposes the command"]
    if wave is None:
        span = 0.1 * (travel[1] - travel[0])
        lines += [
            "## no period over position stands out of this log: fill in the magnets' pitch",
            f"# pitch = {number(span, 2):<18} # {units.of('m')}; to be filled in",
            "# harmonics = [1, 2]",
        ]
        return [*lines, f"# sine = [[0.0], [0.0]]     # {units.command}", "# cosine = [[0.0], [0.0]]"]
    share = f"{100.0 * wave.share:.0f} % of what mass and friction leave"
    return [
        *lines,
        f"# pitch = {number(wave.period):<18} # {units.of('m')}; found: the strongest wave over position, {share};",
        "##                           it may as well be a harmonic of the magnets' pitch: compare with the data sheet",
        "# harmonics = [1]",
        f"# sine = [[{number(wave.sine)}]]          # {units.of('V')}; found",
        f"# cosine = [[{number(wave.cosine)}]]        # {units.of('V')}; found",
    ]


def _controller(units: Units, sizes: Sizes, audit: Audit, found: RecoveredController | None) -> list[str]:
    lines = ["# [controller]              # simulate and predict need it"]
    if found is not None:
        fields = {"type": found.type, **found.parameters.to_dict()}
        told = f"found: these gains leave {found.residual_rms:.2g} {units.of('V')} rms of the logged command"
        return [*lines, f"## {told}", *(f"# {key} = {_value(value)}" for key, value in fields.items())]
    rate, mass = rounded_rate(audit.rate), sizes.sizes["mass"].value
    pole = 2.0 * math.pi * CROSSOVER * rate
    gains = {"kp": 3.0 * mass * pole**2, "ki": mass * pole**3, "kd": 3.0 * mass * pole}
    lines += [
        "## this log does not tell it: fill in yours. The gains below are a proposal for trying, from the mass alone:",
        f"## three poles at {CROSSOVER:g} of the sample rate.",
        '# type = "pid"',
        f"# sample_rate = {rate:g}",
    ]
    for (key, value), unit in zip(gains.items(), ("V/m", "V/(m s)", "V/(m/s)"), strict=True):
        lines.append(f"# {key} = {number(value, 3):<20} # {units.of(unit)}; assumed")
    return lines


def rounded_rate(rate: float) -> float:
    """A rate as a maker would set it: to three digits."""
    return float(f"{rate:.3g}")


def number(value: float, digits: int = 4) -> str:
    """A number as TOML reads it back, to so many digits, always a float."""
    text = f"{value:.{digits}g}"
    return text if any(mark in text for mark in ".en") else f"{text}.0"


def _value(value: object) -> str:
    if isinstance(value, float):
        return number(value, 6) if math.isfinite(value) else ("inf" if value > 0.0 else "-inf")
    return json.dumps(value)


def _line(key: str, value: str, comment: str) -> str:
    return f"{f'{key} = {value}':<27} # {comment}"
