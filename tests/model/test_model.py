"""Model and reference files: what is read, what is written, what is refused and how."""

import re
import textwrap

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cogging
from cogging.files import InputError
from cogging.model.model import CONTROLLERS
from tests.fixtures.model_files import BAD, CONTRACT


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
    assert model.axis.travel == [0.0, 0.51]
    assert model.uncertainty == {"mass": 0.03, "viscous": 0.2, "coulomb": 0.2}
    assert model.cogging.sine.shape == (3, 4)
    np.testing.assert_array_equal(model.cogging.cosine[1], [0.4, 0.3, 0.2, 0.1])
    assert [effect.NAME for effect in model.effects] == ["cable_spring", "disturbance_step"]
    assert model.effects[0].stiffness == 0.4
    assert model.effects[0].center == 0.0
    assert model.encoder.resolution == 0.5e-6
    assert model.noise.force == 0.01
    assert model.controller.kp == 9600.0
    assert model.controller.coulomb_width == 1.11e-3, "the axis' as first read"
    assert model.intervals == {"axis.mass": (0.118, 0.122)}


def test_written_and_read_again_is_the_same(write, tmp_path):
    model = cogging.Model.read(write(CONTRACT))
    model.write(tmp_path / "again.toml")
    again = cogging.Model.read(tmp_path / "again.toml")
    assert again.to_dict() == model.to_dict()
    x = np.linspace(0, 0.5, 50)
    np.testing.assert_array_equal(again.cogging.force(x), model.cogging.force(x))


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


def test_the_controllers_width_stays_when_the_axis_changes(write, tmp_path):
    model = cogging.Model.read(write(CONTRACT))
    changed = model.replace(axis=model.axis.replace(coulomb_width=0.01))
    changed.write(tmp_path / "changed.toml")
    assert cogging.Model.read(tmp_path / "changed.toml").controller.coulomb_width == 1.11e-3


@settings(derandomize=True, deadline=None, max_examples=60)
@given(
    mass=st.floats(1e-3, 1e3),
    viscous=st.floats(0, 1e3),
    periods=st.lists(st.floats(1e-3, 0.1), min_size=1, max_size=3, unique=True),
    points=st.integers(1, 5),
    effect=st.sampled_from(sorted(cogging.EFFECTS)),
    controller=st.sampled_from(sorted(CONTROLLERS)),
)
def test_round_trip_of_random_models(mass, viscous, periods, points, effect, controller):
    rows = np.random.default_rng(points).normal(size=(len(periods), points))
    basis = cogging.SplineHarmonics(pitch=0.05, periods=periods, order=1, origin=0.01, control_points=points)
    kind = CONTROLLERS[controller][0]
    adaptive = controller in ("arc", "dcarc")
    fields = {"mass_bounds": [mass / 2, mass * 2]} if adaptive else {}
    if controller not in ("output_feedback_arc", "observer_based"):
        fields["mass"] = mass
    model = cogging.Model(
        axis=cogging.AxisParameters(mass=mass, viscous=viscous),
        cogging=cogging.CoggingModel(basis, rows, -rows),
        effects=(cogging.EFFECTS[effect](),),
        controller=kind(**fields),
        controller_type=controller,
    )
    document = cogging.files.parse_toml(cogging.outputs.to_toml(model.to_dict()))
    again = cogging.Model.from_dict(document)
    assert again.to_dict() == model.to_dict()


def test_cogging_without_amplitudes_is_zero(write):
    model = cogging.Model.read(write("[axis]\nmass = 1.0\n[cogging]\npitch = 0.05\nharmonics = [1, 2]\n"))
    assert np.all(model.cogging.force(np.linspace(0, 0.1, 7)) == 0.0)


@pytest.mark.parametrize("case", sorted(BAD))
def test_a_bad_model_is_answered_in_one_line(case, write):
    text, message = BAD[case]
    with pytest.raises(ValueError, match=message) as caught:
        cogging.Model.read(write(text)).plant()
    assert "\n" not in str(caught.value)


def test_a_missing_file(tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.toml: cannot be read"):
        cogging.Model.read(tmp_path / "nowhere.toml")


def test_a_binary_file(tmp_path):
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="must be UTF-8 text"):
        cogging.Model.read(tmp_path / "binary.toml")


