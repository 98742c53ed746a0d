"""Tables 1 and 2 of Lu et al. 2008: how the maps are fitted, and what the errors show. Numbers: test_numbers.py."""

import importlib.resources

import numpy as np
import pytest

from cogging import Log
from cogging.papers.lu2008 import gantry as lu2008
from cogging.papers.lu2008 import tracking
from studies.lu2008 import calibration, families
from tests.fixtures.reproduced import numbers_of, table_of

AXES = pytest.mark.parametrize("axis", lu2008.AXES.values(), ids=lu2008.AXES)


@AXES
def test_tables_are_fitted_by_four_numbers_within_the_printed_bound(axis):
    table = table_of("lu2008", axis.table)
    assert {row.status for part in (table, table.before) for row in part.rows} == {"calibrated"}
    free = {name for each in lu2008.AXES.values() for name in table_of("lu2008", each.table).free}
    assert free == set(tracking.FREE) == set(calibration.FAMILY.free)
    assert calibration.FAMILY.shape == lu2008.shipped_shape()
    model = lu2008.cogging_map(axis, lu2008.shipped_amplitudes(axis))
    compensated = [place for place, harmonic in enumerate(lu2008.HARMONICS) if harmonic in axis.compensated]
    points = np.array([model.sine[compensated], model.cosine[compensated]])
    assert np.abs(points).max() == pytest.approx(lu2008.share_of_bound(axis, model) * axis.cogging_bound)
    assert lu2008.share_of_bound(axis, model) < 0.82


def test_maxima_are_whole_counts_and_stand_at_constant_speed():
    """Where the reference rests or moves at a constant speed the error is whole counts; where it accelerates, not."""
    counts = numbers_of("lu2008", "maxima")
    for axis in lu2008.AXES.values():
        printed = np.array(axis.error_max) / lu2008.RESOLUTION
        assert np.abs(printed - np.round(printed)).max() < 0.001
        for name in lu2008.CONTROLLERS:
            speed, rest, ramp = (counts[name, "counts", axis.name, at] for at in ("constant speed", "rest", "ramp"))
            assert (speed, rest) == pytest.approx((round(speed), round(rest)), abs=0.001)
            assert ramp <= speed + 1e-6


def test_with_the_other_reading_the_ramps_decide_and_no_cogging_is_needed():
    axis = lu2008.AXES["X"]
    for difference, expected in ((False, (5.33, 1.56)), (True, (1.5, 0.23))):
        log = lu2008.run(axis, lu2008.plant(axis, None), error_difference=difference)["C3"]
        assert 1e6 * np.array(lu2008.indexes(log, lu2008.reference(axis))) == pytest.approx(expected, rel=0.05)
    late = lu2008.plant(axis, lu2008.cogging_map(axis, lu2008.shipped_amplitudes(axis, lu2008.LATE)))
    parts = tracking.largest_by_part(axis, lu2008.run(axis, late, error_difference=False)["C3"])
    assert parts["ramp"] > 1.2 * parts["constant speed"]


@AXES
def test_the_error_at_constant_speed_is_split_by_harmonics(axis):
    """A log with known waves: 1 um at each compensated harmonic, 0.5 um at the others, as rms."""
    motion = lu2008.reference(axis)
    t = np.arange(0.0, motion.end, 1.0 / lu2008.SAMPLE_RATE)
    x, v, _ = motion.sample(t)
    others = [harmonic for harmonic in lu2008.HARMONICS if harmonic not in axis.compensated]
    error = np.sqrt(2.0) * sum(
        size * np.sin(2.0 * np.pi * harmonic * x / lu2008.PITCH + harmonic)
        for size, listed in ((1e-6, axis.compensated), (0.5e-6, others))
        for harmonic in listed
    )
    log = Log(time=t, position=x + error, command=0.0 * t, reference=x, reference_velocity=v)
    part = tracking.at_constant_speed(axis, log)
    assert part.shape == (7, round(lu2008.PITCH / axis.velocity * lu2008.SAMPLE_RATE))
    found = {row.labels["harmonics"]: row.simulated for row in tracking.smoothness_table(axis, {"C3": log}).rows}
    squares = {"all": 3.5e-12, " ".join(map(str, axis.compensated)): 3e-12, " ".join(map(str, others)): 0.5e-12}
    assert found == pytest.approx({name: np.sqrt(square) for name, square in squares.items()}, rel=1e-3)


@pytest.mark.study
def test_the_calibration_script_regenerates_the_shipped_maps():
    shipped = importlib.resources.files("cogging.papers.lu2008").joinpath("maps.toml").read_text()
    assert calibration.maps_toml() == shipped


@pytest.mark.study
def test_the_grid_holds_what_the_page_says():
    """Of 432 cells: the fewest free numbers that bring 11 of 12 within 15 % are four, with e' as the difference."""
    cells = families.grid(print)
    assert len(cells) == 432
    enough = [cell for cell in cells if cell.near >= families.ENOUGH]
    for reading, count in ((True, 1), (False, 4)):
        found = [cell.family for cell in enough if cell.family.error_difference == reading]
        assert min(len(family.free) for family in found) == 4
        assert sum(len(family.free) == 4 for family in found) == count
    assert calibration.FAMILY in [cell.family for cell in enough]
