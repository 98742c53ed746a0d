"""Where a command writes: never onto what it reads, nothing twice, onto nothing but files, and whole or not at all."""

import contextlib
import errno
import functools
import itertools
import os
import shutil
import stat
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging import outputs
from cogging.files import InputError
from cogging.papers import result as papers
from tests.fixtures.covering import covering

POSIX = pytest.mark.skipif(os.name == "nt", reason="processes, modes and pipes of POSIX")
LOGS = ["log.csv", "log.csv.toml", "other.csv", "other.csv.toml", "model.toml"]
PLANNED = ["model.toml", "result.json", "limits.toml"]
SAMPLES = ["model.toml", "sampled.toml", "samples.csv"]
#: Every command that reads and writes: call, inputs (those beside them included), options that write.
COMMANDS = [
    ("identify log.csv other.csv --model model.toml", LOGS, ["--out", "--json"]),
    ("diagnose log.csv --model model.toml --confirm other.csv", LOGS, ["--out", "--json", "--report"]),
    ("experiment --model model.toml --result result.json --limits limits.toml", PLANNED, ["--out"]),
    ("audit log.csv other.csv --model model.toml", LOGS, ["--json"]),
    ("map scan.csv --pitch 0.05", ["scan.csv"], ["--out", "--json"]),
    ("predict model.toml --reference sampled.toml", SAMPLES, ["--json"]),
    ("simulate model.toml --reference sampled.toml", SAMPLES, ["--out"]),
    ("sweep sweep.toml", ["sweep.toml", "model.toml", "ref.toml"], ["--out", "--json"]),
    ("tune tune.toml", ["tune.toml", "model.toml", "ref.toml"], ["--out", "--json"]),
]
WRITES = [(call, option) for call, _, options in COMMANDS for option in options]
ONTO = [(call, file, option) for call, read, options in COMMANDS for file in read for option in options]
TWICE = [(call, *two) for call, _, options in COMMANDS for two in itertools.permutations(options, 2)]
SIMULATE = "simulate model.toml --reference ref.toml --out"


@pytest.fixture
def folder(folder):
    """The folder of tests/cli/conftest.py, with a sampled reference."""
    (folder / "sampled.toml").write_text('type = "sampled"\nfile = "samples.csv"\n')
    (folder / "samples.csv").write_text("time,reference\n0.0,0.1\n0.5,0.1\n")
    return folder


def content(folder):
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


#: Names of a file, some of which are made: a link to it, to its folder, and (for what is there) a hard link.
NAMES = [
    *(str, os.path.abspath, lambda name: os.path.join("..", "work", ".", name)),
    lambda name: Path("a link").symlink_to(name) or "a link",
    lambda name: Path("..", "again").symlink_to("work") or os.path.join("..", "again", name),
]


def by_hard_link(target):
    Path(target).touch()  # a sidecar that only may be there
    os.link(target, "a hard link")
    return "a hard link"


@pytest.mark.parametrize(("case", "name"), covering(ONTO, [*NAMES, by_hard_link]))
def test_no_output_is_an_input(case, name, refused):
    call, file, option = case
    refused([*call.split(), option, name(file)], option, file, "must not be a file that is read")


@pytest.mark.parametrize(("case", "name"), covering(TWICE, NAMES))
def test_no_file_is_written_twice(case, name, refused):
    call, one, other = case
    refused([*call.split(), one, "new", other, name("new")], "must be different files, got one twice")


def linked_in_a_circle(path):
    Path(path).symlink_to("circle")
    Path("circle").symlink_to(path)


#: What stands where an output is wanted; some return another path.
THERE = [getattr(os, "mkfifo", None), os.mkdir, linked_in_a_circle, lambda path: Path(path).symlink_to("/dev/null")]
THERE += [lambda path: "missing/out", lambda path: "model.toml/out"]


@POSIX
@pytest.mark.parametrize(("case", "make"), covering(WRITES, THERE))
def test_an_output_is_a_file(case, make, refused):
    call, option = case
    output = make("out") or "out"
    refused([*call.split(), option, output], output)


def test_a_sidecar_replaces_only_a_sidecar(folder):
    """The model `machine.toml` does not belong to the log `machine`."""
    shutil.copy("model.toml", "machine.toml")
    bare, log = cogging.read_log("log.csv"), cogging.simulate("model.toml", "ref.toml", seed=1)
    before = content(folder)
    for one in (log, bare):
        with pytest.raises(InputError, match=r"machine\.toml: must be what a log left here"):
            one.write("machine")
    assert content(folder) == before
    for one in (log, log, bare):
        one.write("copy.csv")
        assert Path("copy.csv.toml").exists() == (one is log)


@POSIX
def test_a_link_stays_and_its_target_is_replaced(tmp_path):
    real, link = tmp_path / "real.toml", tmp_path / "link.toml"
    link.symlink_to("real.toml")
    for text in ("first", "second"):  # a target that is not there yet, and one that is
        outputs.write_text(link, text)
        assert os.readlink(link) == "real.toml"
        assert real.read_text() == text
    assert sorted(tmp_path.iterdir()) == [link, real]


