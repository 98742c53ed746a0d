"""Checks of arguments: a wrong call raises one line that names function, argument, rule and value."""

from __future__ import annotations

import ast
import functools
import inspect
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from cogging.arrays import no_number_in
from cogging.shown import nearest_name, quoted

F = TypeVar("F", bound=Callable[..., Any])
C = TypeVar("C")
MOST_LISTED = 12  # names that a message lists where none is similar
PATH: tuple[type, ...] = (str, os.PathLike)
ARRAY = "an array of real numbers"
UNCHECKED = re.compile(r"\[(object|typing\.Any)\]")  # a list whose entries the core checks itself: controllers
WHOLE, NUMBER, TEXT = re.compile(r"\bint\b"), re.compile(r"\b(float|int)\b"), re.compile(r"\bstr\b")
FIXED_SIZE = re.compile(r"FixedSize\((\d+)\)")


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return the end of a message about an unknown word: the nearest known one, or the list of them."""
    names = [str(name) for name in known]
    near = nearest_name(str(word), names)
    if near is not None:
        return f"did you mean {near}?"
    listed = names if len(names) <= MOST_LISTED else [*names[:MOST_LISTED], "..."]
    return f"known: {', '.join(listed) or 'none'}"


def entry_named(name: str, entries: Mapping[str, C], what: str) -> C:
    """Return the entry of a name; KeyError names the nearest one."""
    if name not in entries:
        raise KeyError(f"{name}: is no {what} of it; {did_you_mean(name, entries)}")
    return entries[name]


def described(value: Any) -> str:
    """Return a short description of a value of the wrong type."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if value is None or isinstance(value, bool | np.bool_ | int | float | str):
        return quoted(bool(value) if isinstance(value, np.bool_) else value)
    if isinstance(value, type):
        return f"the class {value.__name__} itself"
    kind = type(value).__name__
    if isinstance(value, dict | list | tuple) and len(value) <= 4:
        return f"a {kind}: {quoted(value)}"
    return _with_article(kind)


def _with_article(name: str) -> str:
    return f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"


# Functions in Python ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Kind:
    """The types that an argument of a public function may have."""

    types: tuple[type, ...]
    called: str  # in words
    several: bool = False  # whether a list of them is accepted too
    hints: Mapping[str, str] = field(default_factory=dict)  # what to do instead, by the name of a type often passed

    def problem(self, value: Any) -> str:
        """Return what is wrong with a value; empty if nothing is."""
        entries = value if self.several and isinstance(value, list | tuple) else [value]
        wrong = [entry for entry in entries if not isinstance(entry, self.types)]
        if not wrong:
            return ""
        hint = self.hints.get(type(wrong[0]).__name__, "")
        return f"must be {self.called}, got {described(wrong[0])}{': ' * bool(hint)}{hint}"


PATHS = Kind(PATH, "the path of a file")


def check_arguments(**kinds: Kind) -> Callable[[F], F]:
    """Return a decorator that raises TypeError for an unknown keyword or an argument of another type."""

    def decorate(function: F) -> F:
        parameters = inspect.signature(function).parameters.values()
        names = [parameter.name for parameter in parameters]
        open_ended = any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters)
        name = function.__qualname__.removesuffix(".__init__")

        @functools.wraps(function)
        def checked(*given: Any, **named: Any) -> Any:
            for word in named:
                if word not in names and not open_ended:
                    known = [one for one in names if one != "self"]
                    raise TypeError(f"{name}: {word}: is not an argument; {did_you_mean(word, known)}")
            for word, value in [*zip(names, given, strict=False), *named.items()]:
                if word in kinds and (problem := kinds[word].problem(value)):
                    raise TypeError(f"{name}: {word}: {problem}")
            return function(*given, **named)

        return checked  # type: ignore[return-value]

    return decorate


def check_constructor(kind: type[C]) -> type[C]:
    """Let the constructor of a class raise TypeError for an unknown keyword (a decorator)."""
    setattr(kind, "__init__", check_arguments()(kind.__init__))  # noqa: B010 - mypy does not let a method be assigned
    return kind


# Functions of the core: the bindings call `explain_mismatch` and `explain_non_number` --------------------------------


@functools.cache
def signature(doc: str) -> tuple[str, dict[str, inspect.Parameter]]:
    """Return name and parameters of a function of the core from the first line of its docstring."""
    function: Any = ast.parse(f"def {doc.partition(chr(10))[0]}: ...").body[0]
    given, empty, found = function.args, inspect.Parameter.empty, {}
    positional = [*given.posonlyargs, *given.args]
    defaults = [empty] * (len(positional) - len(given.defaults)) + given.defaults
    defaults += [empty if default is None else default for default in given.kw_defaults]
    for place, (one, default) in enumerate(zip([*positional, *given.kwonlyargs], defaults, strict=True)):
        by_position = place < len(positional)
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD if by_position else inspect.Parameter.KEYWORD_ONLY
        annotation = ast.unparse(one.annotation) if one.annotation else ""
        found[one.arg] = inspect.Parameter(one.arg, kind, default=default, annotation=annotation)
    return function.name, found


