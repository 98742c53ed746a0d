"""The forms of `cogging export`, by name.

To add a form: a module in this folder with a function `make(model, **options) -> Exported`, an entry of forms.toml that
names them, and a test that reads the file back. The command, its `--help` and `cogging.export.to` read the list; the
module is imported when its form is used.

Forms may share an option. Defaults are in the signature of `make`: only given options are passed.
`make` raises FieldError or ValueError, `name: rule, got value`; `to` adds the model's file.
"""

from __future__ import annotations

import importlib
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cogging.calls import did_you_mean
from cogging.files import errors_of, read_toml, shipped_toml
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


def require_positive(name: str, value: float) -> float:
    """Return an option that is a finite number above 0, or raise ValueError."""
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{name}: must be finite and above 0, got {quoted(value)}")
    return value


def _forms() -> dict[str, Form]:
    """Return the forms of forms.toml by name."""
    shipped, kinds = shipped_toml("export/forms.toml"), {kind.__name__: kind for kind in (float, int, str, bool)}
    options = {
        name: Option(name, **{**entry, "kind": kinds[entry["kind"]], "choices": tuple(entry.get("choices", ()))})
        for name, entry in shipped["options"].items()
    }
    forms = {}
    for name, entry in shipped["forms"].items():
        names = (shipped["frame"] if entry.get("of_map") else []) + entry.get("options", [])
        forms[name] = Form(name, **{**entry, "options": tuple(options[each] for each in names)})
    return forms


#: Forms by name, in the order of the help.
FORMS = _forms()


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
