"""First models of drawn logs: right, or marked as not identifiable; and the next command runs."""

import math
import re
import shlex

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.files import InputError, read_toml
from tests.fixtures.pid_axis import MODEL
from tests.fixtures.user_logs import user_log

SEEDS = range(100, 118)


@pytest.fixture(scope="module")
def drafts(tmp_path_factory):
    """Drawn logs and their drafts."""
    folder = tmp_path_factory.mktemp("logs")
    made = []
    for seed in SEEDS:
        drawn = user_log(seed)
        (folder / f"{seed}.csv").write_text(drawn.text)
        made.append((drawn, cogging.draft_model(folder / f"{seed}.csv")))
    return made


def about(draft, word):
    return [entry for entry in (*draft.unsure, *draft.likely) if entry.startswith(word)]


def test_columns_and_units_are_right_or_said_to_be_guessed(drafts):
    right = 0
    for drawn, draft in drafts:
        for name, header in drawn.headers.items():
            assert draft.columns.used[name].label == header
            same = math.isclose(draft.scale.get(name, 1.0), drawn.factors[name], rel_tol=1e-6)
            right += same
            assert same or (not drawn.stated and about(draft, name)), (header, draft.scale)
            assert drawn.stated or about(draft, "position")
        assert ("reference" in draft.columns.used) == drawn.has_reference
        assert draft.units.command == drawn.command_unit
    assert right > 0.9 * sum(len(drawn.headers) for drawn, _ in drafts)


def test_the_log_is_read_as_it_was_simulated(drafts):
    for drawn, draft in drafts:
        unit = draft.scale.get("position", 1.0) / drawn.factors["position"]
        assert abs(np.ptp(draft.log.position) / unit - np.ptp(drawn.log.position)) < 2.0 * drawn.quantum
        assert np.sign(draft.scale.get("command", 1.0)) == (-1.0 if drawn.flipped else 1.0)
        assert (draft.audit.rate * draft.scale.get("time", 1.0) / drawn.factors["time"]) == pytest.approx(
            drawn.rate, rel=0.02
        )
        assert draft.audit.encoder_quantum / unit == pytest.approx(drawn.quantum, rel=0.01)
        lost = len(drawn.log) - len(draft.log)
        assert lost == drawn.dropped
        assert (draft.audit.gaps > 0) == (drawn.dropped > 0)


def test_mass_and_friction_are_within_what_is_said_of_them(drafts):
    known = {"mass": 0, "viscous": 0, "coulomb": 0}
    for drawn, draft in drafts:
        unit = draft.scale.get("position", 1.0) / drawn.factors["position"]
        unit_of_time = draft.scale.get("time", 1.0) / drawn.factors["time"]
        for name, factor in (("mass", unit_of_time**2 / unit), ("viscous", unit_of_time / unit), ("coulomb", 1.0)):
            size = draft.sizes.sizes[name]
            if size.uncertainty is None:
                assert about(draft, name)
                continue
            known[name] += 1
            true = factor * getattr(drawn.model.axis, name)
            assert abs(size.value / true - 1.0) < 3.0 * size.uncertainty, (name, size, true)
    assert known["mass"] == len(drafts)
    assert min(known.values()) > 0.6 * len(drafts)


def test_the_motion_is_known(drafts):
    for drawn, draft in drafts:
        assert draft.motion.kind == drawn.motion
        unit = draft.scale.get("position", 1.0) / drawn.factors["position"]
        known = {
            "distance": unit,
            "amplitude": unit,
            "velocity": unit,
            "acceleration": unit,
            "dwell": 1.0,
            "frequency": 1.0,
        }
        for name in known.keys() & draft.motion.fields.keys():
            assert draft.motion.fields[name] == pytest.approx(known[name] * drawn.fields[name], rel=0.15), name


def test_a_wave_over_position_is_that_of_the_cogging(drafts):
    right = seen = 0
    for drawn, draft in drafts:
        if draft.wave is None:
            continue
        seen += 1
        assert drawn.model.cogging.sine[0, 0] > 0.0
        unit = draft.scale.get("position", 1.0) / drawn.factors["position"]
        right += abs(draft.wave.period / (unit * drawn.model.cogging.basis.pitch) - 1.0) < 0.03
    assert right >= 0.8 * seen > 0
    strong = [draft for drawn, draft in drafts if drawn.model.cogging.sine[0, 0] > 0.3 * drawn.model.axis.coulomb]
    assert sum(draft.wave is not None for draft in strong) >= 0.6 * len(strong) > 0


