"""Model and reference files, the numbers of a model by path, and its units; and the one line for a wrong one."""

import pickle
import re
import textwrap

import jsonschema
import numpy as np
import pytest

import cogging
from cogging import EFFECTS, AxisParameters, CoggingModel, Model, SplineHarmonics, parameters_of
from cogging.files import InputError, parse_toml
from cogging.model.model import CONTROLLERS
from cogging.model.parameters import Parameter, with_values
from tests.fixtures.covering import covering
from tests.fixtures.files import MODEL
from tests.fixtures.model_files import BAD, CONTRACT
from tests.fixtures.plants_by_hand import EXAMPLES
from tests.golden.logs import CONTROLLERS as FIELDS


@pytest.fixture
def write(tmp_path):
    def write_file(text, name="model.toml"):
        path = tmp_path / name
        path.write_text(textwrap.dedent(text))
        return path

    return write_file


def test_reads_what_the_contract_shows(write):
    model = cogging.Model.read(write(CONTRACT))
    assert model.axis.mass == 0.12
    assert model.uncertainty == {"mass": 0.03, "viscous": 0.2, "coulomb": 0.2}
    assert model.cogging.sine.shape == (3, 4)
    np.testing.assert_array_equal(model.cogging.cosine[1], [0.4, 0.3, 0.2, 0.1])
    assert [effect.NAME for effect in model.effects] == ["cable_spring", "disturbance_step"]
    assert model.effects[0].stiffness == 0.4
    assert model.encoder.resolution == 0.5e-6
    assert model.controller.coulomb_width == 1.11e-3, "the axis' as first read"
    assert model.intervals == {"axis.mass": (0.118, 0.122)}


def test_a_changed_model_keeps_the_comments_of_its_file(write, tmp_path):
    path = write(re.sub("(=.*)$", r"\1  # of this line", CONTRACT, flags=re.MULTILINE))
    text = path.read_text()
    model = cogging.Model.read(path)
    model.write(tmp_path / "same.toml", like=path)
    same = (tmp_path / "same.toml").read_text().splitlines()
    assert [line for line in text.splitlines() if line not in same] == []
    effects = [cogging.effects.ConstantForce(force=0.2), *model.effects[1:], cogging.effects.Gravity(moment=0.1)]
    changed = model.replace(
        axis=model.axis.replace(mass=0.5), effects=effects, controller=None, controller_type=None, intervals={}
    )
    changed.write(tmp_path / "changed.toml", like=path)
    kept = (tmp_path / "changed.toml").read_text()
    assert cogging.Model.read(tmp_path / "changed.toml") == changed
    assert re.search(r"^mass = 0\.5 +# of this line; was 0\.12$", kept, re.MULTILINE)
    assert re.search('^name = "constant_force" +# of this line; was "cable_spring"\nforce = 0.2$', kept, re.MULTILINE)
    path.write_text("axis.mass = 0.12  # a layout that is not followed\n")
    changed.write(tmp_path / "plain.toml", like=path)
    assert cogging.Model.read(tmp_path / "plain.toml") == changed


