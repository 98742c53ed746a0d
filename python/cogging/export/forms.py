"""The forms of `cogging export`, by name.

To add a form: a module in this folder with a function `make(model, **options) -> Exported`, an entry of FORMS that
names them, and a test that reads the file back. The command, its `--help` and `cogging.export.to` read the list; the
module is imported when its form is used.

Forms that share an option list the same Option. Defaults are in the signature of `make`: only given options are passed.
`make` raises FieldError or ValueError, `name: rule, got value`; `to` adds the model's file.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cogging.calls import did_you_mean
from cogging.files import errors_of, read_toml
from cogging.model.model import Model
from cogging.shown import quoted


@dataclass(frozen=True)
class Exported:
    """What a form makes of a model."""

    content: bytes  # of the file
    text: str  # what the machine uses of the model and what it cannot represent
    beside: Mapping[str, bytes] = field(default_factory=dict)  # further files by suffix, `.txt`

    def files(self, path: str | os.PathLike[str]) -> dict[str, list[bytes]]:
        """Return the content of all files by path, for write_files."""
        name = os.fspath(path)
        return {name: [self.content], **{name + suffix: [content] for suffix, content in self.beside.items()}}


@dataclass(frozen=True)
class Option:
    """An option of a form: a number, a word or a switch."""

    name: str  # the keyword, in full words with `_`
    kind: type[Any]  # float, int, str, or bool for a switch
    help: str  # meaning, unit and default
    metavar: str = "X"  # of the value in `--help`
    choices: tuple[str, ...] = ()  # allowed words; none = any


@dataclass(frozen=True)
class Form:
    """A form of export."""

    name: str  # as in `--to`
    writes: str  # description of the file
    made_by: str  # module and function, `cogging.export.drives:akd`
    options: tuple[Option, ...] = ()
    of_map: bool = False  # whether `[cogging]` alone suffices, as written by `cogging map`

    def make(self, model: Model, options: Mapping[str, Any]) -> Exported:
        """Return what the form makes of a model, or raise ValueError for an option or a model that it does not take."""
        known = {option.name: option for option in self.options}
        for name, value in options.items():
            if name not in known:
                raise ValueError(f"{name}: must be an option of the form {self.name}: {did_you_mean(name, known)}")
            if (choices := known[name].choices) and value not in choices:
                raise ValueError(f"{name}: must be one of {', '.join(choices)}, got {quoted(value)}")
        module, function = self.made_by.split(":")
        made: Exported = getattr(importlib.import_module(module), function)(model, **options)
        return made


_SCALE = Option(
    "scale", float, "units of the drive per command unit of the model, as A per N; default: they are the same"
)
_SIGN = Option("sign", int, "-1: the drive subtracts its table, or the map is the motor's push; default 1", "S")
_ZERO = Option("zero", float, "position of the model at which the drive is at 0; default 0")
_REVERSE = Option("reverse", bool, "the drive counts and pushes the other way")
_TURN = Option(
    "turn", float, "one mechanical revolution, in the model's unit of position; default 2 pi where that is rad"
)
_FRAME = (_SCALE, _SIGN, _ZERO, _REVERSE, _TURN)
_BETWEEN = Option("between", str, "between entries: straight lines, or each held", choices=("linear", "hold"))
_ENTRIES = Option("entries", int, "entries of the table", "N")
_WIDTH = Option("pole_pair_width", float, "magnetic period of a linear motor, m; default: the pitch of the map")
_OVER = Option("over", str, "what the table covers", choices=("travel", "turn", "period"))
_QUANTUM = Option("quantum", float, "step of an entry, A; default 0.001")
_PAIRS = Option("pole_pairs", int, "electrical periods a revolution", "N")
_QUANTITY = Option("quantity", str, "what the firmware's map is of", choices=("torque", "current"))
_WAVE = Option("wave", str, "which wave has the phase phi", choices=("cosine", "sine"))
_CHANNEL = Option("channel", str, "of a two-channel drive", choices=("A", "B"))
_NAME = Option("name", str, "name in code: of the namespace, of the unit; default axis", "NAME")
_RATE = Option("sample_rate", float, "Hz, at which a unit draws noise; default the controller's", "HZ")


def _drive(name: str, writes: str, *options: Option) -> Form:
    """Return a form of a map, with the options of the frame."""
    return Form(name, writes, f"cogging.export.drives:{name}", (*_FRAME, *options), of_map=True)


#: Forms by name, in the order of the help.
FORMS: dict[str, Form] = {
    form.name: form
    for form in (
        _drive("csv", "a map by position: position, force", _ENTRIES, _OVER, _BETWEEN),
        _drive("akd", "a map as Kollmorgen AKD's compensation table (csv)", _ENTRIES, _BETWEEN, _QUANTUM),
        _drive("sinamics", "a map as Siemens SINAMICS' p5260[0..4095]", _BETWEEN, _WIDTH),
        _drive("ax8000", "a map as Beckhoff AX8000's coefficients (0x32CB)", _WAVE, _CHANNEL),
        _drive("novanta", "a map as Novanta's 0x2306 to 0x2308", _ENTRIES, _PAIRS, _WIDTH, _BETWEEN),
        _drive("odrive", "a map as the anticogging map of ODrive 0.5", _QUANTITY),
        _drive("moteus", "a map as moteus' motor.cogging_dq_comp"),
        Form("cpp", "the controller with its gains as one C++ header", "cogging.export.cpp_header:make", (_NAME,)),
        Form("fmi", "the axis as a unit of FMI 3.0, co-simulation", "cogging.export.fmi:make", (_NAME, _RATE)),
    )
}


def to(model: Model | str | os.PathLike[str], form: str, **options: Any) -> Exported:
    """Return what `cogging export MODEL.toml --to FORM` writes.

    Args:
        model: a Model, or the path of a model file (for a map also of the output of `cogging map`).
        form: a key of FORMS.
        **options: of that form, FORMS[form].options.

    Returns:
        Content of the files, and what the machine uses of the model.

    Raises:
        ValueError: an unknown form or option, or the model cannot be expressed in the form.
        InputError: the file is invalid.
    """
    if form not in FORMS:
        raise ValueError(f"form: must be one of {', '.join(FORMS)}, got {quoted(form)}: {did_you_mean(form, FORMS)}")
    chosen = FORMS[form]
    if isinstance(model, Model):
        return chosen.make(model, options)
    with errors_of(model):
        document = read_toml(model)
        if chosen.of_map and "cogging" in document and "axis" not in document:  # as `cogging map` writes it
            document["axis"] = {"mass": 1.0}  # no form of a map uses it
        return chosen.make(Model.from_dict(document), options)