def test_the_files_are_read_back_and_run(drafts, tmp_path):
    for k, (_, draft) in enumerate(drafts):
        model, reference = tmp_path / f"{k}.toml", tmp_path / f"{k}_motion.toml"
        draft.write(model, reference)
        read = cogging.Model.read(model)
        assert read == draft.model
        assert read.units == draft.units
        assert read.axis.mass == pytest.approx(draft.sizes.sizes["mass"].value, rel=1e-3)
        motion, duration = cogging.read_reference(reference)
        times = draft.log.time - draft.log.time[0]
        seen = draft.log.position if draft.log.reference is None else draft.log.reference
        if draft.motion.kind != "sine":  # whose phase a reference file does not hold
            off = np.asarray(motion.sample(times)[0]) - seen
            assert np.sqrt(np.mean(off**2)) < 0.1 * np.ptp(seen)
        assert duration == 0.0 or duration == pytest.approx(times[-1])


def test_all_proposals_taken_are_a_model(drafts, tmp_path):
    """With the single # taken away everywhere, [controller] and [cogging] included, the file is read as well."""
    for k, (_, draft) in enumerate(drafts):
        path = tmp_path / f"{k}.toml"
        path.write_text("\n".join(line.removeprefix("# ") for line in draft.model_text().splitlines()))
        model = cogging.Model.read(path)
        assert model.axis == draft.model.axis
        assert model.controller.kp > 0.0
        pitch = model.cogging.basis.pitch
        assert pitch == pytest.approx(draft.wave.period, rel=1e-3) if draft.wave else pitch > 0.0


