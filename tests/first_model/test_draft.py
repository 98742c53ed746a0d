"""First models of drawn and measured logs: right, or marked as not identifiable; and the next command runs."""

import math
import random
import re
import shlex
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import cogging
from cogging.cli.main import main
from cogging.datasets import emps
from cogging.files import InputError, read_toml
from cogging.first_model.headers import header_of
from tests.fixtures.command_files import table
from tests.fixtures.measured import FOLDER
from tests.fixtures.pid_axis import MODEL

LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
#: Headers by style: time, position, command, reference; % stands for the unit.
STYLES = (
    ("time [%]", "position [%]", "command [%]", "reference [%]"),
    ("t (%)", "x (%)", "Iq (%)", "x_ref (%)"),
    ("Zeit [%]", "Istposition [%]", "Motorstrom [%]", "Sollposition [%]"),
    ("t_%", "pos_%", "force_%", "ref_%"),
    ("Zeit / %", "Lage / %", "Kraft / %", "Sollwert / %"),
    ("Time in %", "Actual position in %", "Current in %", "Target position in %"),
)
BARE = (("time", "position", "command", "reference"), ("t", "qm", "vir", "qg"), ("Zeit", "Weg", "Strom", "Soll"))


def axis(draw, rate, length, seconds):
    """An axis under a PID, its friction and cogging of the size of its inertia's force."""
    mass = math.exp(draw.uniform(math.log(1e-4), math.log(1e3)))
    speed = 2.0 * length / seconds
    force = mass * speed / (0.25 * seconds)
    pole = 2.0 * math.pi * 0.02 * rate
    kp, ki, kd = cogging.pid_gains([-pole] * 3, mass)
    friction = {"viscous": draw.uniform(0.05, 0.6) * force / speed, "coulomb": draw.uniform(0.05, 0.6) * force}
    friction |= {"mass": mass, "coulomb_width": 0.01 * speed}
    pitch, size = length / draw.uniform(4.0, 12.0), draw.choice([0.0, draw.uniform(0.02, 0.3)]) * force
    quantum = float(f"{length / 10.0 ** draw.uniform(4.0, 6.0):.2g}")
    return cogging.Model(
        axis=cogging.AxisParameters(**friction),
        cogging=cogging.CoggingModel(cogging.SplineHarmonics(pitch=pitch, harmonics=[1]), [[size]], [[0.0]]),
        encoder=cogging.EncoderParameters(resolution=quantum),
        noise=cogging.NoiseParameters(force=0.003 * force, bandwidth=0.05 * rate),
        controller=cogging.PidParameters(sample_rate=rate, kp=kp, ki=ki, kd=kd, **friction),
        controller_type="pid",
    )


def motion(draw, kind, length, seconds):
    """Type and fields of a reference, and how long it lasts."""
    speed = 2.0 * length / seconds
    if kind == "point_to_point":
        acceleration = speed / (draw.uniform(0.15, 0.3) * seconds)
        fields = {"start": draw.uniform(-1.0, 1.0) * length, "distance": draw.choice([-1.0, 1.0]) * length}
        fields |= {"velocity": speed, "acceleration": acceleration, "jerk": acceleration / (0.05 * seconds)}
        fields |= {"dwell": 0.3 * seconds, "repeats": draw.randrange(2, 4)}
        return fields, 0.0
    if kind == "sine":
        fields = {"center": draw.uniform(-1.0, 1.0) * length, "amplitude": 0.5 * length}
        return fields | {"frequency": 0.5 / seconds}, 8.0 * seconds
    time = np.arange(1201) * (8.0 * seconds / 1200)
    goals = np.array([draw.uniform(0.0, length) for _ in range(14)])
    knots = np.linspace(0.0, time[-1], len(goals))
    return {"time": time.tolist(), "reference": PchipInterpolator(knots, goals)(time).tolist()}, float(time[-1])


def written(value, comma):
    text = f"{value:.12g}"
    return text.replace(".", ",") if comma else text


