"""`diagnose` and `identify` with effects of the user's own: tried beside the vocabulary, and treated as any of it."""

import re
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.candidates.signatures import candidates
from cogging.diagnosis.candidates.tables import tables
from cogging.diagnosis.candidates.waves import is_spatial_wave, is_wave
from cogging.diagnosis.evidence.null import fit_null
from cogging.effects import Custom
from cogging.effects.effect import VOCABULARY
from tests.fixtures.moving_axis import machine, record
from tests.fixtures.own_laws import COPIES, own_eddy, own_spring

ROOT = Path(__file__).parents[2]


def hidden_in(name):
    """A log in which an effect of the vocabulary acts, with fields that stand out."""
    fields = {
        "cable_spring": {"stiffness": 1.5, "center": 0.03},
        "quadratic_drag": {"coefficient": 4.0},
        "force_constant_ripple": {"period": 0.021, "sine": 0.03, "cosine": 0.0},
        "encoder_periodic_error": {"period": 0.021, "sine": 1e-5, "cosine": 1e-5},
        "position_dependent_friction": {"nodes": [0.0, 0.1, 0.2, 0.3], "levels": [0.2, -0.2, 0.2, 0.0]},
    }[name]
    return fields, record(machine([cogging.EFFECTS[name](**fields)]), 21)


@pytest.fixture(scope="module")
def quiet():
    return fit_null([record(machine(), 3)], machine())[1]


@pytest.mark.parametrize("name", sorted(COPIES))
def test_a_copy_is_looked_for_where_the_effect_is_and_shows_the_same(name, quiet):
    make, _ = COPIES[name]
    own, built_in = make().neutral(), VOCABULARY[name]
    assert is_wave(own) == is_wave(built_in)
    assert is_spatial_wave(own) == is_spatial_wave(built_in)
    if is_wave(own):
        return
    mine, its = list(candidates(quiet, own)), list(candidates(quiet, built_in))
    assert [one.shape for one in mine] == [one.shape for one in its]
    assert [one.amplitudes for one in mine] == [one.amplitudes for one in its]
    some = [0, len(its) // 2]
    for one, other in zip(tables(quiet, [mine[i] for i in some]), tables(quiet, [its[i] for i in some]), strict=True):
        size = max(np.abs(row).max() for row in other)
        np.testing.assert_allclose(one[0] / size, other[0] / size, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", sorted(COPIES))
def test_a_copy_explains_a_log_as_the_effect_does(name):
    make, _ = COPIES[name]
    _, log = hidden_in(name)
    evidence = fit_null([log], machine())[1]
    (mine, *_), (its, *_) = scan(evidence, [make().neutral()]), scan(evidence, [VOCABULARY[name]])
    assert mine.test.statistic == pytest.approx(its.test.statistic, rel=1e-6)
    assert mine.log_p_value < -9.5  # it stands out
    assert mine.score == pytest.approx(its.score, rel=1e-6)
    np.testing.assert_allclose(mine.amplitudes, its.amplitudes, rtol=1e-5)


def test_identify_fits_a_copy_as_the_effect():
    import numba

    law = numba.cfunc("float64(float64, float64, float64, float64, float64)")(
        lambda position, velocity, time, stiffness, center: stiffness * (center - position)
    )
    own = Custom("own_spring", force=law, parameters=own_spring()._definition.parameters)
    fields, log = hidden_in("cable_spring")
    fits = [
        cogging.identify(log, machine([one.replace(center=fields["center"])]))
        for one in (own, cogging.effects.CableSpring())
    ]
    for mine, its in zip(fits[0].parameters, fits[1].parameters, strict=True):
        assert mine.path.rpartition(".")[2] == its.path.rpartition(".")[2]
        assert mine.value == pytest.approx(its.value, rel=1e-5, abs=1e-12)
    (fitted,) = fits[0].model.effects
    assert fitted.same_definition(own)
    assert fitted.stiffness == pytest.approx(fields["stiffness"], rel=0.2)


def test_the_own_hypothesis_is_named_with_its_interval_and_rivals():
    """A spring of the user's own stands where the vocabulary has one as well: both names, neither for certain."""
    truth = record(machine([cogging.EFFECTS["cable_spring"](stiffness=1.5)]), 33)
    found = cogging.diagnose(truth, machine(), also=[own_spring()])
    names = {name for effect in found.effects for name in (effect.name, *effect.alternatives)}
    assert {"own_spring", "cable_spring"} <= names
    assert found.verdict == "ambiguous"
    assert found.separating_experiment
    assert "own spring" in found.html()


@pytest.mark.parametrize(
    ("also", "told"),
    [
        ([own_spring(), own_spring()], "effects: must have different names, got 'own_spring' twice"),
        ([cogging.effects.CableSpring()], "effects: must be made by cogging.effects.Custom, got CableSpring"),
        ([Custom("own_eddy", force=lambda velocity: velocity), "drag"], "must be made by cogging.effects.Custom"),
    ],
)
def test_what_cannot_be_tried_is_refused_before_anything_runs(also, told):
    with pytest.raises(ValueError, match=told):
        cogging.diagnose([], machine(), also=also)
    other = Custom("own_spring", force=lambda velocity: -velocity)
    with pytest.raises(ValueError, match="must be one law a name"):
        cogging.diagnose([], machine([own_spring()]), also=[other])


def test_a_law_that_fails_while_it_is_tried_comes_out():
    """A shape at which the law breaks down must not be taken for one that explains nothing."""

    def law(velocity, slope, corner):
        return -slope * velocity * (1.0 if corner > 0.1 else [][0])

    own = own_eddy()
    broken = Custom("broken", force=law, parameters=own._definition.parameters)
    with pytest.raises(RuntimeError, match=r"broken\.force: raised IndexError"):
        cogging.diagnose(record(machine(), 3), machine(), also=[broken])


def test_the_page_on_effects_of_your_own_runs_and_tells_the_truth():
    text = (ROOT / "docs" / "own_effect.md").read_text()
    space = {}
    for block in re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL):
        exec(block, space)
    without, found, truth = space["without"], space["found"], space["machine"].effects[0]
    assert f"print(without.verdict)  # {without.verdict}\n" in text
    assert without.verdict == "unlisted"
    assert "eddy_drag" not in without.text()
    assert found.verdict == "named"
    assert f"print(found.verdict)  # {found.verdict}\n" in text
    (effect,) = found.effects
    assert (effect.name, effect.alternatives) == ("eddy_drag", ())
    for name, parameter in effect.parameters.items():
        low, high = parameter.ci95
        assert low < getattr(truth, name) < high, name
        assert high - low < 0.4 * getattr(truth, name)
    (fitted,) = found.model.effects
    assert fitted.same_definition(truth)
    assert (
        found.gap.confirm_after < 0.8 * found.gap.confirm_before or without.gap.confirm_after > found.gap.confirm_after
    )
    assert "drag a metre a second" in found.html()
