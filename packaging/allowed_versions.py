"""An environment with the lowest, or the newest, versions that pyproject.toml allows, and cogging built with such ones.

python -m pip install uv
python packaging/allowed_versions.py lowest build/lowest --python 3.10
build/lowest/bin/python -m pytest -m 'not study and not data and not pages and not notebook'

Lowest are the versions of what the project itself names; what those need in turn is the newest that they allow, as pip
would bring it today. What the build asks for (scikit-build-core, pybind11, CMake, Ninja) is taken alike, in an
environment of its own. An extra may hold the lowest of another back: asammdf wants numpy 2, so that numpy's own lowest
version is seen `--without mdf`.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
#: How uv is to choose among the versions that are allowed.
CHOICES = {"lowest": ["--resolution", "lowest-direct"], "newest": ["--resolution", "highest"]}


def project() -> dict[str, Any]:
    """What stands in pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def requirements(extras: list[str], without: list[str]) -> list[str]:
    """What an installation with these extras asks for, those extras of other extras opened, but for some.

    Args:
        extras: names below `optional-dependencies`.
        without: of extras that are left out wherever they are asked for.
    """
    known = project()["project"]
    asked: list[str] = list(known["dependencies"])
    for extra in extras:
        for wanted in known["optional-dependencies"][extra]:
            inner = re.fullmatch(r"cogging\[(.+)\]", wanted)
            names = [name for name in inner[1].split(",") if name not in without] if inner else []
            asked += requirements(names, without) if inner else [wanted]
    return list(dict.fromkeys(asked))


def build_requirements() -> list[str]:
    """What the build asks for: of pip, and of scikit-build-core where the system has no such CMake or Ninja."""
    known = project()
    tools = known["tool"]["scikit-build"]
    return [*known["build-system"]["requires"], *(f"{name}{tools[name]['version']}" for name in ("cmake", "ninja"))]


def run(*command: str | Path, path: Path | None = None) -> None:
    """Run a command to its end, with a folder first on the PATH."""
    print("+", *command, flush=True)
    places = os.pathsep.join([*([str(path)] if path else []), os.environ["PATH"]])
    subprocess.run([str(word) for word in command], check=True, env={**os.environ, "PATH": places})


def python_of(environment: Path) -> Path:
    """The interpreter of an environment."""
    return environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def environment(place: Path, python: str, asked: list[str], how: list[str]) -> Path:
    """Make an environment with the chosen versions of what is asked for; gives its interpreter."""
    uv = [sys.executable, "-m", "uv"]
    run(*uv, "venv", "--quiet", "--clear", "--seed", "--python", python, place)
    wanted, chosen = place / "asked.txt", place / "chosen.txt"
    wanted.write_text("\n".join(asked) + "\n", encoding="utf-8")
    run(*uv, "pip", "compile", "--quiet", *how, "--python", python_of(place), wanted, "-o", chosen)
    run(*uv, "pip", "install", "--quiet", "--python", python_of(place), "-r", chosen)
    return python_of(place)


def main() -> int:
    """Make the environment and say which versions it holds."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("which", choices=CHOICES)
    parser.add_argument("place", type=Path, help="folder of the environment, made anew")
    parser.add_argument("--python", default=sys.executable, help="version or path (default: this one)")
    parser.add_argument("--extra", action="append", help="several times for several (default: test)")
    parser.add_argument("--without", action="append", default=[], help="an extra that is left out of others")
    parser.add_argument("--prereleases", action="store_true", help="those that are no releases yet as well")
    options = parser.parse_args()
    how = [*CHOICES[options.which], *(["--prerelease", "allow"] if options.prereleases else [])]
    place = options.place.resolve()
    with tempfile.TemporaryDirectory() as scratch:
        builder = environment(Path(scratch) / "build", options.python, build_requirements(), how)
        wheels = Path(scratch) / "wheels"
        run(
            *(builder, "-m", "pip", "wheel", "--quiet", "--no-build-isolation", "--no-deps", "-w", wheels, ROOT),
            path=builder.parent,
        )
        installed = environment(place, options.python, requirements(options.extra or ["test"], options.without), how)
        run(sys.executable, "-m", "uv", "pip", "install", "--quiet", "--python", installed, *wheels.glob("*.whl"))
        for python in (builder, installed):
            run(sys.executable, "-m", "uv", "pip", "list", "--python", python)
    return 0


if __name__ == "__main__":
    sys.exit(main())