def user_log(seed, kind=None):
    """A drawn log as text, and what is true of it."""
    draw = random.Random(seed)
    rate = draw.choice([100.0, 500.0, 1000.0, 2000.0, 5000.0, 20000.0])
    length = math.exp(draw.uniform(math.log(2e-3), math.log(1.0)))
    seconds = max(30.0 / (2.0 * math.pi * 0.02 * rate), 0.12) * draw.uniform(1.0, 2.0)
    model = axis(draw, rate, length, seconds)
    kind = kind or draw.choice(["point_to_point", "sine", "sampled"])
    fields, duration = motion(draw, kind, length, seconds)
    reference = {"type": kind, **fields} | ({"duration": duration} if duration else {})
    log = cogging.simulate(model, reference, seed=seed)
    stated = draw.random() < 0.7
    style = draw.choice(STYLES if stated else BARE)
    units = [draw.choice(list(TIMES)), draw.choice(list(LENGTHS)), draw.choice("VAN")]
    has_reference, flipped = draw.random() < 0.6, draw.random() < 0.3
    headers = [label.replace("%", unit) for label, unit in zip(style, [*units, units[1]], strict=True)]
    factors = [TIMES[units[0]], LENGTHS[units[1]], -1.0 if flipped else 1.0, LENGTHS[units[1]]]
    names = ("time", "position", "command", "reference")[: 3 + has_reference]
    kept = np.ones(len(log), dtype=bool)
    if draw.random() < 0.4:
        kept[1:-1] = np.random.default_rng(seed).random(len(log) - 2) > 0.004
    time = log.time + draw.choice([0.0, 3.001])
    if draw.random() < 0.4:
        time = time + np.random.default_rng(seed).uniform(-0.02, 0.02, len(time)) / rate
    comma = draw.random() < 0.3
    columns = zip(names, headers, factors, (time, log.position, log.command, log.reference), strict=False)
    text = [
        [header, *(written(value, comma) for value in (column[kept] / factor).tolist())]
        for _, header, factor, column in columns
    ]
    draw.shuffle(text)
    separator = ";" if comma else draw.choice([",", ";", "\t"])
    if draw.random() < 0.5:
        text.append(["Temperatur", *[written(31.5, comma)] * int(kept.sum())])
    return SimpleNamespace(
        text="\n".join(separator.join(row) for row in zip(*text, strict=True)) + "\n",
        model=model,
        motion=kind,
        fields=fields,
        headers=dict(zip(names, headers, strict=False)),
        factors=dict(zip(names, factors, strict=False)),
        command_unit=units[2] if stated else "V",
        stated=stated,
        dropped=int((~kept).sum()),
        log=log,
    )


TIME = np.arange(2000) * 1e-3
WAVE = np.sin(3.0 * TIME)
RANDOM = np.random.default_rng(3).standard_normal(2000)


@pytest.fixture(scope="module")
def drafts(tmp_path_factory):
    """Drawn logs, their drafts, and the draft's unit of position over the true one."""
    path, made = tmp_path_factory.mktemp("logs") / "log.csv", []
    for seed in range(100, 114):
        drawn = user_log(seed)
        path.write_text(drawn.text)
        draft = cogging.draft_model(path)
        made.append((drawn, draft, draft.scale.get("position", 1.0) / drawn.factors["position"]))
    return made


def about(draft, word):
    return [entry for entry in (*draft.unsure, *draft.likely) if entry.startswith(word)]


def next_words(printed):
    """The words of the next command in an output."""
    following = printed.splitlines()[-1]
    assert following.startswith("next: cogging ")
    return shlex.split(following.removeprefix("next: cogging "))


# Drawn logs -----------------------------------------------------------------------------------------------------------


