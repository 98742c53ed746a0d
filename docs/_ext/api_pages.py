"""The pages of the Python face: every public name once, by the room that it comes from."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from pathlib import Path
from typing import Any

import cogging
from cogging import datasets
from cogging._core import controllers, references

#: Headings by the room that a name comes from; a room that is not here is headed by its name.
ROOMS = {
    "simulation": "Simulate",
    "plant": "Plant and cogging map",
    "controllers": "Controllers",
    "references": "Motions",
    "model": "Models",
    "logs": "Logs",
    "log_check": "Check a log",
    "mapping": "Map a motor",
    "friction": "Friction",
    "identification": "Identify",
    "diagnosis": "Diagnose",
    "design": "Design, tune, and plan the next experiment",
    "papers": "Papers",
    "effects": "Effects",
    "plot": "Pictures",
    "export": "Out to the machine",
    "first_model": "A first model from a log",
    "files": "Files and errors",
    "cpp_library": "The core from C++",
}
#: Public names of the core by the folder of the core that they are of.
CORE = {
    "closed_loop": "simulation",
    "performance": "simulation",
    "Performance": "simulation",
    "replay_controller": "log_check",
    "project": "controllers",
    "CompiledController": "controllers",
    "Reference": "references",
    "ControllerError": "files",
    "DivergedError": "files",
    "CONTROLLERS": "controllers",
    "REFERENCES": "references",
    "EFFECTS": "effects",
    "desired_compensation_condition": "design",
    "desired_compensation_matrix": "design",
}


def rooms() -> dict[str, list[str]]:
    """Return public names by room, in the order of the headings."""
    found: dict[str, list[str]] = {room: [] for room in ROOMS}
    of_core = dict.fromkeys(controllers.__all__, "controllers") | dict.fromkeys(references.__all__, "references") | CORE
    for name in sorted(cogging.__all__, key=lambda name: (not name[0].islower(), name.lower())):
        value = getattr(cogging, name)
        room = (value.__name__ if inspect.ismodule(value) else getattr(value, "__module__", "")).split(".")[1:2]
        place = of_core.get(name) or {"_core": "plant", "file_schema": "files", "values": "files"}.get(*room, *room)
        found.setdefault(place, []).append(name)
    return {room: names for room, names in found.items() if names}


def write_api(folder: Path) -> None:
    """Write a page for each room, and that of the data sets."""
    folder.mkdir(parents=True, exist_ok=True)
    pages = {}
    for room, names in rooms().items():
        heading = ROOMS.get(room, room.replace("_", " ").capitalize())
        pages[room] = "\n\n".join([f"# {heading}", *map(entry, names)]) + "\n"
    pages["datasets"] = "# Data sets\n\n```{eval-rst}\n.. automodule:: cogging.datasets\n```\n" + _loaders()
    for old in folder.glob("*.md"):
        if old.stem not in pages:
            old.unlink()
    for name, text in pages.items():
        put(folder / f"{name}.md", text)


def put(path: Path, text: str) -> None:
    """Write a text if it has changed; Sphinx reads only changed files again."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def entry(name: str) -> str:
    """Return the entry of a name: its heading and its documentation."""
    value = getattr(cogging, name)
    if isinstance(value, dict):
        listed = "\n".join(f"- `{key}`: `{kind.__name__}`" for key, kind in value.items())
        return f"## `{name}`\n\nEvery name of a model or reference file, and its class:\n\n{listed}"
    if inspect.ismodule(value):
        own = []
        for word, thing in sorted(vars(value).items()):  # effects have their pages in the catalogue
            module = getattr(thing, "__module__", None) or ""
            if word[0] != "_" and callable(thing) and module.startswith(value.__name__):
                own.append(word)
        listed = "\n".join(_documented(f"{value.__name__}.{word}", getattr(value, word)) for word in own)
        return f"## `{value.__name__}`\n\n```{{eval-rst}}\n.. automodule:: {value.__name__}\n\n{listed}```"
    return f"## `{name}`\n\n```{{eval-rst}}\n{_documented(f'cogging.{name}', value)}```"


def _documented(place: str, value: Any) -> str:
    """Return the directive for a function, an error, or a class with its members."""
    if not inspect.isclass(value):
        return f".. autofunction:: {place}\n"
    if issubclass(value, BaseException):
        return f".. autoexception:: {place}\n"
    return f".. autoclass:: {place}\n   :members:\n   :inherited-members: object{_without_attributes(value)}\n"


def _without_attributes(*classes: Any) -> str:
    """Return the option that leaves out fields that the docstrings of classes list."""
    fields = set()
    for one in classes:
        section = re.search(r"^Attributes:\n((?: {4}.*\n?|\n)+)", inspect.getdoc(one) or "", re.MULTILINE)
        for line in re.findall(r"^ {4}(\w[\w, ]*?)(?: \(.*?\))?:", section[1] if section else "", re.MULTILINE):
            fields |= {name.strip() for name in line.split(",")}
    return f"\n   :exclude-members: {', '.join(sorted(fields))}" if fields else ""


def _loaders() -> str:
    """Return the entries of the data sets, each with its loader."""
    made = ""
    for name in (one.name for one in pkgutil.iter_modules(datasets.__path__) if one.name != "source"):
        module = importlib.import_module(f"cogging.datasets.{name}")
        own = [one for one in vars(module).values() if inspect.isclass(one) and one.__module__ == module.__name__]
        members = f":members:{_without_attributes(*own)}"
        made += f"\n## `{name}`\n\n```{{eval-rst}}\n.. automodule:: {module.__name__}\n   {members}\n```\n"
    return made


def escaped(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Escape the formulas of a docstring, whose characters are mark-up."""
    inside = False
    for number, line in enumerate(lines):
        inside = inside or line.strip().startswith(">>>")
        if inside:
            inside = bool(line.strip())
            continue
        lines[number] = "".join(
            part if part.startswith("`") else re.sub(r"([|*\\])", r"\\\1", re.sub(r"(\w)_(?!\w)", r"\1\\_", part))
            for part in re.split(r"(``[^`]*``|`[^`]*`)", line)
        )
