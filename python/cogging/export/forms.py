"""The forms that `cogging export` writes, each by its name.

A form is added in three steps: a module of this room with a function `make(model, **options) -> Exported`, an entry of
FORMS below that names module and function, and a test that reads back what it writes. The command, its `--help` and
`cogging.export.to` read the list. A module is imported when its form is asked for: what it needs may be an extra.

An option is stated once, as an Option; forms that share it list the same object. The command turns `pole_pairs` into
`--pole-pairs`, passes on only what was given, and refuses an option that the form does not take: the defaults stand in
the signature of `make`. What cannot be used is refused there by a FieldError or ValueError in one line, `name: rule,
got value`; `to` puts the model's file before it.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cogging.calls import did_you_mean
from cogging.files import FieldError, InputError, read_text, read_toml
from cogging.model.model import Model
from cogging.shown import quoted


@dataclass(frozen=True)
class Exported:
    """What a form makes of a model.

    Attributes:
        content: of the file.
        text: what the machine takes of it and what it cannot, for the screen.
        beside: further files by what is added to the file's name, `.txt`.
    """

    content: bytes
    text: str
    beside: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Option:
    """A number, word or switch that a form may be given.

    Attributes:
        name: the keyword, in full words with `_`.
        kind: float, int, str, or bool for a switch.
        help: meaning and unit, with what holds where it is not given.
        metavar: what stands for the value in `--help`.
        choices: the words that it may be; none = any.
        reads: whether it is the path of a file that is read.
    """

    name: str
    kind: type[Any]
    help: str
    metavar: str = "X"
    choices: tuple[str, ...] = ()
    reads: bool = False


@dataclass(frozen=True)
class Form:
    """A form in which a model, or a part of it, leaves.

    Attributes:
        name: as in `--to`.
        writes: what the file is, in a few words.
        made_by: module and function, `cogging.export.drives.akd:make`.
        options: that it takes.
        of_map: whether `[cogging]` alone is enough, as `cogging map` writes it: there need be no `[axis]`.
    """

    name: str
    writes: str
    made_by: str
    options: tuple[Option, ...] = ()
    of_map: bool = False

    def make(self, model: Model, options: Mapping[str, Any]) -> Exported:
        """Make it of a model.

        Raises:
            ValueError: an option that the form does not take; a model or a value that it cannot express.
        """
        names = [option.name for option in self.options]
        for name in options:
            if name not in names:
                raise ValueError(f"{name}: must be an option of the form {self.name}: {did_you_mean(name, names)}")
        module, function = self.made_by.split(":")
        made: Exported = getattr(importlib.import_module(module), function)(model, **options)
        return made


NAME = Option(
    "name", str, "name in code: the header's namespace, the unit's model identifier; axis where not given", "NAME"
)

SAMPLE_RATE = Option(
    "sample_rate", float, "Hz, at which noise is drawn and steps are proposed; the controller's where not given", "HZ"
)

#: Forms by name, in the order of the help.
_ALL: tuple[Form, ...] = (
    Form("cpp", "the controller with its gains as one C++ header", "cogging.export.cpp_header:make", (NAME,)),
    Form("fmi", "the axis as a unit of FMI 3.0, co-simulation", "cogging.export.fmi:make", (NAME, SAMPLE_RATE)),
)
FORMS: dict[str, Form] = {form.name: form for form in _ALL}


def to(model: Model | str | os.PathLike[str], form: str, **options: Any) -> Exported:
    """Make what `cogging export MODEL.toml --to FORM` writes.

    Args:
        model: a Model, or the path of a model file (for a map: of what `cogging map` wrote).
        form: a key of FORMS.
        **options: of that form, FORMS[form].options.

    Returns:
        Content of the file, what is beside it, and what the machine takes of it.

    Raises:
        ValueError: there is no such form, it does not take an option, or the model cannot be expressed in it.
        InputError: the file cannot be used.
    """
    if form not in FORMS:
        raise ValueError(f"form: must be one of {', '.join(FORMS)}, got {quoted(form)}: {did_you_mean(form, FORMS)}")
    chosen = FORMS[form]
    if isinstance(model, Model):
        return chosen.make(model, options)
    try:
        return chosen.make(_read(model, of_map=chosen.of_map), options)
    except FieldError as error:
        raise error.in_file(model, read_text(model)) from None
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{os.fspath(model)}: {error}") from None


def _read(path: str | os.PathLike[str], *, of_map: bool) -> Model:
    """Read a model file; where a map is enough, also one without `[axis]`."""
    document = read_toml(path)
    if of_map and "cogging" in document and "axis" not in document:
        document["axis"] = {"mass": 1.0}  # that no form of a map looks at
    return Model.from_dict(document)


def option_of(name: str) -> str:
    """An option as it is written on the command line."""
    return f"--{name.replace('_', '-')}"


def shown_forms() -> str:
    """The forms and what they write, a line each."""
    return "\n".join(f"  {form.name:10s} {form.writes}" for form in FORMS.values())