def test_columns_and_units_are_right_or_marked_as_guessed(drafts):
    right = []
    for drawn, draft, unit in drafts:
        for name, header in drawn.headers.items():
            assert draft.columns.used[name].label == header
            right.append(math.isclose(draft.scale.get(name, 1.0), drawn.factors[name], rel_tol=1e-6))
            assert right[-1] or (not drawn.stated and about(draft, name)), (header, draft.scale)
            assert drawn.stated or about(draft, "position")
        assert ("reference" in draft.columns.used) == ("reference" in drawn.headers)
        assert draft.units.command == drawn.command_unit
        quantum = drawn.model.encoder.resolution
        assert abs(np.ptp(draft.log.position) / unit - np.ptp(drawn.log.position)) < 2.0 * quantum
        assert (draft.scale.get("command", 1.0) < 0.0) == (drawn.factors["command"] < 0.0)
        rate = draft.audit.rate * draft.scale.get("time", 1.0) / drawn.factors["time"]
        assert rate == pytest.approx(drawn.model.controller.sample_rate, rel=0.02)
        assert draft.audit.encoder_quantum / unit == pytest.approx(quantum, rel=0.01)
        assert len(drawn.log) - len(draft.log) == drawn.dropped
        assert (draft.audit.gaps > 0) == (drawn.dropped > 0)
    assert np.mean(right) > 0.9


def test_mass_and_friction_are_within_their_uncertainty(drafts):
    known = dict.fromkeys(("mass", "viscous", "coulomb"), 0)
    for drawn, draft, unit in drafts:
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


def test_motion_and_cogging_are_recognised(drafts):
    right = seen = 0
    for drawn, draft, unit in drafts:
        assert draft.motion.kind == drawn.motion
        factors = dict.fromkeys(("distance", "amplitude", "velocity", "acceleration"), unit)
        for name, factor in (factors | {"dwell": 1.0, "frequency": 1.0}).items():
            if name in draft.motion.fields:
                assert draft.motion.fields[name] == pytest.approx(factor * drawn.fields[name], rel=0.15), name
        if draft.wave is not None:
            seen += 1
            assert drawn.model.cogging.sine[0, 0] > 0.0
            right += abs(draft.wave.period / (unit * drawn.model.cogging.basis.pitch) - 1.0) < 0.03
    assert right >= 0.8 * seen > 0
    strong = [draft for drawn, draft, _ in drafts if drawn.model.cogging.sine[0, 0] > 0.3 * drawn.model.axis.coulomb]
    assert sum(draft.wave is not None for draft in strong) >= 0.6 * len(strong) > 0


def test_the_files_are_read_back_also_with_all_proposals_accepted(drafts, tmp_path):
    """A single # before a line marks a proposal, [controller] and [cogging] included."""
    for k, (_, draft, _) in enumerate(drafts):
        model, reference, accepted = (tmp_path / f"{k}_{name}.toml" for name in ("model", "motion", "accepted"))
        draft.write(model, reference)
        assert cogging.Model.read(model) == draft.model
        assert draft.model.units == draft.units
        assert draft.model.axis.mass == pytest.approx(draft.sizes.sizes["mass"].value, rel=1e-3)
        motion, duration = cogging.read_reference(reference)
        times = draft.log.time - draft.log.time[0]
        seen = draft.log.position if draft.log.reference is None else draft.log.reference
        if draft.motion.kind != "sine":  # whose phase a reference file does not hold
            off = np.asarray(motion.sample(times)[0]) - seen
            assert np.sqrt(np.mean(off**2)) < 0.1 * np.ptp(seen)
        assert duration == 0.0 or duration == pytest.approx(times[-1])
        accepted.write_text("\n".join(line.removeprefix("# ") for line in draft.model_text().splitlines()))
        full = cogging.Model.read(accepted)
        assert full.axis == draft.model.axis
        assert full.controller.kp > 0.0
        pitch = full.cogging.basis.pitch
        assert pitch == pytest.approx(draft.wave.period, rel=1e-3) if draft.wave else pitch > 0.0


# Columns and units ----------------------------------------------------------------------------------------------------


