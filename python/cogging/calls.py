"""Calls that cannot be meant: which argument is wrong, in one line, and what was probably meant."""

from __future__ import annotations

import functools
import inspect
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeVar

import numpy as np

from cogging.arrays import no_number_in
from cogging.shown import nearest_name, quoted

F = TypeVar("F", bound=Callable[..., Any])
C = TypeVar("C")
MANY = 12  # names that are listed where none is alike
PATH: tuple[type, ...] = (str, os.PathLike)
ARRAY = "an array of real numbers"
ANYTHING = re.compile(r"\[(object|typing\.Any)\]")  # a list whose entries the core looks at itself: controllers


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The end of a sentence about a word that is not known: the nearest one, or those that there are."""
    names = [str(name) for name in known]
    near = nearest_name(str(word), names)
    if near is not None:
        return f"did you mean {near}?"
    listed = names if len(names) <= MANY else [*names[:MANY], "..."]
    return f"known: {', '.join(listed) or 'none'}"


@dataclass(frozen=True)
class Kind:
    """What an argument of a public function may be.

    Attributes:
        types: that it may have.
        called: the same in words.
        several: whether a list of them will do.
        hints: by name of a type that users give in its place, what to do.
    """

    types: tuple[type, ...]
    called: str
    several: bool = False
    hints: Mapping[str, str] = field(default_factory=dict)

    def problem(self, value: Any) -> str:
        """What is wrong with a value, or nothing."""
        if isinstance(value, self.types):
            return ""
        if self.several and isinstance(value, list | tuple):
            wrong = next((entry for entry in value if not isinstance(entry, self.types)), None)
            if wrong is None:
                return ""
            value = wrong
        hint = self.hints.get(type(value).__name__, "")
        return f"must be {self.called}, got {described(value)}{': ' * bool(hint)}{hint}"


#: Functions that read one file.
PATHS = Kind(PATH, "the path of a file")


def takes(**kinds: Kind) -> Callable[[F], F]:
    """Refuse a call with a mistyped keyword or an argument of another kind in one line, before anything runs.

    Raises:
        TypeError: when the function is called so.
    """

    def of(function: F) -> F:
        names = [p.name for p in inspect.signature(function).parameters.values()]
        open_ended = any(p.kind is p.VAR_KEYWORD for p in inspect.signature(function).parameters.values())
        name = function.__qualname__.removesuffix(".__init__")

        @functools.wraps(function)
        def asked(*given: Any, **named: Any) -> Any:
            for word in named:
                if word not in names and not open_ended:
                    own = [known for known in names if known != "self"]
                    raise TypeError(f"{name}: {word}: is no argument of it; {did_you_mean(word, own)}")
            for word, value in [*zip(names, given, strict=False), *named.items()]:
                problem = kinds[word].problem(value) if word in kinds else ""
                if problem:
                    raise TypeError(f"{name}: {word}: {problem}")
            return function(*given, **named)

        return asked  # type: ignore[return-value]

    return of


def told_constructor(kind: type[C]) -> type[C]:
    """Refuse a mistyped keyword of a constructor in one line (a decorator of classes).

    Raises:
        TypeError: when the class is called so.
    """
    setattr(kind, "__init__", takes()(kind.__init__))  # noqa: B010 - mypy does not let a method be assigned
    return kind


def described(value: Any) -> str:
    """A value of the wrong kind, as short as may be."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if value is None or isinstance(value, bool | np.bool_ | int | float | str):
        return quoted(bool(value) if isinstance(value, np.bool_) else value)
    kind = value.__name__ if isinstance(value, type) else type(value).__name__
    if isinstance(value, type):
        return f"the class {kind} itself"
    if isinstance(value, dict | list | tuple) and len(value) <= 4:
        return f"a {kind}: {quoted(value)}"
    return f"{'an' if kind[0] in 'AEIOU' else 'a'} {kind}"


class Parameter(NamedTuple):
    """One parameter of a signature of the core."""

    name: str
    annotation: str
    needed: bool
    by_name: bool  # only


def told(doc: str, given: Sequence[Any], named: Mapping[str, Any]) -> str:
    """What is wrong with a call of a function of the core that its signature does not take.

    Args:
        doc: of the function, which begins with the signature.
        given: arguments by position; the first of a constructor is the object itself.
        named: arguments by keyword.

    Returns:
        One line: function, argument, rule, value.
    """
    name, parameters, given = _called(doc, given)
    places = [parameter for parameter in parameters if not parameter.by_name]
    if len(given) > len(places):
        words = ", ".join(f"{parameter.name}=..." for parameter in parameters[:3])
        if not places:
            return f"{name}: must be given its arguments by keyword ({words}), got {described(given[0])} without one"
        return f"{name}: must be given {len(places)} arguments by position, got {len(given)}; the rest by keyword"
    known = {parameter.name: parameter for parameter in parameters}
    for word in named:
        if word not in known:
            return f"{name}: {word}: is no argument of it; {did_you_mean(word, known)}"
    values = {place.name: value for place, value in zip(places, given, strict=False)} | dict(named)
    return f"{name}: {_wrong_argument(known, values)}"


def _called(doc: str, given: Sequence[Any]) -> tuple[str, Sequence[Parameter], Sequence[Any]]:
    """Name and parameters of a function, and what it was given; of a constructor the class, without the object."""
    name, parameters = signature(doc)
    if parameters and parameters[0].name == "self":
        return parameters[0].annotation.split(".")[-1], parameters[1:], given[1:]
    return name, parameters, given


