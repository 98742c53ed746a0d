"""Where a command writes: never onto what it reads, nothing twice, onto nothing but files, and whole or not at all."""

import errno
import itertools
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging import outputs
from cogging.cli.main import main
from cogging.files import InputError
from cogging.papers import result as papers
from tests.fixtures import command_files
from tests.fixtures.covering import covering

POSIX = pytest.mark.skipif(os.name == "nt", reason="processes, modes and pipes of POSIX")
LOGS = ["log.csv", "log.csv.toml", "other.csv", "other.csv.toml", "model.toml"]
SAMPLES = ["model.toml", "sampled.toml", "samples.csv"]
#: Every command that reads and writes: call, inputs (those beside them included), options that write.
COMMANDS = {
    "identify": ("identify log.csv other.csv --model model.toml", LOGS, ["--out", "--json"]),
    "diagnose": ("diagnose log.csv --model model.toml --confirm other.csv", LOGS, ["--out", "--json", "--report"]),
    "experiment": (
        "experiment --model model.toml --result result.json --limits limits.toml",
        ["model.toml", "result.json", "limits.toml"],
        ["--out"],
    ),
    "audit": ("audit log.csv other.csv --model model.toml", LOGS, ["--json"]),
    "map": ("map scan.csv --pitch 0.05", ["scan.csv"], ["--out", "--json"]),
    "predict": ("predict model.toml --reference sampled.toml", SAMPLES, ["--json"]),
    "simulate": ("simulate model.toml --reference sampled.toml", SAMPLES, ["--out"]),
    "sweep": ("sweep sweep.toml", ["sweep.toml", "model.toml", "ref.toml"], ["--out", "--json"]),
    "tune": ("tune tune.toml", ["tune.toml", "model.toml", "ref.toml"], ["--out", "--json"]),
}
WRITES = [(call, option) for call, _, options in COMMANDS.values() for option in options]
ONTO = [(call, file, option) for call, read, options in COMMANDS.values() for file in read for option in options]
TWICE = [(call, *two) for call, _, options in COMMANDS.values() for two in itertools.permutations(options, 2)]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    command_files.write(work)
    (work / "sampled.toml").write_text('type = "sampled"\nfile = "samples.csv"\n')
    time = np.arange(500) * 1e-3
    command_files.table(
        work / "samples.csv", {"time": time, "reference": 0.2 + 0.01 * (1.0 - np.cos(4.0 * np.pi * time))}
    )
    return work


def content(folder):
    return {str(path): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def refused(call, capsys, *parts):
    """The call is answered in one line with status 2, before it has computed or written anything."""
    before = content(Path())
    assert main(call) == 2
    out, error = capsys.readouterr()
    assert (out, error[:9], error.count("\n")) == ("", "cogging: ", 1)
    for part in parts:
        assert part in error
    assert content(Path()) == before


def by_symbolic_link(target):
    Path("a link").symlink_to(target)
    return "a link"


def by_linked_folder(target):
    Path("..", "again").symlink_to("work")
    return os.path.join("..", "again", target)


def by_hard_link(target):
    Path(target).touch()  # a sidecar that only may be there
    os.link(target, "a hard link")
    return "a hard link"


NAMES = [str, lambda name: os.path.join("..", "work", ".", name), os.path.abspath, by_symbolic_link, by_linked_folder]


@pytest.mark.parametrize(("case", "name"), covering(ONTO, [*NAMES, by_hard_link]))
def test_no_output_is_an_input(case, name, folder, capsys):
    call, file, option = case
    refused([*call.split(), option, name(file)], capsys, option, file, "must not be a file that is read")


@pytest.mark.parametrize(("case", "name"), covering(TWICE, NAMES))
def test_no_file_is_written_twice(case, name, folder, capsys):
    call, one, other = case
    refused([*call.split(), one, "new", other, name("new")], capsys, "must be different files, got one twice")


SIMULATE = "simulate model.toml --reference ref.toml --out"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (f"{SIMULATE} model", "its sidecar: model.toml: must not be"),
        (f"{SIMULATE} ref", "its sidecar: ref.toml: must not be"),
        ("map scan.csv --pitch 0.05 --out o.png", "--out, its figure: must be different files"),
        ("map log.png --pitch 0.05 --out log.toml", "its figure: log.png: must not be a file that is"),
    ],
)
def test_what_is_written_beside_an_output_is_one_too(call, message, folder, capsys):
    shutil.copy("scan.csv", "log.png")
    refused(call.split(), capsys, message)


