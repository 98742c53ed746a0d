"""The result of fit_map: a cogging model with standard errors, table and figure (Lu et al. 2008, Figs. 5, 6)."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from cogging._core import CoggingModel
from cogging.arrays import FloatArray
from cogging.files import InputError
from cogging.model.model import cogging_to_dict
from cogging.model.units import Units
from cogging.outputs import same_file, to_toml, write_files
from cogging.plot.canvas import grid_to_write, plot_method, png
from cogging.plot.results import WHOLE_MAP, whole_map_fit
from cogging.tables import frame_of, html_table
from cogging.values import ByValue


@dataclass(frozen=True)
class HarmonicAmplitude:
    """One harmonic of the map: amplitude sin(2 pi harmonic x / pitch + phase)."""

    harmonic: int  # of the pitch
    amplitude: float  # V; of a modulated harmonic the rms over the points of its local sqrt(f_S^2 + f_C^2)
    standard_error: float  # V, of the amplitude
    phase: float  # rad; of a modulated harmonic that of the means of f_S and f_C
    false_alarm: float  # probability that noise alone lifts any line of the spectrum as far as this one


@dataclass(frozen=True)
class CrossValidation:
    """How well a model predicts the parts of the scan that its fit did not see."""

    order: int  # of the B-splines; 0 = periodic
    coefficients: int  # number of sines and cosines
    rms: float  # V, of the prediction errors
    standard_error: float  # V, of that rms, from its scatter between the blocks left out


@dataclass(frozen=True, eq=False, repr=False)
class MapFit(ByValue):
    """A cogging model fitted to a scan.

    force = F_cogging(x) + offset + trend (x - centre) + direction (coulomb + g(x)).

    Attributes:
        cogging: F_cogging(x), V; zero where no harmonic was found.
        order: of the B-splines; 0 = periodic.
        sine_standard_error: V, (terms, control points), as `cogging.sine`; likewise cosine_standard_error. That of a
            control point in `unexcited` is the prior's.
        amplitudes: one entry a harmonic.
        offset: V, at the centre of the travel; offset_standard_error likewise.
        coulomb, coulomb_standard_error: V, half of the difference of the two directions; None where the scan goes one
            way only.
        direction_amplitudes: of g(x), which changes its sign with the direction of motion, one entry a harmonic; empty
            where there is none, or the scan goes one way only.
        direction_rms: V, of g(x) over the scan's points.
        direction_lag: m, by which a map that follows the motion would give the same: F_cogging(x - lag direction); None
            where no single lag does.
        trend, trend_standard_error: V/m; both 0 where the trend is within 3 standard errors of none and therefore left
            out.
        residual_rms: V, of the averaged points.
        noise: V rms of one averaged point, from the median of the residual's spectrum; where residual_rms is larger,
            the scan has structure that the model lacks.
        cross_validation: the models that were compared, simplest first.
        unexcited: control points (from 0) that the scan determines by less than half; the rest is the prior, which
            continues the neighbours.
        notes: remarks on the fit.
        position, force, direction: the averaged points of the scan: m, V, +1 or -1, (n,).
        fitted: V, (n,), the model with offset, trend and friction at these points.
        line, line_amplitude, line_threshold: the spectrum: f pitch (whole at harmonics), V, and V above which a line is
            found, each (lines,).
        units: labels of force and position.
    """

    cogging: CoggingModel
    order: int
    sine_standard_error: FloatArray
    cosine_standard_error: FloatArray
    amplitudes: tuple[HarmonicAmplitude, ...]
    offset: float
    offset_standard_error: float
    coulomb: float | None
    coulomb_standard_error: float | None
    direction_amplitudes: tuple[HarmonicAmplitude, ...]
    direction_rms: float
    direction_lag: float | None
    trend: float
    trend_standard_error: float
    residual_rms: float
    noise: float
    cross_validation: tuple[CrossValidation, ...]
    unexcited: tuple[int, ...]
    notes: tuple[str, ...]
    position: FloatArray
    force: FloatArray
    direction: FloatArray
    fitted: FloatArray
    line: FloatArray
    line_amplitude: FloatArray
    line_threshold: FloatArray
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        which = ", ".join(str(entry.harmonic) for entry in self.amplitudes) or "none"
        kind = f"splines of order {self.order}" if self.order else "periodic"
        pitch = f"{self.cogging.basis.pitch:g} {self.units.position}"
        return f"harmonics {which} of {pitch}, {kind}; residual {self.residual_rms:.4g} {self.units.command} rms"

    def text(self) -> str:
        """The fit in a few lines for the screen."""
        v, m = self.units.command, self.units.position
        spline, pitch = self.cogging.basis.spline, self.cogging.basis.pitch
        kind = f"order {self.order}, {spline.control_points} control points" if self.order else "periodic"
        lines = [
            f"cogging map: {len(self.position)} points over {np.ptp(self.position):.4g} {m}, pitch {pitch:.4g} {m}, "
            f"{kind}",
            f"harmonic  {f'amplitude ({v})':>13}{f'+- ({v})':>9}  phase (rad)  false alarm",
        ]
        lines += _table(self.amplitudes)
        values = [("offset", self.offset, self.offset_standard_error, v)]
        if self.coulomb is not None and self.coulomb_standard_error is not None:
            values.insert(0, ("coulomb", self.coulomb, self.coulomb_standard_error, v))
        if self.trend_standard_error > 0.0:
            values.append(("trend", self.trend, self.trend_standard_error, self.units.of("V/m")))
        lines += [f"{name:8s}  {value:13.5g}  {error:7.1g}  {unit}" for name, value, error, unit in values]
        if self.direction_amplitudes:
            lines += ["changes sign with the direction of motion:", *_table(self.direction_amplitudes)]
        lines.append(f"residual  {self.residual_rms:13.5g}  {v} rms; noise {self.noise:.3g} {v} rms")
        for c in self.cross_validation:
            name, mark = (f"order {c.order}" if c.order else "periodic"), "  <- chosen" * (c.order == self.order)
            compared = f"{v} rms, {name}, {c.coefficients} coefficients{mark}"
            lines.append(f"predicts  {c.rms:13.5g}  {c.standard_error:7.1g}  {compared}")
        return "\n".join(lines + [f"note: {note}" for note in self.notes])

    def to_dict(self) -> dict[str, Any]:
        """What `cogging map --json` writes: the fit without the points of the scan and of the spectrum."""
        names = [entry.name for entry in fields(self)]
        document = {name: getattr(self, name) for name in names[: names.index("notes")]}
        for name in ("amplitudes", "direction_amplitudes", "cross_validation"):
            document[name] = [vars(entry) for entry in document[name]]
        return document | {
            "cogging": cogging_to_dict(self.cogging),
            "points": len(self.position),
            "notes": self.notes,
        }

    def to_frame(self) -> Any:
        """The harmonics as a pandas DataFrame (extra `frames`), a row each, with units in `attrs["units"]`."""
        columns = {one.name: [getattr(a, one.name) for a in self.amplitudes] for one in fields(HarmonicAmplitude)}
        return frame_of(columns, dict.fromkeys(("amplitude", "standard_error"), self.units.command) | {"phase": "rad"})

    def _repr_html_(self) -> str:
        v = self.units.command
        rows = [[a.harmonic, a.amplitude, a.standard_error, a.phase, a.false_alarm] for a in self.amplitudes]
        headers = ["harmonic", f"amplitude ({v})", f"standard error ({v})", "phase (rad)", "false alarm"]
        return html_table(f"MapFit: {self._brief()}", headers, rows, self.notes)

    plot = plot_method(whole_map_fit, "Draw the map with its 95 % band, the residual and the spectrum.", "three axes")

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the `[cogging]` section of a model file, and the figure beside it as .png.

        Labels of units other than V and m are written too, as `[units]`.

        Raises:
            InputError: a file cannot be written, or both are one: a model called `.png`.
        """
        picture = png(self.plot(ax=grid_to_write(3, 1, WHOLE_MAP)))
        labels = {} if self.units == Units() else {"units": self.units.to_dict()}
        text = to_toml({"cogging": cogging_to_dict(self.cogging), **labels})
        figure = os.fspath(Path(path).with_suffix(".png"))
        if same_file(path, figure):
            raise InputError(f"{path}: must not be where its figure is written, got {figure}")
        write_files({os.fspath(path): [text.encode()], figure: [picture]})


def _table(entries: tuple[HarmonicAmplitude, ...]) -> list[str]:
    return [
        f"{a.harmonic:8d}  {a.amplitude:13.5g}  {a.standard_error:7.1g}  {a.phase:11.3f}  {a.false_alarm:11.1g}"
        for a in entries
    ]