@pytest.fixture
def draft_of(tmp_path, monkeypatch):
    """The draft of a table with these labels and columns in a file a.csv of the current folder."""
    monkeypatch.chdir(tmp_path)

    def draft(labels, values, **options):
        table(tmp_path / "a.csv", dict(zip(labels, values, strict=True)))
        return cogging.draft_model("a.csv", **options)

    return draft


def test_columns_without_telling_names_are_known_by_how_they_behave(draft_of):
    draft = draft_of(["ch1", "ch2", "ch3"], [-0.9 * WAVE + 0.05 * RANDOM, TIME, 0.1 * WAVE])
    found = {name: guess.label for name, guess in draft.columns.used.items()}
    assert found == {"time": "ch2", "position": "ch3", "command": "ch1"}
    assert all(about(draft, name) for name in found)


UNKNOWN = [
    (["t", "ch1", "ch2"], [TIME, np.sin(TIME), np.cos(TIME)], "column position: cannot be .* 'ch1', 'ch2'"),
    (["t", "speed", "Iq"], [TIME, RANDOM, RANDOM], "column position: .*'speed' looks like a velocity"),
    (["0.0", "1.0", "2.0"], [TIME, WAVE, RANDOM], "line 1: must be a header row with the names of the columns"),
    (["a", "b"], [["x", "u"], ["y", "v"]], "column time: cannot be identified among none"),
]