@pytest.mark.parametrize(("effect", "controller"), covering(sorted(cogging.EFFECTS), sorted(CONTROLLERS)))
def test_every_effect_and_controller_is_written_valid_and_read_again(effect, controller, tmp_path):
    rng = np.random.default_rng([*effect.encode(), *controller.encode()])
    terms, points = int(rng.integers(1, 4)), int(rng.integers(1, 6))
    waves = (
        {"periods": sorted(rng.uniform(1e-3, 0.1, terms))} if rng.random() < 0.5 else {"harmonics": [1, 4, 6][:terms]}
    )
    rows, order = rng.normal(size=(terms, points)), int(rng.integers(1, points + 1))
    basis = cogging.SplineHarmonics(pitch=0.05, order=order, origin=0.01, control_points=points, **waves)
    made = cogging.EFFECTS[effect](**EXAMPLES[effect][0])
    model = cogging.Model(
        axis=cogging.AxisParameters(mass=rng.uniform(0.01, 9.0), viscous=rng.uniform(), travel=[0.0, 0.5]),
        cogging=cogging.CoggingModel(basis, rows, -rows),
        effects=(made,),
        controller=CONTROLLERS[controller][0](**FIELDS[controller]),
        controller_type=controller,
        uncertainty={"mass": rng.random()},
        intervals={"axis.mass": [0.0, np.inf]},
        steps_per_sample=int(rng.integers(1, 9)),
    )
    assert pickle.loads(pickle.dumps(model)) == model != model.replace(steps_per_sample=10)
    model.write(tmp_path / "m.toml")
    again = cogging.Model.read(tmp_path / "m.toml")
    assert again == model
    assert again.plant().effects == [made]
    schema = cogging.schema()["$defs"]
    jsonschema.Draft202012Validator({"$ref": "#/$defs/model", "$defs": schema}).validate(
        parse_toml((tmp_path / "m.toml").read_text())
    )
    document = {**model.to_dict(), "effects": [{"name": effect, "unheard_of": 1.0}]}
    with pytest.raises(ValueError, match=r"effects\.unheard_of: is unknown"):
        cogging.Model.from_dict(document)


@pytest.mark.parametrize("case", sorted(BAD))
def test_a_wrong_model_is_one_line(case, write):
    text, message = BAD[case]
    with pytest.raises(ValueError, match=message) as caught:
        cogging.Model.read(write(text)).plant()
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read(tmp_path):
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    for name, message in (("nowhere", r"nowhere\.toml: cannot be read"), ("binary", "must be UTF-8 text")):
        with pytest.raises(InputError, match=message):
            cogging.Model.read(tmp_path / f"{name}.toml")


def test_references(write, tmp_path):
    path = write('type = "sine"\ncenter = 0.1\namplitude = 0.05\nfrequency = 2.0\nduration = 3\n', "s.toml")
    motion, duration = cogging.read_reference(path)
    assert duration == 3.0
    assert motion.sample(np.array([0.125]))[0][0] == pytest.approx(0.15)
    t = np.linspace(0, 1, 101)
    rows = "\n".join(f"{a!r},{a * a!r}" for a in t.tolist())
    (tmp_path / "motion.csv").write_text(f"time,reference\n{rows}\n")
    motion, _ = cogging.read_reference(write('type = "sampled"\nfile = "motion.csv"\n', "d.toml"))
    assert np.ravel(motion.sample(np.array([0.505]))) == pytest.approx([0.505**2, 1.01, 2.0], abs=1e-9)


BAD_REFERENCES = {
    "type": ('type = "circle"\n', r"r\.toml: line 1: type: must be one of point_to_point, .*, sampled, got 'circle'"),
    "unknown": ('type = "sine"\nduration = 1\nphase = 1\n', r"line 3: phase: is unknown"),
    "repeats": ('type = "point_to_point"\nrepeats = 1.5\n', r"repeats: must be a whole number, got 1\.5"),
    "missing file": ('type = "sampled"\nfile = "no.csv"\n', r"no\.csv: cannot be read"),
}


@pytest.mark.parametrize("case", sorted(BAD_REFERENCES))
def test_a_wrong_reference_is_one_line(case, write):
    text, message = BAD_REFERENCES[case]
    with pytest.raises(ValueError, match=message):
        cogging.read_reference(write(text, "r.toml"))


def test_every_unit_is_written_with_the_labels_of_the_machine():
    units = cogging.Units(command="Q", position="turn")
    structs = [*cogging.EFFECTS.values(), cogging.AxisParameters, cogging.EncoderParameters, cogging.NoiseParameters]
    known = {unit for struct in structs for unit, _ in struct.FIELDS.values() if unit}
    assert len(known) > 8
    known |= {"mV", "um", "1/m", "min", "ms"}
    for unit in known:
        assert cogging.Units().of(unit) == unit
        expected = re.sub(r"(?<![a-z])(u?)m(?![a-zA-Z])", r"\1turn", unit.replace("V", "Q"))
        assert units.of(unit) == expected


