"""Whether an installed cogging is whole and works: run by the Python that has it, with nothing else installed.

python packaging/check_installed.py
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import io
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import cogging

MODEL = cogging.Model(
    axis=cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=0.0, travel=[0.0, 0.51]),
    cogging=cogging.CoggingModel(
        cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2]), sine=[[0.08], [0.04]], cosine=[[0.0], [0.02]]
    ),
    effects=[cogging.effects.CableSpring(stiffness=0.4), cogging.effects.CommandDelay(delay=3e-4)],
    encoder=cogging.EncoderParameters(resolution=0.5e-6),
    controller=cogging.PidParameters(kp=9600.0, ki=1e5, kd=48.0, mass=0.12, viscous=0.166),
    controller_type="pid",
)
MOVE = {"type": "point_to_point", "start": 0.05, "distance": 0.4, "velocity": 0.5, "acceleration": 10.0, "jerk": 1000.0}


def check_run() -> None:
    """The README's first lines: a run, twice the same."""
    log = cogging.simulate(MODEL, MOVE, seed=1)
    error = abs(log.error).max()
    assert len(log) > 1000, f"{len(log)} samples"
    assert 1e-7 < error < 1e-3, f"largest error {error} m"
    assert (cogging.repeat(log).position == log.position).all()


def check_command(folder: Path) -> None:
    """The command that pip installed, from a file to files."""
    beside = Path(sys.executable).parent
    command = shutil.which("cogging", path=os.pathsep.join(map(str, (beside, beside / "Scripts"))))
    assert command, f"no command cogging beside {sys.executable}"
    MODEL.write(folder / "model.toml")
    move = "\n".join(f"{name} = {value!r}" for name, value in MOVE.items()).replace("'", '"')
    (folder / "move.toml").write_text(move, encoding="utf-8")
    for words in (
        ["--version"],
        ["simulate", "model.toml", "--reference", "move.toml", "--out", "log.csv"],
        ["export", "model.toml", "--to", "cpp", "--out", "controller.hpp"],
    ):
        subprocess.run([command, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    assert (folder / "log.csv").stat().st_size > 10**5
    assert "class Controller" in (folder / "controller.hpp").read_text(encoding="utf-8")


def check_library() -> None:
    """Headers, CMake package and licence that the package carries."""
    assert (Path(cogging.get_include()) / "cogging" / "control" / "pid.hpp").is_file()
    assert (Path(cogging.get_cmake_dir()) / "coggingConfig.cmake").is_file()
    licence = importlib.metadata.distribution("cogging").read_text("licenses/LICENSE")
    assert "MIT" in (licence or ""), "no licence beside the package"


def check_unit(folder: Path) -> None:
    """A unit of FMI, its library loaded from it."""
    archive = zipfile.ZipFile(io.BytesIO(cogging.export.to(MODEL, "fmi").content))
    (name,) = (name for name in archive.namelist() if name.startswith("binaries/"))
    library = ctypes.CDLL(archive.extract(name, folder))
    library.fmi3GetVersion.restype = ctypes.c_char_p
    assert library.fmi3GetVersion() == b"3.0"


def main() -> int:
    """Run the checks; any that fails says so by its traceback."""
    package = Path(cogging.__file__).parent
    assert not (package.parents[1] / "pyproject.toml").exists(), (
        f"{package}: is a source tree, not an installed package"
    )
    check_run()
    check_library()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:  # a loaded library stays on Windows
        check_command(Path(folder))
        check_unit(Path(folder))
    print(f"cogging {cogging.__version__} in {package}: whole, and works")
    return 0


if __name__ == "__main__":
    sys.exit(main())
