"""The null: what may be re-tuned, and which rows count."""

from cogging import EFFECTS
from cogging.diagnosis.evidence.null import fit_null, nuisances, starts_fit
from tests.fixtures.moving_axis import machine, record


def test_nuisances_are_levels_and_known_amplitudes():
    assert set(nuisances(machine())) == {
        "axis.mass", "axis.viscous", "axis.coulomb", "axis.coulomb_width", "cogging.sine[0][0]", "cogging.cosine[0][0]",
    }  # fmt: skip


def test_rows_soon_after_a_start_count_only_where_they_fit():
    nominal = machine()
    (usual,) = fit_null([record(nominal, 3)], nominal)[1].sources
    assert usual.quick_starts
    soft = machine([EFFECTS["presliding_friction"](stiffness=1.5 / 1e-4)])  # gives way over a tenth of a millimetre
    (calm,) = fit_null([record(soft, 3)], nominal)[1].sources
    assert not calm.quick_starts
    assert not starts_fit(nominal, [calm], [calm])  # no row more