def _call(
    doc: str, given: Sequence[Any], named: Mapping[str, Any]
) -> tuple[str, dict[str, inspect.Parameter], Sequence[Any], list[str], dict[str, Any]]:
    """Return name, parameters, arguments by position, the words that these have, and all arguments by name."""
    name, parameters = signature(doc)
    if next(iter(parameters), "") == "self":  # of a constructor or a method
        (_, own), *rest = parameters.items()
        name, parameters, given = own.annotation.split(".")[-1], dict(rest), given[1:]
    places = [word for word, one in parameters.items() if one.kind is not one.KEYWORD_ONLY]
    return name, parameters, given, places, {**dict(zip(places, given, strict=False)), **named}


def explain_mismatch(doc: str, given: Sequence[Any], named: Mapping[str, Any]) -> str:
    """Return in one line why a call does not match the signature at the beginning of a docstring of the core."""
    name, parameters, given, places, arguments = _call(doc, given, named)
    if len(given) > len(places):
        if not places:
            words = ", ".join(f"{word}=..." for word in list(parameters)[:3])
            return f"{name}: must be given its arguments by keyword ({words}), got {described(given[0])} without one"
        return f"{name}: must be given {len(places)} arguments by position, got {len(given)}; the rest by keyword"
    for word in named:
        if word not in parameters:
            return f"{name}: {word}: is not an argument; {did_you_mean(word, parameters)}"
    for word, value in arguments.items():
        if rule := broken_rule(parameters[word].annotation, value):
            return f"{name}: {word}: must be {rule}, got {described(value)}"
    for word, one in parameters.items():
        if one.default is one.empty and word not in arguments:
            return f"{name}: {word}: must be given, got nothing"
    return f"{name}: these arguments do not go together: {', '.join(arguments) or 'none'}"


def explain_non_number(doc: str, given: Sequence[Any], named: Mapping[str, Any]) -> str | None:
    """Return in one line which argument has a truth value or a text where a number belongs; None if none has."""
    name, parameters, _, _, arguments = _call(doc, given, named)
    for word, value in arguments.items():
        if type(value) in (float, int) or word not in number_places(doc):
            continue
        annotation = parameters[word].annotation
        alone = not (_is_array(annotation) or "Sequence[" in annotation or isinstance(value, np.ndarray))
        wrong = [value] * isinstance(value, bool | np.bool_) if alone else no_number_in(value)
        if wrong:
            among = "" if wrong[0] is value or getattr(value, "ndim", 1) == 0 else " among them"
            return f"{name}: {word}: must be {_rule_of(annotation)}, got {described(wrong[0])}{among}"
    return None


@functools.cache
def number_places(doc: str) -> frozenset[int | str]:
    """Return places and words of the arguments that are numbers or arrays of them."""
    places = set[int | str]()
    for place, (word, one) in enumerate(signature(doc)[1].items()):
        if _is_array(one.annotation) or (NUMBER.search(one.annotation) and "str" not in one.annotation):
            places |= {place, word}
    return frozenset(places)


def broken_rule(annotation: str, value: Any) -> str:
    """Return what an argument of the core must be, in words; empty if the value is that."""
    if value is None:
        fits = "None" in annotation
    elif "Sequence[" in annotation:
        size = FIXED_SIZE.search(annotation)
        fits = (
            not isinstance(value, str | bytes | dict)
            and hasattr(value, "__len__")
            and hasattr(value, "__getitem__")
            and (not size or len(value) == int(size.group(1)))
            and (bool(UNCHECKED.search(annotation)) or all(_fits(annotation, entry) for entry in value))
        )
    elif _is_array(annotation):
        try:
            fits = np.asarray(value).dtype.kind in "fiu"
        except ValueError:
            fits = False
    else:
        fits = _fits(annotation, value)
    return "" if fits else _rule_of(annotation)


def _is_array(annotation: str) -> bool:
    return "ArrayLike" in annotation or "NDArray" in annotation


def _core_classes(annotation: str) -> list[str]:
    return sorted(set(re.findall(r"cogging\._core\.(?:effects\.)?(\w+)", annotation)))


def _fits(annotation: str, value: Any) -> bool:
    """Return whether one value, or one entry of a list, has the type of an annotation."""
    if classes := _core_classes(annotation):
        return any(one.__name__ in classes for one in type(value).__mro__)
    if WHOLE.search(annotation):
        return isinstance(value, int | np.integer) and not isinstance(value, bool)
    if NUMBER.search(annotation) or "Sequence[" in annotation:
        return isinstance(value, int | float | np.number) and not isinstance(value, bool)
    return isinstance(value, {"str": str, "bool": bool, "bytes": bytes}.get(annotation, object))


def _rule_of(annotation: str) -> str:
    """Return the type that an annotation asks for, in words."""
    several = "Sequence[" in annotation
    if classes := _core_classes(annotation):
        names = "an effect" if len(classes) > MOST_LISTED else " or ".join(map(_with_article, classes))
        return f"a list, each {names}" if several else names
    if _is_array(annotation):
        return ARRAY
    if UNCHECKED.search(annotation):
        return "a list"
    if several:
        size = FIXED_SIZE.search(annotation)
        whole = "whole " if WHOLE.search(annotation) else ""
        return f"{size.group(1) if size else 'a list of'} {whole}numbers"
    for words, rule in ((WHOLE, "a whole number"), (NUMBER, "a number"), (TEXT, "a text")):
        if words.search(annotation):
            return rule
    return {"bool": "True or False"}.get(annotation, annotation)
