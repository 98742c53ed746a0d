"""Calls, files and names that no careful user would give, drawn by a seeded generator.

`draw(kind, seed)` is one call of the command with the files that stand around it; kinds are those of KINDS. A file is
a valid one with something made wrong by a grammar: values, types, keys, sections, lengths, signals, names.
"""

from __future__ import annotations

import os
import random
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cogging.files import parse_toml, to_toml
from cogging.model import CONTROLLERS

MODEL = """
[axis]
mass = 0.12
viscous = 0.166
coulomb = 0.15
coulomb_width = 1.11e-3
travel = [0.0, 0.51]
[axis.uncertainty]
mass = 0.03
viscous = 0.2
[cogging]
pitch = 0.05
harmonics = [1, 2]
order = 3
origin = 0.0
sine = [[0.01, 0.02, 0.03, 0.04], [0.1, 0.2, 0.3, 0.4]]
cosine = [[0.0, 0.0, 0.0, 0.0], [0.4, 0.3, 0.2, 0.1]]
[encoder]
resolution = 0.5e-6
noise = 0.0
[noise]
force = 0.005
bandwidth = 50.0
[controller]
type = "pid"
sample_rate = 1000
kp = 2000.0
ki = 2.0e4
kd = 20.0
mass = 0.12
viscous = 0.166
coulomb = 0.15
feedforward_velocity = "reference"
command_limit = 0.0
[bounds]
"axis.mass" = [0.118, 0.122]
"axis.viscous" = [0.1, 0.2]
"axis.coulomb" = [0.1, 0.2]
"""
REFERENCES = (
    'type = "point_to_point"\nstart = 0.1\ndistance = 0.05\nvelocity = 0.3\nacceleration = 5.0\njerk = 500.0\n'
    "dwell = 0.05\nrepeats = 2\nduration = 0.6\n",
    'type = "sine"\ncenter = 0.2\namplitude = 0.05\nfrequency = 2.0\nduration = 0.5\n',
    'type = "filtered_sine"\nduration = 0.5\n',
    'type = "sampled"\ntime = [0.0, 0.1, 0.2, 0.3]\nreference = [0.1, 0.11, 0.12, 0.12]\n',
    'type = "sampled"\nfile = "log.csv"\n',
)
EFFECTS = (
    {"name": "cable_spring", "stiffness": 0.4, "center": 0.2},
    {"name": "position_dependent_friction", "nodes": [0.0, 0.2, 0.5], "levels": [0.0, 0.01, 0.02]},
    {"name": "stribeck_friction", "static_excess": 0.06, "velocity": 0.01, "exponent": 1.0},
    {"name": "cogging_modulation", "period": 0.05, "sine": [0.01, 0.02], "cosine": [0.01, 0.02]},
    {"name": "disturbance_step", "force": 0.1, "start": 0.1, "stop": 0.2},
    {"name": "flexible_mode", "frequency": 80.0, "damping_ratio": 0.02, "mass_ratio": 0.3},
    {"name": "command_delay", "delay": 0.001},
)