@pytest.mark.parametrize("seed", [107, 111])
def test_the_next_command_runs_as_printed(seed, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    drawn = user_log(seed)
    (tmp_path / "my log.csv").write_text(drawn.text)
    assert main(["init", "my log.csv"]) == 0
    printed = capsys.readouterr().out
    following = printed.splitlines()[-1]
    assert following.startswith("next: cogging ")
    words = shlex.split(following.removeprefix("next: cogging "))
    assert words[0] == "identify"
    assert main(words) == 0
    fitted = cogging.Model.read("fitted.toml")
    assert fitted.axis.mass > 0.0
    assert fitted.units == cogging.Model.read("model.toml").units
    drafted, kept = ((tmp_path / f"{name}.toml").read_text() for name in ("model", "fitted"))
    assert [line for line in drafted.splitlines() if line.partition("#")[2] not in kept] == []
    audit = ["audit", *(word for word in words[1:] if word not in ("--out", "fitted.toml"))]
    assert main(audit) == 0


# What cannot be told --------------------------------------------------------------------------------------------------


def table(path, labels, columns):
    rows = zip(*[np.asarray(column).tolist() for column in columns], strict=True)
    path.write_text(",".join(labels) + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
    return path


TIME = np.arange(2000) * 1e-3
RANDOM = np.random.default_rng(3).standard_normal(2000)


def test_columns_without_telling_names_are_known_by_how_they_behave(tmp_path):
    position = 0.1 * np.sin(3.0 * TIME)
    path = table(tmp_path / "a.csv", ["ch1", "ch2", "ch3"], [-9.0 * position + 0.05 * RANDOM, TIME, position])
    draft = cogging.draft_model(path)
    assert {name: guess.label for name, guess in draft.columns.used.items()} == {
        "time": "ch2",
        "position": "ch3",
        "command": "ch1",
    }
    assert all(about(draft, name) for name in ("time", "position", "command"))


@pytest.mark.parametrize(
    ("labels", "columns", "rule"),
    [
        (
            ["t", "ch1", "ch2"],
            [TIME, np.sin(TIME), np.cos(TIME)],
            "column position: cannot be identified among .* 'ch1', 'ch2'",
        ),
        (["t", "speed", "Iq"], [TIME, RANDOM, RANDOM], "column position: .*'speed' looks like a velocity"),
        (["x", "Iq"], [RANDOM, RANDOM], "column time: cannot be identified"),
        (["t", "x"], [TIME, RANDOM], "column command: cannot be identified"),
    ],
)
def test_what_cannot_be_told_is_asked_in_one_line(labels, columns, rule, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    table(tmp_path / "a.csv", labels, columns)
    assert main(["init", "a.csv"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    with pytest.raises(InputError, match=rule):
        cogging.draft_model("a.csv")
    assert "--columns " in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv"]


def test_a_log_without_a_header_or_columns_of_numbers(tmp_path):
    (tmp_path / "a.csv").write_text("0.0,1.0,2.0\n0.1,1.1,2.0\n0.2,1.2,2.0\n")
    with pytest.raises(InputError, match="line 1: must be a header row with the names of the columns"):
        cogging.draft_model(tmp_path / "a.csv")
    (tmp_path / "b.csv").write_text("a,b\nx,y\nu,v\n")
    with pytest.raises(InputError, match="column time: cannot be identified among none"):
        cogging.draft_model(tmp_path / "b.csv")


def test_at_rest_nothing_is_claimed_and_an_audit_comes_next(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    table(tmp_path / "a.csv", ["time", "position", "command"], [TIME, np.full(2000, 0.25), 0.01 * RANDOM])
    draft = cogging.draft_model("a.csv")
    assert draft.motion.kind == "rest"
    assert all(size.uncertainty is None for size in draft.sizes.sizes.values())
    assert main(["init", "a.csv"]) == 0
    words = shlex.split(capsys.readouterr().out.splitlines()[-1].removeprefix("next: cogging "))
    assert words[0] == "audit"
    assert main(words) == 0


@pytest.mark.parametrize(
    ("label", "column", "factor"),
    [
        ("pos [counts]", "UNKNOWN", 1e-6),
        ("winkel [deg]", "rad", math.pi / 180.0),
        ("theta (rad)", "rad", 1.0),
        ("x [inch]", "m", 0.0254),
    ],
)
def test_units_of_other_kinds(label, column, factor, tmp_path):
    position = np.round(20000.0 * np.sin(3.0 * TIME))
    path = table(tmp_path / "a.csv", ["t [s]", label, "torque [Nm]"], [TIME, position, RANDOM])
    draft = cogging.draft_model(path)
    assert draft.scale.get("position", 1.0) == pytest.approx(factor)
    assert draft.units.command == "Nm"
    assert " Nm" in draft.audit.text()
    assert not re.search(r"[\d] V\b", draft.text())
    if column == "UNKNOWN":
        assert any("counts of an encoder" in entry for entry in draft.unsure)
    else:
        assert draft.units.position == column
    assert cogging.Model.read(_written(draft, tmp_path)).units == draft.units


@pytest.mark.parametrize(
    ("labels", "factor", "turns"),
    [
        (["time", "position", "torque"], 1.0, True),
        (["time", "position", "drehmoment [mNm]"], 1.0, True),
        (["time", "joint one [deg]", "motor 1 [Nm]"], math.pi / 180.0, True),
        (["time", "position [mm]", "torque"], 1e-3, False),
    ],
)
def test_an_axis_that_turns_is_measured_in_rad_and_nm(labels, factor, turns, tmp_path):
    columns = [TIME, np.sin(3.0 * TIME) / factor, RANDOM]
    draft = cogging.draft_model(table(tmp_path / "a.csv", labels, columns))
    assert draft.units == (cogging.Units(command="Nm", position="rad") if turns else cogging.Units())
    assert draft.scale.get("position", 1.0) == pytest.approx(factor)
    said = draft.text() + draft.model_text() + draft.reference_text()
    assert not turns or not re.search(r"[\d\]] [mu]?[mV]\b|[mV]/\(?m|\bm/s|# [mV];", said)
    assert cogging.Model.read(_written(draft, tmp_path)).units == draft.units


def test_a_simulated_log_is_drafted_in_the_units_of_its_model(tmp_path):
    model = MODEL.replace(units=cogging.Units(command="A", position="rad"))
    log = cogging.simulate(
        model, cogging.Sine(cogging.SineParameters(center=0.2, amplitude=0.05, frequency=2.0)), duration=1.0
    )
    log.write(tmp_path / "a.csv")
    for draft in (cogging.draft_model(log), cogging.draft_model(tmp_path / "a.csv")):
        assert draft.units == model.units
        assert draft.unsure == () or not about(draft, "command")
    assert "as the model beside the log says" in draft.text()


def _moved(*moves, rests=None):
    """A log of moves from place to place, each at its speed and after a rest."""
    parts = []
    for (start, end, velocity), rest in zip(moves, rests or [200] * len(moves), strict=True):
        limits = {"velocity": velocity, "acceleration": 5.0, "jerk": 200.0, "dwell": 0.4}
        move = cogging.PointToPoint(cogging.PointToPointParameters(start=start, distance=end - start, **limits))
        parts += [np.full(rest, start), move.sample(np.arange(0.0, move.move_time + 0.2, 1e-3))[0]]
    x = np.concatenate(parts)
    return cogging.Log(1e-3 * np.arange(x.size), x, np.sin(40.0 * x), reference=x)


def test_one_move_is_no_move_there_and_back():
    draft = cogging.draft_model(_moved((0.1, 0.5, 0.4)))
    assert draft.motion.kind == "point_to_point"
    assert draft.motion.description.startswith("one move of 0.4 m, one way, 0.4 m/s")
    assert "there and back" not in draft.reference_text()
    assert draft.reference.sample(np.linspace(0.0, draft.log.time[-1], 500))[0][-1] == pytest.approx(0.5)
    stairs = cogging.draft_model(_moved((0.0, 0.1, 0.4), (0.1, 0.2, 0.4), (0.2, 0.3, 0.4)))
    assert stairs.motion.kind == "sampled"


@pytest.mark.parametrize("speeds", [(0.4, 0.36, 0.33, 0.36, 0.4)])
def test_moves_of_several_speeds_are_kept_as_samples(speeds):
    moves = [(0.0, 0.4, v) if i % 2 == 0 else (0.4, 0.0, v) for i, v in enumerate(speeds)]
    assert cogging.draft_model(_moved(*moves)).motion.kind == "sampled"
    same = cogging.draft_model(_moved(*((a, b, 0.4) for a, b, _ in moves)))
    assert same.motion.description.startswith("5 moves of 0.4 m there and back, 0.4 m/s")
    late = _moved(*((a, b, 0.4) for a, b, _ in moves), rests=[200, 200, 1500, 200, 200])
    assert cogging.draft_model(late).motion.kind == "sampled"


def _written(draft, folder):
    return draft.write(folder / "m.toml", folder / "r.toml")[0]


def test_counts_are_told_by_a_reference_of_a_stated_unit(tmp_path):
    motion = 0.1 * np.sin(3.0 * TIME)
    columns = [TIME, np.round(motion / 2.44140625e-7), RANDOM, 1e3 * motion]
    draft = cogging.draft_model(table(tmp_path / "a.csv", ["t", "encoder [counts]", "u", "soll [mm]"], columns))
    assert draft.scale["position"] == pytest.approx(2.44140625e-7, rel=1e-3)


def test_a_reference_of_the_other_sign_and_one_that_is_none(tmp_path):
    motion = 0.1 * np.sin(3.0 * TIME)
    other = table(tmp_path / "a.csv", ["t", "x", "u", "ref"], [TIME, motion, -motion, -motion])
    draft = cogging.draft_model(other)
    assert draft.scale["reference"] == -1.0
    none = table(tmp_path / "b.csv", ["t", "x", "u", "ref"], [TIME, motion, -motion, RANDOM])
    draft = cogging.draft_model(none)
    assert draft.log.reference is None
    assert any("the position does not follow it" in entry for entry in draft.unsure)


# Files and calls ------------------------------------------------------------------------------------------------------


def test_no_file_is_replaced_and_none_left_half(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    drawn = user_log(102, kind="sampled")
    (tmp_path / "a.csv").write_text(drawn.text)
    for taken in ("model.toml", "reference.toml", "reference.csv"):
        (tmp_path / taken).write_text("mine")
        assert main(["init", "a.csv"]) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert f"{taken}: must not exist yet" in said
        assert (tmp_path / taken).read_text() == "mine"
        (tmp_path / taken).unlink()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv"]
    assert main(["init", "a.csv", "--out", "a.csv"]) == 2
    assert main(["init", "a.csv", "--out", "x.toml", "--reference", "x.toml"]) == 2
    assert main(["init", "a.csv", "--zero", "position=1"]) == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv"]
    capsys.readouterr()
    assert main(["init", "a.csv", "--out", "x.toml", "--reference", "y.toml", "--json", "z.json"]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "x.toml", "y.csv", "y.toml", "z.json"]
    assert read_toml("y.toml")["file"] == "y.csv"


def test_what_the_owner_states_is_taken(tmp_path):
    motion = 0.1 * np.sin(3.0 * TIME)
    path = table(tmp_path / "a.csv", ["t", "x", "y", "u"], [TIME, motion, 2.0 * motion, -motion])
    draft = cogging.draft_model(path, columns={"position": "y"}, scale={"position": 0.5}, rows=slice(100, 1500))
    assert draft.columns.used["position"].label == "y"
    np.testing.assert_allclose(draft.log.position, motion[100:1500], atol=1e-15)
    assert draft.options() == [
        "--columns",
        "time=t,position=y,command=u",
        "--scale",
        "position=0.5",
        "--rows",
        "100:1500",
    ]
    with pytest.raises(InputError, match=r"column yy: must be in the header"):
        cogging.draft_model(path, columns={"position": "yy"})


@pytest.mark.parametrize("suffix", [".mat", ".parquet", ".csv"])
def test_other_formats(suffix, tmp_path):
    log = user_log(105).log
    log.write(tmp_path / f"a{suffix}")
    draft = cogging.draft_model(tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(draft.log.position, log.position)
    assert draft.options() == []
    in_memory = cogging.draft_model(log)
    assert in_memory.sizes.sizes == draft.sizes.sizes
    assert in_memory.columns is None
