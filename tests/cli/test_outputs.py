"""Where a command writes: never onto what it reads, nothing twice, onto nothing but files, and whole or not at all."""

import os
import shutil
import stat
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging import files, outputs
from cogging.cli.main import main
from cogging.files import InputError
from tests.fixtures.covering import covering
from tests.fixtures.files import MODEL, REFERENCE

SAMPLED = 'type = "sampled"\nfile = "samples.csv"\n'
LOGS = ["log.csv", "log.csv.toml", "other.csv", "other.csv.toml", "model.toml"]
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
    "map": ("map scan.csv --pitch 0.05", ["scan.csv"], ["--out"]),
    "predict": (
        "predict model.toml --reference sampled.toml",
        ["model.toml", "sampled.toml", "samples.csv"],
        ["--json"],
    ),
    "simulate": (
        "simulate model.toml --reference sampled.toml",
        ["model.toml", "sampled.toml", "samples.csv"],
        ["--out"],
    ),
}
COMMANDS = {command: (call.split(), read, options) for command, (call, read, options) in COMMANDS.items()}
CASES = [
    (command, file, option) for command, (_, read, options) in COMMANDS.items() for file in read for option in options
]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Logs, a scan, a model and references, made once."""
    folder = tmp_path_factory.mktemp("inputs")
    (folder / "model.toml").write_text(MODEL)
    (folder / "ref.toml").write_text(REFERENCE)
    (folder / "sampled.toml").write_text(SAMPLED)
    (folder / "limits.toml").write_text("velocity = 0.3\nacceleration = 5.0\nduration = 3.0\n")
    (folder / "result.json").write_text('{"verdict": "no_gap", "effects": []}')
    for seed, name in enumerate(("log.csv", "other.csv")):
        cogging.simulate(folder / "model.toml", folder / "ref.toml", seed=seed).write(folder / name)
    (folder / "other.csv.toml").unlink()  # which then only may be there
    t = np.arange(500) * 1e-3
    reference = 0.2 + 0.01 * (1.0 - np.cos(4.0 * np.pi * t))
    rows = zip(t.tolist(), reference.tolist(), strict=True)
    (folder / "samples.csv").write_text("time,reference\n" + "".join(f"{a!r},{b!r}\n" for a, b in rows))
    x = np.arange(510) * 1e-3
    rows = zip(x.tolist(), np.sin(2.0 * np.pi * x / 0.05).tolist(), strict=True)
    (folder / "scan.csv").write_text("position,force\n" + "".join(f"{a!r},{b!r}\n" for a, b in rows))
    return folder


@pytest.fixture
def folder(written, tmp_path, monkeypatch):
    shutil.copytree(written, tmp_path / "work")
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


def content(folder):
    return {str(path): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def refused(call, capsys, *parts):
    """The call is answered in one line with status 2, and before it has computed anything."""
    assert main(call) == 2
    said = capsys.readouterr()
    assert said.out == "", "before anything is computed"
    assert said.err.startswith("cogging: ")
    assert said.err.count("\n") == 1
    for part in parts:
        assert part in said.err
    return said.err


def by_name(target):
    return target


def by_another_spelling(target):
    return os.path.join("..", "work", ".", target)


def by_its_absolute_path(target):
    return os.path.abspath(target)


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


NAMES = [by_name, by_another_spelling, by_its_absolute_path, by_symbolic_link, by_linked_folder, by_hard_link]


@pytest.mark.parametrize(("case", "name"), covering(CASES, NAMES))
def test_no_output_is_an_input(case, name, folder, capsys):
    command, file, option = case
    output = name(file)
    before = content(folder)
    refused([*COMMANDS[command][0], option, output], capsys, option, f"{file}", "must not be a file that is read")
    assert content(folder) == before


@pytest.mark.parametrize("command", [command for command, (_, _, options) in COMMANDS.items() if len(options) > 1])
@pytest.mark.parametrize("name", [by_name, by_another_spelling, by_symbolic_link, by_linked_folder])
def test_no_file_is_written_twice(command, name, folder, capsys):
    call, _, options = COMMANDS[command]
    before = content(folder)
    for one in options:
        for other in options:
            if one != other:
                for link in ("a link", "../again"):
                    Path(link).unlink(missing_ok=True)
                refused([*call, one, "new", other, name("new")], capsys, "must be different files, got one twice")
    assert content(folder) == before


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
    before = content(folder)
    refused(call.split(), capsys, message)
    assert content(folder) == before


def test_a_sidecar_replaces_only_a_sidecar(folder, capsys):
    """The model `machine.toml` is not what belongs to the log `machine`, whether it was read or not."""
    shutil.copy("model.toml", "machine.toml")
    before = content(folder)
    assert main(["simulate", "model.toml", "--reference", "ref.toml", "--out", "machine"]) == 2
    assert "machine.toml: must be what a log left here to be replaced" in capsys.readouterr().err
    log = cogging.read_log("log.csv")
    bare = cogging.Log(time=log.time, position=log.position, command=log.command)
    for one in (log, bare):
        with pytest.raises(InputError, match=r"machine\.toml: must be what a log left here"):
            one.write("machine")
    assert content(folder) == before
    log.write("copy.csv")
    log.write("copy.csv")
    assert Path("copy.csv.toml").exists()
    bare.write("copy.csv")
    assert not Path("copy.csv.toml").exists()


def test_a_map_and_its_figure_in_python(folder, capsys):
    assert main(["map", "scan.csv", "--pitch", "0.05", "--out", "map.toml"]) == 0
    table = cogging.logs.columns.read_columns("scan.csv", ("position", "force"))
    fit = cogging.fit_map(table["position"], table["force"], pitch=0.05, harmonics=[1], order=0)
    with pytest.raises(InputError, match=r"o\.png: must not be where its figure is written"):
        fit.write("o.png")
    Path("linked.png").symlink_to("linked.toml")
    with pytest.raises(InputError, match="must not be where its figure is written"):
        fit.write("linked.toml")
    assert not Path("o.png").exists()
    assert not Path("linked.toml").exists()


OUTPUTS = [(command, option) for command, (_, _, options) in COMMANDS.items() for option in options]


def pipe(path):
    os.mkfifo(path)


def device(path):
    Path(path).symlink_to("/dev/null")


def full_device(path):
    Path(path).symlink_to("/dev/full")


def folder_there(path):
    Path(path).mkdir()


def below_a_file(path):
    Path(path).parent.mkdir(exist_ok=True)
    Path("below").touch()
    return "below/out"


def below_nothing(path):
    return "missing/out"


def linked_in_a_circle(path):
    Path(path).symlink_to("circle")
    Path("circle").symlink_to(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes and devices of POSIX")
@pytest.mark.parametrize(
    ("case", "make"),
    covering(OUTPUTS, [pipe, device, full_device, folder_there, below_a_file, below_nothing, linked_in_a_circle]),
)
def test_an_output_is_a_file(case, make, folder, capsys):
    command, option = case
    output = make("out") or "out"
    refused([*COMMANDS[command][0], option, output], capsys, output)
    assert not list(folder.rglob("*.part"))


@pytest.mark.parametrize("what", ["file", "below a file", "pipe"])
def test_reproduce_writes_into_a_folder(what, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    if what == "pipe":
        os.mkfifo("out")
    else:
        Path("out").write_text("mine")
    refused(["reproduce", "lu2008", "--out", "out/deep" if what == "below a file" else "out"], capsys, "cannot be made")


@pytest.mark.skipif(os.name == "nt", reason="modes and links of POSIX")
class TestWriting:
    def test_a_link_stays_and_its_target_is_replaced(self, tmp_path):
        real, link = tmp_path / "kept" / "real.toml", tmp_path / "link.toml"
        real.parent.mkdir()
        real.write_text("old")
        link.symlink_to(Path("kept", "real.toml"))
        outputs.write_text(link, "new")
        assert link.is_symlink()
        assert os.readlink(link) == os.path.join("kept", "real.toml")
        assert real.read_text() == "new"
        assert sorted(tmp_path.rglob("*")) == [real.parent, real, link]

    def test_a_link_to_what_is_not_there_yet(self, tmp_path):
        (tmp_path / "link").symlink_to("later")
        outputs.write_text(tmp_path / "link", "new")
        assert (tmp_path / "link").is_symlink()
        assert (tmp_path / "later").read_text() == "new"

    @pytest.mark.parametrize("mode", [0o600, 0o640, 0o644, 0o664, 0o755, 0o777])
    def test_a_file_keeps_its_mode(self, mode, tmp_path):
        path = tmp_path / "a"
        path.write_text("old")
        path.chmod(mode)
        outputs.write_text(path, "new")
        assert stat.S_IMODE(path.stat().st_mode) == mode
        assert path.read_text() == "new"

    @pytest.mark.parametrize("mask", [0o000, 0o002, 0o022, 0o027, 0o077])
    def test_a_new_file_has_what_the_mask_leaves(self, mask, tmp_path):
        before = os.umask(mask)
        try:
            outputs.write_text(tmp_path / "a", "new")
        finally:
            os.umask(before)
        assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o666 & ~mask

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


@pytest.mark.parametrize("thrown", [KeyboardInterrupt, SystemExit, MemoryError, OSError(28, "No space left on device")])
def test_nothing_is_left_of_what_was_interrupted(thrown, tmp_path):
    """SIGTERM becomes an exception too: whatever comes, the temporary files go and the old ones stay."""
    (tmp_path / "a").write_text("old")

    def pieces():
        yield b"half"
        assert len(list(tmp_path.glob(".*.part"))) == 2
        raise thrown

    with pytest.raises((KeyboardInterrupt, SystemExit, MemoryError, InputError)):
        outputs.write_files({str(tmp_path / "a"): [b"new"], str(tmp_path / "b"): pieces()})
    assert content(tmp_path) == {str(tmp_path / "a"): b"old"}


def test_a_log_and_its_sidecar_are_two_files(tmp_path):
    log = cogging.Log(time=np.arange(3.0), position=np.zeros(3), command=np.zeros(3), metadata={"seed": 1})
    (tmp_path / "a.csv.toml").symlink_to("a.csv")
    with pytest.raises(InputError, match="must be different files, got one twice"):
        log.write(tmp_path / "a.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv.toml"]


def test_a_long_name(tmp_path):
    name = "n" * 255
    outputs.write_text(tmp_path / name, "new")
    assert (tmp_path / name).read_text() == "new"


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


def test_a_text_that_grows_while_it_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "MOST_TEXT", 1000)
    (tmp_path / "a").write_text("x" * 1000)
    assert files.read_text(tmp_path / "a") == "x" * 1000
    (tmp_path / "a").write_text("x" * 1001)
    with pytest.raises(InputError, match="must be at most 0 MiB of text, got 1001 bytes"):
        files.read_text(tmp_path / "a")
    monkeypatch.setattr(files, "require_file", lambda path: 10)
    with pytest.raises(InputError, match="got 1001 bytes"):
        files.read_text(tmp_path / "a")