NUMBERS = (
    *("9223372036854775808", "-9223372036854775809", "18446744073709551616", "2147483648", "-2147483649", "4294967296"),
    *("1" + "0" * 309, "1" + "0" * 5000, "-1" + "0" * 5000, "0x" + "f" * 40),
    *("1e309", "-1e309", "1.7e308", "1e300", "-1e300", "1e155", "1e-155", "1e-300", "1e-320", "5e-324", "1e-400"),
    *("0", "0.0", "-0.0", "-1", "-1.0", "nan", "-nan", "inf", "-inf", "1", "3", "1e18", "1e9", "1e-9", "1e-17", "0.5"),
)
TEXTS = (
    '"text"',
    '""',
    '"\\u0000"',
    '"\\u001b[31mred"',
    '"\\u202e\\u009b2J"',
    '"naïve\\nline"',
    '"' + "x" * 70000 + '"',
)
COMPOSED = (
    *("true", "[]", "[[]]", "[1, 2]", "[1.0, [2.0]]", "{}", "{ a = 1 }", '["pid"]', "[{}]", "[nan]", "[inf, -inf]"),
    *("1979-05-27T07:32:00Z", "07:32:00", "1979-05-27", "[" * 90 + "]" * 90, "[" * 6000 + "]" * 6000),
    *(
        "{ a = " * 6000 + "1" + " }" * 6000,
        "[" + "1.0, " * 3000 + "1.0]",
        "[[1.0, 2.0], [3.0]]",
        "[9223372036854775808]",
    ),
)
KEYS = ("unknown", "", "\x1b[2J", "a b", "é", "\x00", "mass", "name", "x" * 70000, "a.b", "\u202e", "\n", "axis")
NAMES = (
    *("", ".", "..", "missing/a", "a\nb", "\x1b[31mred", "a\x00b", "x" * 300, "é", "😀", "\u202egnp.exe", "a\tb"),
    *("$x$", "$\\frac", "a%sb", "{x}", "<b>&", "-", "C:\\x", "a b", "a\r", "\x9b2J", "\x07"),
    *(os.fsdecode(b"\xff\xfe"), os.fsdecode(b"caf\xe9"), "\ud800", "folder", "folder/"),
)
ARGUMENTS = (
    *NUMBERS, "", " ", "text", "0:0", "1:", ":", "-5:5", "5:2", "::", "0:99999999999999999999", "99999999999999999999:",
    "a=b", "=", "position=", "=1", "position=command", "position=time,command=time", "position=nan", "position=1e309",
    "position=1e-320", "position=1e308", "command=inf", "command=-1", "time=1e300", "time=1e-300", "nonsense=2",
    "position=\x1b[31mred", "\x1b[31m=1", "axis.mass", "axis.mass,axis.mass", "axis.", ",", "axis.mass=1",
    "noise.force",    "bounds", "1_000", "٣", "0x10", "1e3", "--", "é", "\x00", *NAMES,
)  # fmt: skip
KINDS = ("option", "model", "reference", "sidecar", "signal", "header", "name", "document")


@dataclass(frozen=True)
class Call:
    """A call of the command, and the files by name that stand where it is made."""

    arguments: list[str]
    files: dict[str, bytes]
    about: str = ""
    outputs: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        return f"{self.about}: cogging {' '.join(map(ascii, self.arguments))}"[:400]


def table(columns: dict[str, np.ndarray[Any, Any]]) -> bytes:
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return (",".join(columns) + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows)).encode(
        "utf-8", "replace"
    )


def motion(rows: int = 1400) -> dict[str, np.ndarray[Any, Any]]:
    """A log of an axis of MODEL that moves to and fro, nearly what the model says."""
    time = np.arange(rows) * 1e-3
    position = 0.2 + 0.05 * np.sin(9.0 * time) + 0.02 * np.sin(23.0 * time)
    velocity, acceleration = np.gradient(position, 1e-3), np.gradient(np.gradient(position, 1e-3), 1e-3)
    noise = np.random.default_rng(0).normal(0.0, 0.01, rows)
    command = 0.12 * acceleration + 0.166 * velocity + 0.15 * np.tanh(velocity / 1e-3) + noise
    return {"time": time, "position": np.round(position / 5e-7) * 5e-7, "command": command, "reference": position}


def scan(points: int = 300) -> dict[str, np.ndarray[Any, Any]]:
    x = np.arange(points) * 1e-3
    noise = np.random.default_rng(1).normal(0.0, 0.002, points)
    return {"position": x, "force": 0.3 * np.sin(2.0 * np.pi * x / 0.05) + 0.1 + noise}


LOG, SCAN = table(motion()), table(scan())


def files(**changed: bytes) -> dict[str, bytes]:
    """The valid files, some of them changed; `log_csv` stands for log.csv."""
    valid = {"model.toml": MODEL.encode(), "ref.toml": REFERENCES[0].encode(), "log.csv": LOG, "scan.csv": SCAN}
    return valid | {name.replace("_", "."): content for name, content in changed.items()}


def draw(kind: str, seed: int) -> Call:
    """One hostile call."""
    return globals()[f"_{kind}"](random.Random(f"{kind} {seed}"))


# --- documents --------------------------------------------------------------------------------------------------------


def _value(chance: random.Random) -> str:
    return chance.choice(chance.choices((NUMBERS, TEXTS, COMPOSED), (6, 1, 3))[0])


