"""A law as the core writes it, in plain characters, set as a formula."""

from __future__ import annotations

import re
from collections.abc import Collection

TOKEN = re.compile(r"(?P<word>[A-Za-z_]\w*'*)|(?P<number>\d+(?:\.\d+)?)|(?P<op><=|>=|\S)")
FUNCTIONS = {"sin", "cos", "exp", "min", "max", "tan", "ln", "log"}
SPELLED = r"\mathsf{"  # what a name of several letters is set in
OPERATORS = {"<=": r"\le ", ">=": r"\ge ", "*": r"\,"}


def formula(law: str, fields: Collection[str]) -> str:
    """TeX of a law: its fields upright by their names, the rest as an engineer would write it.

    Args:
        law: as in `LAW` of an effect.
        fields: names that stand for themselves.
    """
    parts = [_part(part.strip(), fields) for part in _apart(law)]
    return parts[0] if len(parts) == 1 else r"\begin{gathered} " + r", \\ ".join(parts) + r" \end{gathered}"


def _apart(law: str) -> list[str]:
    """A law at the commas that stand in no bracket."""
    depth, parts = 0, [""]
    for letter in law:
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


def _part(law: str, fields: Collection[str]) -> str:
    made: list[str] = []
    words: list[str] = []  # neighbours that are prose, not mathematics

    def say() -> None:
        if words:
            made.append(r"\text{ " + " ".join(words) + " }")
            words.clear()

    tokens = list(TOKEN.finditer(law))
    raised = False
    for token in tokens:
        text = token.group()
        if token.lastgroup == "word" and _is_prose(text, fields):
            words.append(text)
            continue
        say()
        one = _symbol(token, fields)
        follows = token.lastgroup != "op" and bool(made) and (made[-1][-1].isalnum() or made[-1][-1] in ")}")
        beside = follows and SPELLED in one + made[-1]
        made.append("{" + one + "}" if raised else r"\," + one if beside else one)
        raised = text == "^"
    say()
    return " ".join(made)


def _is_prose(word: str, fields: Collection[str]) -> bool:
    plain = word.rstrip("'")
    known = plain in fields or plain in FUNCTIONS or plain in ("pi", "sgn", "reading", "forces", "level")
    return not known and len(re.sub(r"\d|_\w+$", "", plain)) > 1


def _symbol(token: re.Match[str], fields: Collection[str]) -> str:
    text = token.group()
    if token.lastgroup == "number":
        return text
    if token.lastgroup == "op":
        return OPERATORS.get(text, text)
    name, dots = text.rstrip("'"), len(text) - len(text.rstrip("'"))
    if name in FUNCTIONS:
        return "\\" + name
    if name == "pi":
        return r"\pi"
    if name == "sgn":
        return r"\operatorname{sgn}"
    if name in fields or len(re.sub(r"\d", "", name)) > 1:
        made = SPELLED + name.replace("_", r"\_") + "}"
    else:
        made = re.sub(r"^([A-Za-z])_?(\w+)$", r"\1_{\2}", name)
    return {0: made, 1: rf"\dot{{{made}}}", 2: rf"\ddot{{{made}}}"}.get(dots, made)