@pytest.mark.parametrize(("labels", "columns", "rule"), UNKNOWN)
def test_a_column_that_cannot_be_identified_is_asked_for_in_one_line(labels, columns, rule, draft_of, capsys, tmp_path):
    with pytest.raises(InputError, match=rule):
        draft_of(labels, columns)
    assert main(["init", "a.csv"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "--columns " in error or "line 1" in error
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def test_at_rest_nothing_is_claimed_and_an_audit_comes_next(draft_of, capsys):
    draft = draft_of(["time", "position", "command"], [TIME, np.full(2000, 0.25), 0.01 * RANDOM])
    assert draft.motion.kind == "rest"
    assert all(size.uncertainty is None for size in draft.sizes.sizes.values())
    assert main(["init", "a.csv"]) == 0
    words = next_words(capsys.readouterr().out)
    assert words[0] == "audit"
    assert main(words) == 0


#: Labels of position and command, factor of the position, units of position and command.
UNITS = [
    ("pos [counts]", "torque [Nm]", 1e-6, "m", "Nm"),
    ("theta (rad)", "torque [Nm]", 1.0, "rad", "Nm"),
    ("x [inch]", "torque [Nm]", 0.0254, "m", "Nm"),
    ("position", "torque", 1.0, "rad", "Nm"),
    ("position [mm]", "torque", 1e-3, "m", "V"),
]


@pytest.mark.parametrize(("label", "torque", "factor", "position", "command"), UNITS)
def test_units_are_those_of_the_headers_in_every_text(label, torque, factor, position, command, draft_of):
    """An axis that turns is measured in rad and Nm."""
    is_counted = "counts" in label
    draft = draft_of(["time", label, torque], [TIME, np.round(2e4 * WAVE) if is_counted else WAVE / factor, RANDOM])
    assert draft.scale.get("position", 1.0) == pytest.approx(factor)
    assert draft.units.command == command
    assert is_counted or draft.units.position == position
    assert any("counts of an encoder" in entry for entry in draft.unsure) == is_counted
    if position == "rad":
        texts = draft.text() + draft.model_text() + draft.reference_text()
        assert not re.search(r"[\d\]] [mu]?[mV]\b|[mV]/\(?m|\bm/s|# [mV];", texts)
    assert cogging.Model.read(draft.write("m.toml", "r.toml")[0]).units == draft.units


def test_a_simulated_log_is_drafted_in_the_units_of_its_model(tmp_path):
    model = MODEL.replace(units=cogging.Units(command="A", position="rad"))
    motion = {"type": "sine", "center": 0.2, "amplitude": 0.05, "frequency": 2.0, "duration": 1.0}
    log = cogging.simulate(model, motion)
    log.write(tmp_path / "a.csv")
    for draft in (cogging.draft_model(log), cogging.draft_model(tmp_path / "a.csv")):
        assert draft.units == model.units
        assert draft.unsure == () or not about(draft, "command")
    assert "as the model beside the log says" in draft.text()


def test_a_reference_gives_the_count_and_is_checked_against_the_position(draft_of):
    motion = 0.1 * WAVE
    counts = np.round(motion / 2.44140625e-7)
    draft = draft_of(["t", "encoder [counts]", "u", "soll [mm]"], [TIME, counts, RANDOM, 1e3 * motion])
    assert draft.scale["position"] == pytest.approx(2.44140625e-7, rel=1e-3)
    assert draft_of(["t", "x", "u", "ref"], [TIME, motion, -motion, -motion]).scale["reference"] == -1.0
    draft = draft_of(["t", "x", "u", "ref"], [TIME, motion, -motion, RANDOM])
    assert draft.log.reference is None
    assert any("the position does not follow it" in entry for entry in draft.unsure)


def test_stated_columns_scales_and_rows_are_used(draft_of):
    stated = {"columns": {"position": "y"}, "scale": {"position": 0.5}, "rows": slice(100, 1500)}
    draft = draft_of(["t", "x", "y", "u"], [TIME, WAVE, 2.0 * WAVE, -WAVE], **stated)
    assert draft.columns.used["position"].label == "y"
    np.testing.assert_allclose(draft.log.position, WAVE[100:1500], atol=1e-15)
    assert " ".join(draft.options()) == "--columns time=t,position=y,command=u --scale position=0.5 --rows 100:1500"
    with pytest.raises(InputError, match=r"column yy: must be in the header"):
        cogging.draft_model("a.csv", columns={"position": "yy"})


#: Kind and unit of each label.
LABELS = {
    "Zeit in s": ("time", "s"),
    "t_ms": ("time", "ms"),
    "Time [us]": ("time", "us"),
    "Istposition / mm": ("position", "mm"),
    "pos_um": ("position", "um"),
    "Axis 1 Position Actual Value": ("position", ""),
    "theta [deg]": ("position", "deg"),
    "Actual position [counts]": ("position", "counts"),
    "x_A": ("position", ""),  # an axis called A, not amperes
    "x [mm/s]": ("velocity", "mm/s"),
    "Drehzahl [1/min]": ("velocity", "1/min"),
    "Motorstrom / A": ("command", "A"),
    "Stellgröße [V]": ("command", "V"),
    "torque [%]": ("command", "%"),
    "force (filtered)": ("command", ""),
    "Sollposition [mm]": ("reference", "mm"),
    "Reference Velocity": ("reference_velocity", ""),
    "Error Position": ("error", ""),
    "Temperatur": ("", ""),
    "kp": ("", ""),
    "": ("", ""),
    # A pattern that looks at each pair of their blanks needs minutes to years.
    "x" + " " * 200_000 + "[mm]": ("position", "mm"),
    "x" + " in" * 70_000 + "(": ("position", ""),
    "[" * 200_000: ("", ""),
}


@pytest.mark.parametrize("label", LABELS, ids=lambda label: label[:30])
def test_kind_and_unit_of_a_label(label):
    header = header_of(label)
    assert (header.kind, header.unit, header.label) == (*LABELS[label], label)


@pytest.mark.parametrize("unit", ["mm", "V", "ms"])
def test_a_unit_apart_from_the_name_counts_where_the_name_has_none(unit):
    assert header_of("ch1", unit).unit == unit
    assert header_of("ch1 [A]", unit).unit == "A"


def moves(*moves, rests=None):
    """The draft of a log of moves from place to place, each at its speed and after a rest."""
    parts = []
    for (start, end, velocity), rest in zip(moves, rests or [200] * len(moves), strict=True):
        limits = {"velocity": velocity, "acceleration": 5.0, "jerk": 200.0, "dwell": 0.4}
        move = cogging.PointToPoint(cogging.PointToPointParameters(start=start, distance=end - start, **limits))
        parts += [np.full(rest, start), move.sample(np.arange(0.0, move.move_time + 0.2, 1e-3))[0]]
    x = np.concatenate(parts)
    return cogging.draft_model(cogging.Log(1e-3 * np.arange(x.size), x, np.sin(40.0 * x), reference=x)).motion


def test_one_move_many_alike_and_others_that_are_kept_as_samples():
    same = [(0.0, 0.4, 0.4), (0.4, 0.0, 0.4)] * 2 + [(0.0, 0.4, 0.4)]
    assert moves((0.1, 0.5, 0.4)).description.startswith("one move of 0.4 m, one way, 0.4 m/s")
    assert moves(*same).description.startswith("5 moves of 0.4 m there and back, 0.4 m/s")
    assert moves((0.0, 0.1, 0.4), (0.1, 0.2, 0.4), (0.2, 0.3, 0.4)).kind == "sampled"
    slower = [(start, end, speed) for (start, end, _), speed in zip(same, (0.4, 0.36, 0.33, 0.36, 0.4), strict=True)]
    assert moves(*slower).kind == "sampled"
    assert moves(*same, rests=[200, 200, 1500, 200, 200]).kind == "sampled"


def test_no_file_is_replaced(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text(user_log(102, kind="sampled").text)
    for taken in ("model.toml", "reference.toml", "reference.csv"):
        (tmp_path / taken).write_text("mine")
        assert main(["init", "a.csv"]) == 2
        assert f"{taken}: must not exist yet" in capsys.readouterr().err
        assert (tmp_path / taken).read_text() == "mine"
        (tmp_path / taken).unlink()
    assert main(["init", "a.csv", "--out", "x.toml", "--reference", "y.toml"]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "x.toml", "y.csv", "y.toml"]
    assert read_toml("y.toml")["file"] == "y.csv"


@pytest.mark.data
def test_emps(tmp_path, monkeypatch, capsys):
    draft = cogging.draft_model(emps.files(FOLDER)["DATA_EMPS_PULSES"])
    assert draft.columns.columns == {"time": "t", "position": "qm", "command": "vir", "reference": "qg"}
    assert draft.scale == {}
    assert draft.motion.kind == "sampled"
    assert draft.audit.rate == pytest.approx(1000.0, rel=1e-3)
    for path in ("axis.mass", "axis.viscous", "axis.coulomb"):
        size = draft.sizes.sizes[path.partition(".")[2]]
        published = emps.PUBLISHED[path] / emps.FORCE_CONSTANT  # the command is in V
        assert size.value == pytest.approx(published, rel=0.1)
        assert abs(size.value / published - 1.0) < 2.0 * size.uncertainty
    assert -35.15065 * draft.sizes.offset == pytest.approx(3.16, abs=0.3)
    monkeypatch.chdir(tmp_path)
    assert main(["init", str(emps.files(FOLDER)["DATA_EMPS"]), "--rows", "0:9000"]) == 0
    words = next_words(capsys.readouterr().out)
    assert "--rows" in words
    assert main(words) == 0
    assert cogging.Model.read("fitted.toml").axis.mass == pytest.approx(95.11 / emps.FORCE_CONSTANT, rel=0.03)


def test_a_column_of_text_or_with_a_hole_is_left_out(tmp_path):
    t = np.arange(600) * 1e-3
    columns = [t, ["run"] * 600, 100.0 * np.sin(5.0 * t), ["", *range(599)], np.cos(5.0 * t)]
    rows = [",".join(map(str, row)) for row in zip(*columns, strict=True)]
    (tmp_path / "log.csv").write_text("\n".join(["Zeit [s],state,Istposition [mm],hole,Strom [A]", *rows, ""]))
    draft = cogging.draft_model(tmp_path / "log.csv")
    assert draft.columns.unused == ("state", "hole")
    assert draft.columns.scale == {"position": 1e-3}