def test_a_sidecar_replaces_only_a_sidecar(folder):
    """The model `machine.toml` is not what belongs to the log `machine`, whether it was read or not."""
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


def test_a_map_and_its_figure_are_two_files(folder):
    fit = cogging.fit_map(
        np.arange(400) * 1e-3, np.sin(np.arange(400) * 40e-3 * np.pi), pitch=0.05, harmonics=[1], order=0
    )
    Path("linked.png").symlink_to("linked.toml")
    before = content(folder)
    for name in ("o.png", "linked.toml"):
        with pytest.raises(InputError, match="must not be where its figure is written"):
            fit.write(name)
    assert content(folder) == before


def below_a_file(path):
    Path("below").touch()
    return "below/out"


def linked_in_a_circle(path):
    Path(path).symlink_to("circle")
    Path("circle").symlink_to(path)


#: What stands where an output is wanted; some give another path.
THERE = [
    getattr(os, "mkfifo", None),
    lambda path: Path(path).symlink_to("/dev/null"),
    os.mkdir,
    lambda path: "missing/out",
    below_a_file,
    linked_in_a_circle,
]


@POSIX
@pytest.mark.parametrize(("case", "make"), covering(WRITES, THERE))
def test_an_output_is_a_file(case, make, folder, capsys):
    call, option = case
    output = make("out") or "out"
    refused([*call.split(), option, output], capsys, output)


def test_reproduce_writes_into_a_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("out").write_text("mine")
    for name in ("out", "out/deep"):
        refused(["reproduce", "lu2008", "--out", name], capsys, "cannot be made")


@POSIX
class TestWriting:
    def test_a_link_stays_and_its_target_is_replaced(self, tmp_path):
        real, link = tmp_path / "kept" / "real.toml", tmp_path / "link.toml"
        real.parent.mkdir()
        link.symlink_to(Path("kept", "real.toml"))
        for text in ("first", "second"):  # a target that is not there yet, and one that is
            outputs.write_text(link, text)
            assert os.readlink(link) == os.path.join("kept", "real.toml")
            assert real.read_text() == text
        assert sorted(tmp_path.rglob("*")) == [real.parent, real, link]

    @pytest.mark.parametrize("mode", [0o600, 0o664, 0o755])
    def test_a_file_keeps_its_mode_and_a_new_one_has_what_the_mask_leaves(self, mode, tmp_path):
        before = os.umask(0o777 & ~mode)
        try:
            outputs.write_text(tmp_path / "a", "old")
        finally:
            os.umask(before)
        assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o666 & mode
        (tmp_path / "a").chmod(mode)
        outputs.write_text(tmp_path / "a", "new")
        assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == mode

    @pytest.mark.root
    def test_an_owner_is_kept(self, tmp_path):
        path = tmp_path / "a"
        path.write_text("old")
        os.chown(path, 1234, 4321)
        path.chmod(0o640)
        outputs.write_text(path, "new")
        kept = path.stat()
        assert (kept.st_uid, kept.st_gid, stat.S_IMODE(kept.st_mode)) == (1234, 4321, 0o640)

    def test_content_is_not_to_be_read_by_others_before_it_takes_its_place(self, tmp_path):
        path, seen = tmp_path / "a", []
        path.write_text("old")
        path.chmod(0o600)

        def pieces():
            (part,) = tmp_path.glob(".*.part")
            seen.append((part.name, stat.S_IMODE(part.stat().st_mode)))
            yield b"new"

        for _ in range(20):
            outputs.write_files({str(path): pieces()})
        assert {mode for _, mode in seen} == {0o600}
        assert len({name for name, _ in seen}) == 20, "names that nobody foresees"

    def test_a_planted_link_is_not_followed(self, tmp_path, monkeypatch):
        """Even where somebody foresees the name."""
        victim = tmp_path / "victim"
        victim.write_text("mine")
        monkeypatch.setattr(outputs.secrets, "token_hex", lambda size: "0" * (2 * size))
        outputs.write_text(tmp_path / "first", "x")
        (tmp_path / f".cogging-{'0' * 16}.part").symlink_to(victim)
        with pytest.raises(InputError, match="second: cannot be written: File exists"):
            outputs.write_text(tmp_path / "second", "new")
        assert victim.read_text() == "mine"
        assert not (tmp_path / "second").exists()


