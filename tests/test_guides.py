"""The code in the guides runs, and does what the guide says."""

import os
import re
import runpy
import shutil
import subprocess
from pathlib import Path

import cogging

ROOT = Path(__file__).parents[1]


def code(guide, language):
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / "docs" / guide).read_text(), flags=re.DOTALL)


def test_controllers_in_python_and_compiled(tmp_path, capsys):
    (tmp_path / "lines.py").write_text("\n".join(code("controllers.md", "python")))
    runpy.run_path(str(tmp_path / "lines.py"))  # asserts that both give the same commands
    assert 1.0 < float(re.search(r"largest error ([\d.]+) um", capsys.readouterr().out)[1]) < 100.0


def test_a_controller_in_cpp_can_stand_in_the_list(tmp_path):
    """The header of the guide as a file, and what the list asks of each of its lines, for one machine and for lanes."""
    compiler = shutil.which(os.environ.get("CXX", "g++")) or shutil.which("c++")
    header, line = code("controllers.md", "cpp")
    (tmp_path / "pd.hpp").write_text(header)
    assert line.startswith("using AnyController = std::variant<Pd<Scalar>, ")
    (tmp_path / "check.cpp").write_text(
        '#include "pd.hpp"\n#include "cogging/lanes.hpp"\n'
        "static_assert(cogging::ListedController<cogging::Pd<>, double>);\n"
        "static_assert(cogging::ListedController<cogging::Pd<cogging::Lanes<4>>, cogging::Lanes<4>>);\n"
        "template class cogging::Pd<double>;\ntemplate class cogging::Pd<cogging::Lanes<4>>;\n"
    )
    flags = ["-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", f"-I{ROOT / 'cpp'}"]
    built = subprocess.run([compiler, *flags, "check.cpp"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr[:2000]


def test_the_guide_to_pictures(tmp_path, monkeypatch):
    """Its lines run, and its table names every function."""
    monkeypatch.chdir(tmp_path)
    (lines,) = code("plot.md", "python")
    (tmp_path / "lines.py").write_text(lines)
    assert runpy.run_path(str(tmp_path / "lines.py"))["error"].get_ylabel() == "error (µm)"
    assert (tmp_path / "log.png").read_bytes().startswith(b"\x89PNG")
    listed = set(re.findall(r"^\| (.*?) \|", (ROOT / "docs" / "plot.md").read_text(), flags=re.MULTILINE))
    assert {name for names in listed for name in re.findall(r"`(\w+)`", names)} == set(cogging.plot.__all__)
