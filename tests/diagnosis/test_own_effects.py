"""`diagnose` and `identify` with effects of the user's own: tried beside the vocabulary, and treated as any of it."""

import re
from pathlib import Path

import pytest

import cogging
from cogging.effects import Custom
from tests.fixtures.moving_axis import machine, record
from tests.fixtures.own_laws import COPIES, own_eddy, own_spring

ROOT = Path(__file__).parents[2]


def hidden_in(name):
    """A log in which an effect of the vocabulary acts, with fields that stand out."""
    fields = {
        "cable_spring": {"stiffness": 1.5, "center": 0.03},
        "quadratic_drag": {"coefficient": 8.0},  # twice what this motion shows with a chance of 95 %
        "force_constant_ripple": {"period": 0.021, "sine": 0.03, "cosine": 0.0},
        "encoder_periodic_error": {"period": 0.021, "sine": 1e-5, "cosine": 1e-5},
        "position_dependent_friction": {"nodes": [0.0, 0.1, 0.2, 0.3], "levels": [0.2, -0.2, 0.2, 0.0]},
    }[name]
    return fields, record(machine([cogging.EFFECTS[name](**fields)]), 21)


#: The others are a longer study; a force of a user's own is in docs/own_effect.md, below.
SOME = {"encoder_periodic_error"}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.study] * (name not in SOME)) for name in sorted(COPIES)]
)
def test_a_copy_explains_a_log_as_the_effect_does(name):
    """Of a hidden effect of the vocabulary, a user's copy of it is among the names, or stands for it."""
    make, _ = COPIES[name]
    fields, log = hidden_in(name)
    found = cogging.diagnose(log, machine(), also=[make()])
    names = {one for effect in found.effects for one in (effect.name, *effect.alternatives)}
    assert names & {make().NAME, name}, found.text()
    assert make().NAME in found.limits
    if name == "cable_spring":
        effect = found.effects[0]
        low, high = effect.parameters["stiffness"].ci95
        assert low < fields["stiffness"] < high
        assert effect.name.replace("_", " ") in found.html()


def test_identify_fits_a_copy_as_the_effect():
    import numba

    law = numba.cfunc("float64(float64, float64, float64, float64, float64)")(
        lambda position, velocity, time, stiffness, center: stiffness * (center - position)
    )
    own = Custom("own_spring", force=law, parameters=own_spring()._definition.parameters)
    fields, log = hidden_in("cable_spring")
    fits = [
        cogging.identify(log[:2001], machine([one.replace(center=fields["center"])]))
        for one in (own, cogging.effects.CableSpring())
    ]
    for mine, its in zip(fits[0].parameters, fits[1].parameters, strict=True):
        assert mine.path.rpartition(".")[2] == its.path.rpartition(".")[2]
        assert mine.value == pytest.approx(its.value, rel=1e-5, abs=1e-12)
    (fitted,) = fits[0].model.effects
    assert fitted.same_definition(own)
    assert fitted.stiffness == pytest.approx(fields["stiffness"], rel=0.2)


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

    broken = Custom("broken", force=law, parameters=own_eddy()._definition.parameters)
    with pytest.raises((RuntimeError, ValueError), match=r"broken\.force: raised IndexError"):
        cogging.diagnose(record(machine(), 3), machine(), also=[broken])


def test_the_page_on_effects_of_your_own_runs_and_tells_the_truth():
    text = (ROOT / "docs" / "own_effect.md").read_text()
    space = {}
    for block in re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL):
        exec(block, space)
    without, found, truth = space["without"], space["found"], space["machine"].effects[0]
    assert f"print(without.verdict)  # {without.verdict}\n" in text
    assert without.verdict == "unlisted"
    assert "added" not in without.unlisted  # an empirical force is added only where it is asked for
    assert "empirical_force" not in [effect.NAME for effect in without.model.effects]
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