# --- files that belong together

OLD = {"a": b"old a", "b": b"old b", "gone": b"old too"}
NEW = {"a": b"new a", "b": b"new b", "c": b"new too"}


def log(seed):
    columns = {name: np.full(3, float(seed)) for name in ("position", "command")}
    return cogging.Log(time=np.arange(3.0), **columns, metadata={"seed": seed})


def fail_at(patch, number, error):
    """Raise at the n-th call of what changes a folder; return the list that holds how many are left until then."""
    left = [number]

    def failing(plain):
        def call(*args, **kwargs):
            left[0] -= 1
            if left[0] == 0:
                raise error
            return plain(*args, **kwargs)

        return call

    for name in ("open", "replace", "unlink"):
        patch.setattr(os, name, failing(getattr(os, name)))
    return left


@POSIX
@pytest.mark.parametrize("error", [OSError(errno.EIO, os.strerror(errno.EIO)), KeyboardInterrupt()])
def test_a_failure_between_any_two_steps_leaves_whole_files(error, tmp_path, monkeypatch):
    for number in range(1, 60):
        folder, raised = tmp_path / f"{number}", None
        folder.mkdir()
        for name, old in OLD.items():
            (folder / name).write_bytes(old)
        with monkeypatch.context() as patch:
            left = fail_at(patch, number, error)
            try:
                new = {str(folder / name): [pieces] for name, pieces in NEW.items()}
                outputs.write_files({**new, str(folder / "gone"): None})
            except (InputError, KeyboardInterrupt) as found:
                raised = found
        found = {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix != ".part"}
        for name in ("a", "b", "c", "gone"):
            assert found.get(name) in (OLD.get(name), NEW.get(name))
        if number <= 4:
            assert found == OLD, "nothing takes its place before all are written"
        if isinstance(error, OSError) and raised is not None:
            assert f"{folder}" in str(raised)
        if left[0] > 0:
            break
    assert found == NEW
    assert number > 8


@POSIX
def test_a_killed_writer_leaves_one_log_or_a_pair_that_is_refused(tmp_path):
    """SIGKILL before each file operation: the reader gets one log with its own metadata, or one line that says why."""
    code = """
import os
from pathlib import Path
import cogging
from tests.attack.operations import at_operation
from tests.cli.test_outputs import log

for number in range(1, 40):
    folder = Path(f"{number}")
    folder.mkdir()
    log(1).write(folder / "log.csv")
    child = os.fork()
    if not child:
        at_operation(number, lambda _, path: path.startswith(f"{folder.resolve()}"), lambda *_: os.kill(os.getpid(), 9))
        log(2).write(folder / "log.csv")
        os._exit(0)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    try:
        read = cogging.read_log(folder / "log.csv")
        assert read.command[0] == read.metadata["seed"]
        print(status, read.metadata["seed"])
    except cogging.InputError as error:
        assert "log.csv.toml: log_checksum: must be the log_checksum of" in str(error)
        print(status, "refused")
    if not status:
        break
"""
    environment = {**os.environ, "PYTHONPATH": f"{Path(__file__).parents[2]}:{Path(cogging.__file__).parents[1]}"}
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert set(lines) == {"-9 1", "-9 refused", "-9 2", "0 2"}
    assert lines[-1] == "0 2"