def test_a_model_file_keeps_its_labels(tmp_path):
    (tmp_path / "plain.toml").write_text(MODEL)
    model = cogging.Model.read(tmp_path / "plain.toml")
    assert model.units == cogging.Units() == cogging.Units("V", "m")
    assert "units" not in model.to_dict()
    rotary = model.replace(units=cogging.Units(command="Nm", position="rad"))
    rotary.write(tmp_path / "rotary.toml")
    assert cogging.Model.read(tmp_path / "rotary.toml") == rotary != model
    assert ("Nm/(rad/s^2)" in repr(rotary), "V/(m/s^2)" in repr(model)) == (True, True)


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ('[units]\ncommand = ""', "units.command: must be the label of a unit"),
        ('[units]\ncommand = "a unit of two words"', "units.command: must be the label of a unit"),
        ('[units]\nforce = "N"', "units.force: is unknown"),
        ('units = "A"', "units: must be a section"),
    ],
)
def test_a_wrong_label_is_one_line_and_invalid_by_the_schema(tmp_path, section, message):
    path = tmp_path / "model.toml"
    path.write_text(f"{section}\n{MODEL}" if section.startswith("units") else f"{MODEL}\n{section}\n")
    with pytest.raises(InputError, match=message) as error:
        cogging.Model.read(path)
    assert len(str(error.value).splitlines()) == 1
    document = cogging.schema()["$defs"]["model"]["properties"]["units"]
    entry = cogging.files.read_toml(path)["units"]
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(entry, document)


@pytest.fixture
def model():
    basis = SplineHarmonics(pitch=0.05, harmonics=[1, 2], control_points=3)
    return Model(
        axis=AxisParameters(mass=1.5, viscous=2.0, coulomb=0.7, coulomb_width=1e-3),
        cogging=CoggingModel(basis, np.arange(6.0).reshape(2, 3), -np.arange(6.0).reshape(2, 3)),
        effects=(
            EFFECTS["constant_force"](force=0.3),
            EFFECTS["cogging_harmonic"](period=0.024, sine=0.1),
            EFFECTS["position_dependent_friction"](nodes=[0.0, 0.2], levels=[0.1, -0.1]),
            EFFECTS["cogging_harmonic"](period=0.016, cosine=0.2),
            EFFECTS["command_saturation"](),
            EFFECTS["end_effect"](force=0.1, decay_length=0.01, travel=[0.0, 0.5]),
        ),
        uncertainty={"mass": 0.03},
    )


def test_every_number_has_a_path_that_with_values_follows(model):
    known = parameters_of(model)
    assert known["axis.mass"] == Parameter("axis.mass", 1.5, "V/(m/s^2)", 0.03)
    assert known["axis.coulomb"].uncertainty is None
    assert known["cogging.cosine[1][2]"].value == -5.0
    assert known["effects.cogging_harmonic[1].period"].value == 0.016
    assert known["effects.position_dependent_friction.levels[1]"].unit == "V"
    assert [path for path in known if path.endswith(("force", "limit"))] == [
        "effects.constant_force.force",
        "effects.command_saturation.limit",
        "effects.end_effect.force",
    ]
    for path in known:
        moved = parameters_of(with_values(model, {path: 0.123}))
        assert moved[path].value == 0.123
        assert {p: v for p, v in moved.items() if p != path} == {p: v for p, v in known.items() if p != path}


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("axis.weight", 1.0, "axis.weight: must be a parameter of the model"),
        ("effects.cable_spring.stiffness", 1.0, "effects.cable_spring.stiffness: must be a parameter"),
        ("effects.cogging_harmonic.period", 1.0, "must be a parameter"),  # there are two
        ("cogging.sine", 1.0, "cogging.sine: must be a parameter"),
        ("effects.position_dependent_friction.levels[x]", 1.0, "must be a parameter"),
        ("axis.mass", -1.0, "mass"),
        ("effects.cogging_harmonic[0].period", 0.0, "period"),
    ],
)
def test_a_wrong_path_or_value_is_named(model, path, value, message):
    with pytest.raises(ValueError, match=message):
        with_values(model, {path: value})
