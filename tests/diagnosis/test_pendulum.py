"""A pendulum that other people measured: gravity makes most of its torque, which the model lacks."""

import numpy as np
import pytest

import cogging
from tests.fixtures.measured import FOLDER, needs

pytestmark = pytest.mark.data

UNITS = cogging.Units(command="Nm", position="rad")


@pytest.fixture(scope="module", params=[0.1, 0.3], ids=["mass known to 10 %", "to 30 %"])
def result(request):
    needs("pendulum")
    model = cogging.Model(
        axis=cogging.AxisParameters(mass=0.147, viscous=0.05, coulomb=0.1),
        uncertainty={"mass": request.param, "viscous": 1.0, "coulomb": 1.0},
        units=UNITS,
    )
    log, confirm = (
        cogging.read_log(FOLDER / "pendulum" / f"{name}.csv", columns={"command": "torque"})
        for name in ("ddp", "direct_collocation")
    )
    found = cogging.diagnose(log, model, confirm=confirm)
    print("\n" + found.text())
    return found


def test_gravity_is_named_first_with_its_moment(result):
    first = result.effects[0]
    assert (first.name, first.alternatives) == ("gravity", ())
    moment, angle = (first.parameters[name] for name in ("moment", "angle"))
    assert 3.2 < moment.value < 3.5  # 0.5 kg and a rod at 0.5 m; a least squares of the same rows
    assert (moment.unit, angle.unit) == ("Nm", "rad")
    assert np.cos(angle.value) > 0.99  # it hangs at zero


def test_the_gap_shrinks_on_both_logs(result):
    assert result.verdict != "no_gap"
    # The acceleration of readings of 3 mrad whose instants jitter makes most of what is left: the floor.
    left = np.sqrt(result.gap.after**2 - result.gap.floor**2)
    assert left < 0.3 * result.gap.before  # seen: 0.10 and 0.09; with the floor 0.31 and 0.34
    # Where the mass is known to 30 %, it hides gravity in the 3.5 s of the other motion.
    assert result.gap.confirm_after < 0.8 * result.gap.confirm_before  # seen: 0.36 and 0.77


def test_no_wave_of_one_turn_stands_beside_it(result):
    assert "cogging_harmonic" not in {effect.name for effect in result.effects}
    assert "flexible_mode" not in {effect.name for effect in result.effects}