def told_of_no_number(doc: str, given: Sequence[Any], named: Mapping[str, Any]) -> str | None:
    """What is wrong with a call of the core where a number is due and a truth value or a text stands; None: nothing.

    Args and the line are those of `told`.
    """
    name, parameters, given = _called(doc, given)
    places = [parameter for parameter in parameters if not parameter.by_name]
    known = {parameter.name: parameter for parameter in parameters}
    for word, value in {**{p.name: v for p, v in zip(places, given, strict=False)}, **named}.items():
        annotation = known[word].annotation if word in known else ""
        array = "ArrayLike" in annotation or "NDArray" in annotation
        if not array and ("Supports" not in annotation or "str" in annotation):
            continue
        alone = not array and "Sequence[" not in annotation
        found = [value] * isinstance(value, bool | np.bool_) if alone else no_number_in(value)
        if found:
            rule = ARRAY if array else _in_words(annotation, [])
            among = "" if found[0] is value else " among them"
            return f"{name}: {word}: must be {rule}, got {described(found[0])}{among}"
    return None


def _wrong_argument(known: Mapping[str, Parameter], values: Mapping[str, Any]) -> str:
    """What is wrong with the arguments of a call whose names are known."""
    for word, value in values.items():
        rule = broken_rule(known[word].annotation, value)
        if rule:
            return f"{word}: must be {rule}, got {described(value)}"
    for parameter in known.values():
        if parameter.needed and parameter.name not in values:
            return f"{parameter.name}: must be given, got nothing"
    return f"these arguments do not go together: {', '.join(values) or 'none'}"


@functools.cache
def signature(doc: str) -> tuple[str, tuple[Parameter, ...]]:
    """The name of a function of the core and its parameters, as its docstring begins."""
    name, _, rest = doc.partition("(")
    depth, parts, start, at = 0, [], 0, 0
    quote = ""
    for at, letter in enumerate(rest):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter in "([{":
            depth += 1
        elif letter in ")]}":
            depth -= 1
            if depth < 0:
                break
        elif letter == "," and depth == 0:
            parts.append(rest[start:at].strip())
            start = at + 1
    parts.append(rest[start:at].strip())
    parameters, by_name = [], False
    for part in filter(None, parts):
        if part in ("*", "/"):
            by_name = by_name or part == "*"
            continue
        word, _, kind = part.partition(": ")
        kind, equals, _ = kind.partition(" = ")
        parameters.append(Parameter(word.lstrip("*"), kind, not equals, by_name))
    return name.strip(), tuple(parameters)


def broken_rule(annotation: str, value: Any) -> str:
    """What an argument of the core must be where a value is not that, or nothing."""
    kinds = sorted(set(re.findall(r"cogging\._core\.(?:effects\.)?(\w+)", annotation)))
    if value is None:
        return "" if "None" in annotation else _in_words(annotation, kinds)
    if "Sequence[" in annotation:
        return "" if _sequence_fits(annotation, kinds, value) else _in_words(annotation, kinds)
    if "ArrayLike" in annotation or "NDArray" in annotation:
        return "" if _numeric(value) else ARRAY
    return "" if _fits(annotation, kinds, value) else _in_words(annotation, kinds)


def _fits(annotation: str, kinds: Sequence[str], value: Any) -> bool:
    if kinds:
        return any(one.__name__ in kinds for one in type(value).__mro__)
    if "SupportsInt" in annotation:
        return isinstance(value, int | np.integer) and not isinstance(value, bool)
    if "SupportsFloat" in annotation:
        return isinstance(value, int | float | np.number) and not isinstance(value, bool)
    return isinstance(value, {"str": str, "bool": bool, "bytes": bytes}.get(annotation, object))


def _sequence_fits(annotation: str, kinds: Sequence[str], value: Any) -> bool:
    if isinstance(value, str | bytes | dict) or not hasattr(value, "__len__") or not hasattr(value, "__getitem__"):
        return False
    size = re.search(r"FixedSize\((\d+)\)", annotation)
    if size and len(value) != int(size.group(1)):
        return False
    if kinds:
        return all(any(one.__name__ in kinds for one in type(entry).__mro__) for entry in value)
    if ANYTHING.search(annotation):
        return True
    wanted = int | np.integer if "SupportsInt" in annotation else int | float | np.number
    return all(isinstance(entry, wanted) and not isinstance(entry, bool) for entry in value)


def _numeric(value: Any) -> bool:
    try:
        return np.asarray(value).dtype.kind in "fiu"
    except ValueError:
        return False


def _in_words(annotation: str, kinds: Sequence[str]) -> str:
    """The kind that a signature asks for."""
    several = "Sequence[" in annotation
    if kinds:
        named = [f"{'an' if kind[0] in 'AEIOU' else 'a'} {kind}" for kind in kinds]
        names = "an effect" if len(kinds) > MANY else " or ".join(named)
        return f"a list, each {names}" if several else names
    size = re.search(r"FixedSize\((\d+)\)", annotation)
    if ANYTHING.search(annotation):
        return "a list"
    if several:
        whole = "whole " if "SupportsInt" in annotation else ""
        return f"{size.group(1) if size else 'a list of'} {whole}numbers"
    for word, told_as in (("SupportsInt", "a whole number"), ("SupportsFloat", "a number"), ("str", "a text")):
        if word in annotation:
            return told_as
    return {"bool": "True or False"}.get(annotation, annotation)