def _places(document: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every path in a document, sections and entries of lists included."""
    entries = (
        document.items() if isinstance(document, dict) else enumerate(document) if isinstance(document, list) else ()
    )
    return [place for key, value in entries for place in ((*path, key), *_places(value, (*path, key)))]


def _at(document: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        document = document[key]
    return document


def mutated(text: str, chance: random.Random, times: int) -> tuple[str, str]:
    """A TOML text with something wrong in it, and what."""
    document, raw, told = parse_toml(text), [], []

    def hostile() -> str:
        raw.append(_value(chance))
        return f"@@{len(raw) - 1}@@"

    for _ in range(times):
        places = _places(document)
        if not places:
            break
        *above, key = chance.choice(places)
        parent = _at(document, tuple(above))
        deed = chance.choices(("replace", "delete", "add", "repeat", "empty"), (12, 2, 2, 1, 1))[0]
        told.append(f"{deed} {'.'.join(map(str, (*above, key)))}"[:80])
        if deed == "replace":
            parent[key] = hostile()
        elif deed == "delete":
            del parent[key]
        elif deed == "empty":
            parent[key] = type(parent[key])()
        elif isinstance(parent, dict):
            parent[chance.choice(KEYS) if deed == "add" else f"{key}_"] = hostile()
        else:
            parent.extend([hostile()] if deed == "add" else parent[:1])
    made = to_toml(document)
    for i, value in enumerate(raw):
        made = made.replace(f'"@@{i}@@"', value)
        told.append(value[:30])
    return made, ", ".join(told)


def _spoiled(text: str, chance: random.Random) -> tuple[bytes, str]:
    """A file that is no TOML of the kind, in ways that no single value makes."""
    line = chance.choice(text.splitlines()) + "\n"
    section = "[axis]\nmass = 1.0\n" if "[axis]" in text else "type = 'sine'\n"
    ways = {
        "line twice": text.encode() + line.encode(),
        "section twice": text.encode() + section.encode(),
        "cut": text.encode()[: chance.randrange(len(text))],
        "empty": b"",
        "a mark before": b"\xef\xbb\xbf" + text.encode(),
        "UTF-16": text.encode("utf-16"),
        "no UTF-8": text.encode() + b"# \xff\xfe\n",
        "zeros": text.encode() + b"\0\0",
        "escape codes": text.encode() + b"\x1b[2J = 1\n",
        "quoted escape codes": text.encode() + b'"\\u001b[2J" = "\\u001b[2J"\n',
        "CR": text.replace("\n", "\r").encode(),
        "nested": text.encode() + b"a = " + b"[" * 30000 + b"]" * 30000,
        "dotted": text.encode() + b"a" + b".a" * 20000 + b" = 1\n",
        "dotted section": text.encode() + b"[a" + b".a" * 20000 + b"]\n",
        "binary": chance.randbytes(200),
        "digits": text.encode() + b"a = " + b"9" * 20000 + b"\n",
        "directory": None,
    }
    way = chance.choice(list(ways))
    return ways[way], way


def _model_text(chance: random.Random) -> str:
    document = parse_toml(MODEL)
    document["effects"] = chance.sample(EFFECTS, chance.randrange(3))
    if chance.random() < 0.5:
        kind = chance.choice(list(CONTROLLERS))
        document["controller"] = {"type": kind, **CONTROLLERS[kind][0]().to_dict(), "sample_rate": 1000}
    return to_toml(document)


def _with_model(chance: random.Random) -> list[str]:
    simulate = ["simulate", "model.toml", "--reference", "ref.toml", "--out", "out.csv"]
    audit = ["audit", "log.csv", "--model", "model.toml", "--json", "out.json"]
    predict = ["predict", "model.toml", "--reference", "ref.toml", "--samples", "2", "--json", "out.json"]
    identify = ["identify", "log.csv", "--model", "model.toml", "--json", "out.json", "--out", "out.toml"]
    diagnose = ["diagnose", "log.csv", "--model", "model.toml", "--json", "out.json", "--out", "out.toml"]
    return chance.choices((simulate, audit, predict, identify, diagnose), (12, 5, 3, 1, 1))[0]


def _model(chance: random.Random) -> Call:
    text, told = mutated(_model_text(chance), chance, chance.choice((1, 1, 1, 2, 3)))
    return Call(_with_model(chance), files(model_toml=text.encode("utf-8", "surrogatepass")), told)


def _reference(chance: random.Random) -> Call:
    text, told = mutated(chance.choice(REFERENCES), chance, chance.choice((1, 1, 2)))
    command = ["simulate", "model.toml", "--reference", "ref.toml", "--out", "out.csv"]
    if chance.random() < 0.2:
        command = ["predict", "model.toml", "--reference", "ref.toml", "--samples", "2", "--json", "out.json"]
    return Call(command, files(ref_toml=text.encode()), told)


def _sidecar(chance: random.Random) -> Call:
    valid = to_toml({"version": "0.1.0", "seed": 3, "steps_per_sample": 1, "model": parse_toml(MODEL)})
    content: bytes
    if chance.random() < 0.5:
        text, told = mutated(valid, chance, 2)
        content = text.encode()
    else:
        content, told = _spoiled(valid, chance)
    return Call(["audit", "log.csv", "--json", "out.json"], files() | {"log.csv.toml": content}, told)


def _document(chance: random.Random) -> Call:
    name = chance.choice(("model.toml", "ref.toml"))
    text = MODEL if name == "model.toml" else chance.choice(REFERENCES)
    content, told = _spoiled(text, chance)
    command = ["simulate", "model.toml", "--reference", "ref.toml", "--out", "out.csv"]
    return Call(command, files() | {name: content}, f"{name} {told}")


# --- options ----------------------------------------------------------------------------------------------------------

LOG_OPTIONS = ("--columns", "--scale", "--rows")
OPTIONS: dict[str, tuple[list[str], tuple[str, ...]]] = {
    "reproduce": (["reproduce", "lu2008", "--out", "out"], ("PAPER", "--out", "--compare")),
    "simulate": (
        ["simulate", "model.toml", "--reference", "ref.toml", "--out", "out.csv", "--seed", "1"],
        ("--seed", "--out", "--reference", "--unknown"),
    ),
    "predict": (
        ["predict", "model.toml", "--reference", "ref.toml", "--samples", "2", "--seed", "1", "--json", "out.json"],
        ("--samples", "--seed", "--json", "--reference"),
    ),
    "map": (
        ["map", "scan.csv", "--pitch", "0.05", "--out", "out.toml", "--force-sign", "1"],
        ("--pitch", "--force-sign", "--out", *LOG_OPTIONS),
    ),
    "identify": (
        ["identify", "log.csv", "--model", "model.toml", "--json", "out.json", "--cutoff", "20", "--free", "axis.mass"],
        ("--free", "--cutoff", "--model", *LOG_OPTIONS),
    ),
    "diagnose": (
        ["diagnose", "log.csv", "--model", "model.toml", "--json", "out.json"],
        ("--model", "--confirm", *LOG_OPTIONS),
    ),
    "audit": (["audit", "log.csv", "--model", "model.toml", "--json", "out.json"], ("--model", "--json", *LOG_OPTIONS)),
    "schema": (["schema"], ("EXTRA",)),
}


def _option(chance: random.Random) -> Call:
    command = chance.choices(list(OPTIONS), (2, 4, 3, 6, 4, 2, 5, 1))[0]
    valid, options = OPTIONS[command]
    option, value = chance.choice(options), chance.choice(ARGUMENTS)
    arguments = list(valid)
    if option in arguments:
        arguments[arguments.index(option) + 1] = value
    else:
        arguments += [option, value] if option.startswith("--") else [value]
    if option == "--reference" and value not in NAMES:
        arguments = [*valid, chance.choice(("--seeds", "--s", "\x1b[31m", value)), value]
    return Call(arguments, files(), f"{command} {option}")


# --- signals ----------------------------------------------------------------------------------------------------------


def _shape(chance: random.Random, rows: int, valid: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], str]:
    way = chance.choice(("scaled", "scaled", "constant", "alternating", "spike", "offset", "noise", "ramp"))
    size = chance.choice(
        (1e300, 1e308, 1.7e308, 1e200, 1e154, 1e100, 1e30, 1e9, 1e-9, 1e-30, 1e-154, 1e-300, 1e-320, 0.0)
    )
    made = np.array(valid, dtype=float)
    with np.errstate(all="ignore"):
        if way == "scaled":
            made = made * size
        elif way == "constant":
            made = np.full(rows, size)
        elif way == "alternating":
            made = size * (-1.0) ** np.arange(rows)
        elif way == "spike":
            made[rows // 2] = size
        elif way == "offset":
            made = made + size
        elif way == "noise":
            made = size * np.random.default_rng(chance.randrange(1 << 30)).uniform(-1.0, 1.0, rows)
        else:
            made = size * np.arange(rows) / rows
    return np.nan_to_num(made, nan=0.0), f"{way} {size:g}"


def _signal(chance: random.Random) -> Call:
    mapping = chance.random() < 0.35
    columns = scan() if mapping else motion(chance.choice((3, 40, 600, 1400)))
    names = [name for name in columns if name != "reference" or chance.random() < 0.5]
    told = []
    for name in chance.sample(names, chance.choice((1, 1, 2))):
        rows = len(columns[name])
        if name == "time":
            step = chance.choice((1e300, 1e150, 1e9, 1.0, 1e-9, 1e-150, 1e-300, 1e-320))
            columns[name], what = step * np.arange(rows), f"step {step:g}"
        else:
            columns[name], what = _shape(chance, rows, columns[name])
        told.append(f"{name} {what}")
    columns = {name: columns[name] for name in names}
    if mapping:
        call = ["map", "scan.csv", "--pitch", "0.05", "--out", "out.toml"]
        return Call(call, files(scan_csv=table(columns)), f"scan {', '.join(told)}")
    diagnose = ["diagnose", "log.csv", "--model", "model.toml", "--json", "out.json", "--out", "out.toml"]
    identify = ["identify", "log.csv", "--model", "model.toml", "--json", "out.json", "--out", "out.toml"]
    audit = ["audit", "log.csv", "--json", "out.json", *chance.choice(([], ["--model", "model.toml"]))]
    model = parse_toml(MODEL)
    if chance.random() < 0.5:
        del model["controller"]
    if chance.random() < 0.5:
        del model["axis"]["travel"]  # which refuses most positions
    call = chance.choices((audit, identify, diagnose), (3, 3, 2))[0]
    return Call(call, files(log_csv=table(columns), model_toml=to_toml(model).encode()), ", ".join(told))


def _header(chance: random.Random) -> Call:
    """A log whose header says anything."""
    columns = motion(40)
    names = list(columns)
    word = chance.choice(
        (*KEYS, "\x1b]0;title\x07", "position [\x1b[31m]", "position", "time", '"', "\ud83d", "\u2028", "a\tb")
    )
    way = chance.choice(("add", "rename", "unit"))
    if way == "add":
        names.append(word)
    else:
        at = chance.randrange(3)
        names[at] = word if way == "rename" else f"{names[at]} [{word}]"
    body = "".join(
        ",".join(map(repr, row)) + ",1" * (len(names) - 4) + "\n" for row in zip(*columns.values(), strict=True)
    )
    body = body.replace("np.float64(", "").replace(")", "")
    content = (",".join(names) + "\n" + body).encode("utf-8", "surrogatepass")
    call = ["audit", "log.csv", "--json", "out.json"]
    call += chance.choice(([], ["--columns", f"command={word}"], ["--columns", f"position={word.strip()}"]))
    return Call(call, files(log_csv=content), f"{way} {word[:20]!r}")


def _name(chance: random.Random) -> Call:
    """A file of a hostile name, read or written."""
    word = chance.choice(NAMES)
    given = files()
    command = chance.choice(("simulate", "audit", "map", "identify", "model", "out", "map out", "mat", "json"))
    simulate = ["simulate", "model.toml", "--reference", "ref.toml", "--out", "out.csv"]
    if command in ("audit", "identify", "mat"):
        name = f"{word}.csv" if command != "mat" else f"{word}.mat"
        given[name] = LOG if command != "mat" else _matlab()
        call = ["audit", "--json", "out.json", "--", name]
        if command == "identify":
            call = ["identify", "--model", "model.toml", "--json", "out.json", "--free", "axis.mass", "--", name]
    elif command == "map":
        given[word] = SCAN
        call = ["map", "--pitch", "0.05", "--", word]
    elif command == "model":
        given[word] = MODEL.encode() + chance.choice((b"", b"[axes]\n"))
        call = ["simulate", "--reference", "ref.toml", "--out", "out.csv", "--", word]
    elif command == "map out":
        call = ["map", "scan.csv", "--pitch", "0.05", f"--out={word}{chance.choice(('', '.toml'))}"]
    elif command == "json":
        call = ["audit", "log.csv", f"--json={word}"]
    else:
        simulate[-2:] = [f"--out={word}{chance.choice(('', '.csv', '.mat', '.parquet'))}"]
        call = simulate
    return Call(call, given, f"name {command} {word[:20]!r}")


def _matlab() -> bytes:
    import io

    from scipy.io import savemat

    file = io.BytesIO()
    savemat(file, motion(40), oned_as="column")
    return file.getvalue()