def test_a_checksum_is_of_its_log_alone(tmp_path):
    path, beside = tmp_path / "log.csv", tmp_path / "log.csv.toml"
    log(1).write(path)
    assert cogging.read_log(path).metadata.keys() == {"version", "seed"}
    cogging.read_log(path).write(tmp_path / "copy.csv")
    assert (tmp_path / "copy.csv.toml").read_bytes() == beside.read_bytes()
    path.write_text(path.read_text() + "3,1,1\n")
    with pytest.raises(InputError, match=r"remove the line if that log was changed on purpose, got 'crc32:"):
        cogging.read_log(path)
    beside.write_text(
        "".join(line for line in beside.read_text().splitlines(keepends=True) if not line.startswith("log_checksum"))
    )
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
    rows = [papers.Row("C1", "e_inf", "m", 1.0, 2.0, "predicted")]
    monkeypatch.setattr(papers, "png", lambda name: name.encode())
    found = papers.Reproduction("paper", [papers.Table("table1", "Table 1", rows)], {"fig": "fig", "x" * 300: "long"})
    with pytest.raises(InputError, match=r"xxx\.png: cannot be written: File name too long"):
        found.write(tmp_path / "deep" / "results")
    assert list(tmp_path.iterdir()) == []
    found.figures.pop("x" * 300)
    written = found.write(tmp_path / "deep" / "results")
    assert sorted(path.name for path in written) == ["fig.png", "paper.json"]
    assert (tmp_path / "deep" / "results" / "fig.png").read_bytes() == b"fig"


@pytest.mark.root
def test_a_file_of_another_in_a_shared_folder_is_refused_before_anything_is_computed(tmp_path, monkeypatch):
    tmp_path.chmod(0o1777)
    (tmp_path / "a").write_text("old")
    os.chown(tmp_path, 1, 1)
    os.chown(tmp_path / "a", 2, 2)
    for user, may in ((0, True), (1, True), (2, True), (3, False)):
        monkeypatch.setattr(os, "geteuid", lambda user=user: user)
        if may:
            outputs.check_outputs({"--out": tmp_path / "a"})
        else:
            with pytest.raises(InputError, match="a: cannot be written: Operation not permitted"):
                outputs.check_outputs({"--out": tmp_path / "a"})


# --- what is read -----------------------------------------------------------------------------------------------------


def endless(path):
    path.symlink_to("/dev/zero")


def huge(path):
    with open(path, "wb") as file:
        file.truncate(1 << 40)


STRANGE = {
    "pipe": (os.mkfifo if hasattr(os, "mkfifo") else None, "must be a file, got a device or pipe"),
    "endless": (endless, "must be a file, got a device or pipe"),
    "folder": (os.mkdir, "must be a file, got a directory"),
    "huge": (huge, "must be at most 256 MiB of text, got 1099511627776 bytes"),
}
READ = [
    *((f"{SIMULATE} new.csv", file) for file in ("model.toml", "ref.toml", "new.csv.toml")),
    *(("predict model.toml --reference ref.toml", file) for file in ("model.toml", "ref.toml")),
    *(
        (f"{command} log.csv --model model.toml", file)
        for command in ("identify", "diagnose", "audit")
        for file in ("model.toml", "log.csv.toml")
    ),
]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes and devices of POSIX")
@pytest.mark.parametrize(("case", "what"), covering(range(len(READ)), STRANGE))
def test_what_is_read_is_a_file_with_an_end(case, what, folder, capsys):
    call, file = READ[case]
    make, message = STRANGE[what]
    Path(file).unlink(missing_ok=True)
    make(folder / file)
    assert main(call.split()) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert file in said
    if file != "new.csv.toml":
        assert message in said