@POSIX
@pytest.mark.parametrize("mode", [0o600, 0o755])
def test_a_file_keeps_its_mode_and_a_new_one_gets_that_of_the_mask(mode, tmp_path):
    """The file beside it, which is renamed, has this mode from its beginning, and another name each time."""
    before, path, parts = os.umask(0o777 & ~mode), tmp_path / "a", set()
    try:
        outputs.write_text(path, "old")
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & mode
    path.chmod(mode)

    def pieces():
        (part,) = tmp_path.glob(".*.part")
        parts.add(part.name)
        assert stat.S_IMODE(part.stat().st_mode) == mode
        yield b"new"

    for _ in range(3):
        outputs.write_files({str(path): pieces()})
    assert (stat.S_IMODE(path.stat().st_mode), len(parts)) == (mode, 3)


def huge(path):
    with open(path, "wb") as file:
        file.truncate(1 << 40)


STRANGE = {
    "pipe": (getattr(os, "mkfifo", None), "must be a file, got a device or pipe"),
    "endless": (lambda path: path.symlink_to("/dev/zero"), "must be a file, got a device or pipe"),
    "folder": (os.mkdir, "must be a file, got a directory"),
    "huge": (huge, "must be at most 64 MiB of text, got 1099511627776 bytes"),
}
READ = [(f"{SIMULATE} new.csv", file) for file in ("model.toml", "ref.toml")]
READ += [("identify log.csv --model model.toml", file) for file in ("model.toml", "log.csv.toml")]
READ += [("audit other.csv", "other.csv")]


@POSIX
@pytest.mark.parametrize(("case", "what"), covering(range(len(READ)), STRANGE))
def test_what_is_read_is_a_file_with_an_end(case, what, folder, refused):
    call, file = READ[case]
    make, message = STRANGE[what]
    Path(file).unlink(missing_ok=True)
    make(folder / file)
    refused(call.split(), f"{file}: ", message)


# Files that belong together -------------------------------------------------------------------------------------------

OLD = {"a": b"old a", "b": b"old b", "gone": b"old too"}
NEW = {"a": b"new a", "b": b"new b", "c": b"new too"}


@POSIX
@pytest.mark.parametrize("error", [OSError(errno.EIO, os.strerror(errno.EIO)), KeyboardInterrupt()])
def test_a_failure_between_any_two_steps_leaves_whole_files(error, tmp_path, monkeypatch):
    for number in range(1, 60):
        folder, steps = tmp_path / f"{number}", itertools.count(1)
        folder.mkdir()
        for name, old in OLD.items():
            (folder / name).write_bytes(old)

        def failing(plain, *args, number=number, steps=steps, **options):
            if next(steps) == number:
                raise error
            return plain(*args, **options)

        with monkeypatch.context() as patch:
            for name in ("open", "replace", "unlink"):
                patch.setattr(os, name, functools.partial(failing, getattr(os, name)))
            with contextlib.suppress(InputError, KeyboardInterrupt):
                new = {str(folder / name): [pieces] for name, pieces in NEW.items()}
                outputs.write_files({**new, str(folder / "gone"): None})
        found = {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix != ".part"}
        for name in ("a", "b", "c", "gone"):
            assert found.get(name) in (OLD.get(name), NEW.get(name))
        if number <= 4:
            assert found == OLD, "nothing takes its place before all are written"
        if next(steps) <= number:
            break
    assert found == NEW
    assert number > 8


def log(seed):
    columns = {name: np.full(3, float(seed)) for name in ("position", "command")}
    return cogging.Log(time=np.arange(3.0), **columns, metadata={"seed": seed})


def test_a_log_beside_the_sidecar_of_another_is_refused(tmp_path):
    """As a writer leaves it that is killed between the two renames."""
    path, beside = tmp_path / "log.csv", tmp_path / "log.csv.toml"
    log(1).write(path)
    log(2).write(tmp_path / "other.csv")
    for old, new in ((path, tmp_path / "other.csv"), (beside, tmp_path / "other.csv.toml")):
        kept = old.read_bytes()
        shutil.copy(new, old)
        with pytest.raises(InputError, match=r"remove the line if that log was changed on purpose, got 'crc32:"):
            cogging.read_log(path)
        old.write_bytes(kept)
    lines = beside.read_text().splitlines()
    beside.write_text("\n".join(line for line in lines if not line.startswith("log_checksum")))
    shutil.copy(tmp_path / "other.csv", path)
    assert cogging.read_log(path).metadata["seed"] == 1


def test_data_reach_the_disk_before_their_names(tmp_path, monkeypatch):
    calls = []
    monkeypatch.setattr(outputs, "synced", True)
    for name in ("fsync", "replace"):
        plain = getattr(os, name)
        monkeypatch.setattr(os, name, lambda *args, name=name, plain=plain: calls.append(name) or plain(*args))
    outputs.write_files({str(tmp_path / "a"): [b"1"], str(tmp_path / "b"): [b"2"]})
    assert calls == ["fsync", "fsync", "replace", "replace"]


def test_a_folder_that_was_made_goes_with_what_could_not_be_written(tmp_path, monkeypatch):
    monkeypatch.setattr(papers, "png", lambda name: name.encode())
    found = papers.Reproduction("paper", [], {"fig": "fig", "x" * 300: "long"})
    with pytest.raises(InputError, match=r"xxx\.png: cannot be written: File name too long"):
        found.write(tmp_path / "deep" / "results")
    assert list(tmp_path.iterdir()) == []
    found.figures.pop("x" * 300)
    written = found.write(tmp_path / "deep" / "results")
    assert sorted(path.name for path in written) == ["fig.png", "paper.json"]
    assert (tmp_path / "deep" / "results" / "fig.png").read_bytes() == b"fig"