def test_references(write, tmp_path):
    motion, duration = cogging.read_reference(
        write(
            'type = "point_to_point"\nstart = 0.05\ndistance = 0.4\nvelocity = 0.5\nacceleration = 10\njerk = 1000\n'
            "dwell = 0.1\nrepeats = 3\n",
            "p.toml",
        )
    )
    assert isinstance(motion, cogging.PointToPoint)
    assert duration == 0.0
    assert motion.end == pytest.approx(3 * 2 * (0.4 / 0.5 + 0.05 + 0.01 + 0.1))
    motion, duration = cogging.read_reference(
        write('type = "sine"\ncenter = 0.1\namplitude = 0.05\nfrequency = 2.0\nduration = 3\n', "s.toml")
    )
    assert duration == 3.0
    assert motion.sample(np.array([0.125]))[0][0] == pytest.approx(0.15)
    t = np.linspace(0, 1, 101)
    rows = "\n".join(f"{a!r},{a * a!r}" for a in t.tolist())
    (tmp_path / "motion.csv").write_text(f"time,reference\n{rows}\n")
    motion, _ = cogging.read_reference(write('type = "sampled"\nfile = "motion.csv"\n', "d.toml"))
    position, velocity, acceleration = motion.sample(np.array([0.505]))
    assert position[0] == pytest.approx(0.505**2, abs=1e-12)
    assert velocity[0] == pytest.approx(1.01, abs=1e-9)
    assert acceleration[0] == pytest.approx(2.0, abs=1e-9)


BAD_REFERENCES = {
    "type": (
        'type = "circle"\n',
        r"r\.toml: line 1: type: must be one of point_to_point, sine, filtered_sine, sampled, got 'circle'",
    ),
    "unknown": ('type = "sine"\nduration = 1\nphase = 1\n', r"line 3: phase: is unknown"),
    "endless": ('type = "sine"\n', r"duration: must be given for a motion without an end"),
    "duration": ('type = "sine"\nduration = "long"\n', r"duration: must be a number of seconds"),
    "velocity": ('type = "point_to_point"\nvelocity = 0\n', r"velocity: must be finite and above 0, got 0"),
    "distance": ('type = "point_to_point"\ndistance = 0\n', r"distance: must be finite and not 0, got 0"),
    "repeats": ('type = "point_to_point"\nrepeats = 1.5\n', r"repeats: must be a whole number, got 1\.5"),
    "no file": ('type = "sampled"\n', r"file: must name a CSV file, got None"),
    "missing file": ('type = "sampled"\nfile = "no.csv"\n', r"no\.csv: cannot be read"),
}


@pytest.mark.parametrize("case", sorted(BAD_REFERENCES))
def test_a_bad_reference_is_answered_in_one_line(case, write):
    text, message = BAD_REFERENCES[case]
    with pytest.raises(ValueError, match=message):
        cogging.read_reference(write(text, "r.toml"))


FILLED = {
    "position_dependent_friction": {"nodes": [0, 0.1, 0.25], "levels": [0.1, -0.02, 1]},
    "empirical_force": {"velocity_nodes": [-0.1, 0.1], "velocity_forces": [0.2, -0.3]},
    "cogging_modulation": {"period": 0.05, "sine": [0.1, 0.2, 0.3], "cosine": [0, 0, 0.5]},
    "end_effect": {"force": 0.3, "decay_length": 0.02},
    "presliding_friction": {"stiffness": 1e5, "damping": 2},
    "backlash": {"gap": 1e-4, "mass_ratio": 0.3},
}


@pytest.mark.parametrize("name", sorted(cogging.EFFECTS))
def test_every_effect_comes_back_from_a_file(name, tmp_path):
    kind = cogging.EFFECTS[name]
    ordinary = {key: 0.0123 for key, value in kind().to_dict().items() if isinstance(value, float) and key != "stop"}
    made = kind(**FILLED.get(name, ordinary))
    assert made != kind()
    model = cogging.Model.from_dict(
        {
            "axis": {"mass": 1.0, "travel": [0.0, 0.1]},
            "cogging": {"pitch": 0.05, "harmonics": [1], "sine": [[0.1] * 3], "cosine": [[0.0] * 3]},
        }
    ).replace(effects=(made,))
    path = tmp_path / "m.toml"
    model.write(path)
    again = cogging.Model.read(path)
    assert again.effects == (made,)
    assert again.to_dict() == model.to_dict()
    assert again.plant().effects == [made]
    document = {**model.to_dict(), "effects": [{"name": name, "unheard_of": 1.0}]}
    with pytest.raises(ValueError, match=r"effects\.unheard_of: is unknown"):
        cogging.Model.from_dict(document)


def test_an_infinite_value_is_the_toml_word():
    text = '[axis]\nmass = 1.0\n[[effects]]\nname = "presliding_friction"\nstiffness = inf\n'
    (made,) = cogging.Model.from_dict(cogging.files.parse_toml(text)).effects
    assert made == cogging.EFFECTS["presliding_friction"]()
