"""Where a found effect acts: along what its law is a function of, and nowhere else."""

import numpy as np
import pytest

import cogging
from cogging.diagnosis.naming.effect_range import COORDINATES, depends_on, where_of
from cogging.effects.effect import VOCABULARY
from tests.fixtures.laws_by_symbol import SHAPED, of_the_law
from tests.fixtures.own_laws import drag, ripple, spring
from tests.golden.logs import EFFECTS


@pytest.mark.parametrize("name", [name for name in VOCABULARY if set(VOCABULARY[name].HOOKS) & set(SHAPED)])
def test_an_effect_acts_along_what_stands_in_its_formula(name, quiet_evidence):
    """A spring along the position, whatever the motion was; drag along the velocity; a step along the time."""
    effect = VOCABULARY[name].replace(**EFFECTS[name])
    if name == "position_dependent_friction":
        effect = effect.replace(nodes=[0.0, 0.1, 0.2, 0.5])
    if name == "disturbance_step":
        effect = effect.replace(start=0.3, stop=0.9)
    if name == "end_effect":
        effect = effect.replace(travel=[-0.3, 0.8])
    told = where_of(effect, quiet_evidence)
    assert told["coordinate"] in of_the_law(effect), told
    assert told["range"][0] <= told["range"][1]


@pytest.mark.parametrize(
    ("law", "values", "coordinates"),
    [
        (spring, {"stiffness": 3.0, "center": 0.1}, ["position"]),
        (ripple, {"period": 0.02, "sine": 0.1, "cosine": 0.2}, ["position"]),
        (drag, {"coefficient": 2.0}, ["velocity"]),
        (lambda time: np.sin(time), {}, ["time"]),
        (lambda position, velocity: position * velocity, {}, ["position", "velocity"]),
        (lambda position: 0.0 * position + 3.0, {}, []),
    ],
)
def test_what_a_law_depends_on_is_found_by_holding_it(law, values, coordinates):
    generator = np.random.default_rng(0)
    rows = {name: generator.uniform(-1.0, 2.0, 500) for name in COORDINATES}
    taken = law.__code__.co_varnames[: law.__code__.co_argcount]

    def asked(**given):
        return law(**{name: given[name] for name in given if name in taken}, **values)

    assert depends_on(asked, rows) == coordinates


def test_a_found_spring_acts_along_the_position(quiet_evidence):
    """Also one so far from its centre that it hardly changes on the way."""
    for center in (0.0, 0.2, 5.0):
        spring_far = cogging.effects.CableSpring(stiffness=1.0, center=center)
        assert where_of(spring_far, quiet_evidence)["coordinate"] == "position"


def test_an_effect_that_pushes_nowhere_in_these_rows_still_acts_along_its_own_coordinate(quiet_evidence):
    step = cogging.effects.DisturbanceStep(force=1.0, start=1e6, stop=2e6)
    told = where_of(step, quiet_evidence)
    assert told["coordinate"] in ("position", "time")
    assert told["range"][0] < told["range"][1]
    friction = cogging.effects.CoulombAsymmetry(difference=0.0)
    assert where_of(friction, quiet_evidence)["range"][0] < where_of(friction, quiet_evidence)["range"][1]
