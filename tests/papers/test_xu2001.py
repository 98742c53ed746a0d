"""Table 1 of Xu and Yao 2001 under the joint conditions and those before, what was held out, and what was tried."""

import numpy as np
import pytest

import cogging
from cogging.files import parse_toml
from cogging.papers.xu2001 import epoxy_motor, sinusoidal_motion
from cogging.papers.xu2001 import epoxy_motor as xu2001_setup
from studies.xu2001 import calibration
from tests.fixtures.reproduced import numbers_of, table_of


def summary(table):
    counts = table.counts()
    return counts.numbers, counts.calibrated, counts.predicted, counts.within, counts.free


def test_calibrated_is_exactly_what_took_part():
    joint = table_of("xu2001", "table1")
    for table, controllers in ((joint.before, {"PID"}), (joint, {"PID", "ARC"})):
        calibrated = {(row.controller, row.index) for row in table.rows if row.status == "calibrated"}
        assert calibrated == {(name, index) for name in controllers for index in epoxy_motor.FITTED}
        derived = {(row.controller, row.index) for row in table.rows if row.status == "derived"}
        assert derived == {("PID", "du_rms"), ("ARC", "du_rms")}
    assert {row.status for row in joint.rows} == {"calibrated", "derived"}


def test_as_many_numbers_come_near_as_committed():
    joint = table_of("xu2001", "table1")
    # Numbers, calibrated, predicted; within 5, 15, 40 %; free parameters.
    assert summary(joint.before) == (30, 15, 15, (11, 20, 22), 9)
    assert summary(joint) == (30, 30, 0, (13, 25, 30), 8)


def test_du_rms_is_derived_from_two_others():
    """By (54), in the paper's numbers and in ours."""
    for controller, sets in xu2001_setup.TABLE_1.items():
        for name, (*_, u_rms, du_rms, c_u) in sets.items():
            assert du_rms == pytest.approx(c_u * u_rms, abs=0.0062), (controller, name)
    found = numbers_of("xu2001", "table1")
    for controller, index, name in found:
        if index == "du_rms":
            product = found[controller, "u_rms", name] * found[controller, "c_u", name]
            assert found[controller, index, name] == pytest.approx(product, rel=1e-4)  # means over the seeds, each


def test_theta_with_and_without_payload_is_that_of_52():
    unknowns = xu2001_setup.shipped_unknowns()
    for name, expected in (("1", (37.0, 37.0 * 0.273)), ("2", (10.0, 2.73))):
        axis = xu2001_setup.plant(unknowns, name).axis
        assert (1.0 / axis.mass, axis.viscous / axis.mass) == pytest.approx(expected)


def test_the_free_parameters_are_those_of_the_fits():
    joint = table_of("xu2001", "table1")
    free = calibration.Problem(calibration.ALL, start=calibration.JOINT_START).names()
    assert list(joint.free) == [*free, "earlier_runs"]
    assert list(joint.before.free) == calibration.Problem(calibration.PID, "smooth_stribeck").names()
    assert epoxy_motor.joint_conditions().earlier_runs == calibration.EARLIER_RUNS


def test_the_arc_is_better_than_the_pid_in_every_error_index_as_printed():
    shares = sinusoidal_motion.better_shares(table_of("xu2001", "table1"))
    printed = {
        (name, index): np.divide(*(xu2001_setup.TABLE_1[c][name][place] for c in ("ARC", "PID")))
        for name in xu2001_setup.SETS
        for place, index in enumerate(("e_M", "e_F", "e_rms"))
    }
    assert shares.keys() == printed.keys()
    off = {place: share - printed[place] for place, share in shares.items()}
    assert off.pop(("2", "e_M")) == pytest.approx(0.161, abs=0.002)
    assert max(map(abs, off.values())) < 0.11
    assert max(shares.values()) == pytest.approx(0.886, abs=0.002)
    before = sinusoidal_motion.better_shares(table_of("xu2001", "table1").before)
    assert sum(share < 1.0 for share in before.values()) == 2


def test_the_indexes_over_seeds_are_those_of_each_run():
    joint = epoxy_motor.joint_conditions()
    for name in xu2001_setup.CONTROLLERS:
        found = joint.by_seed(name, seeds=(2001, 2002))
        for place, log in enumerate(joint.logs(name, seed=2001).values()):
            np.testing.assert_allclose(found[place, 0], list(xu2001_setup.indexes(log).values()), rtol=1e-9)
        assert not np.array_equal(found[:, 0], found[:, 1])


def test_earlier_runs_leave_theta_1_and_theta_2_to_the_next_and_nothing_else():
    machine = xu2001_setup.plant(xu2001_setup.shipped_unknowns(), "2")
    first = cogging.OutputFeedbackArc(xu2001_setup.arc_parameters(adaptation=[1.5e6, 9e5, 6e6]))
    known = [xu2001_setup.after_earlier_runs(machine, first, runs, 5).parameters for runs in range(3)]
    assert known[0] == first.parameters
    alone = cogging.closed_loop(
        machine, first, xu2001_setup.reference(), duration=xu2001_setup.DURATION, seed=4, record_estimates=True
    )
    assert np.abs(alone.estimates[-1][2]) > 1.0
    np.testing.assert_allclose(known[1].theta, [*alone.estimates[-1][:2], 0.0], rtol=1e-12)
    assert 30.0 > known[1].theta[0] + 3.0 > known[2].theta[0] + 6.0 > 16.0, "towards 10, the payload's"
    assert known[2].replace(theta=first.parameters.theta) == first.parameters
    frozen = cogging.OutputFeedbackArc(xu2001_setup.arc_parameters(adaptation=[0.0] * 3))
    assert xu2001_setup.after_earlier_runs(machine, frozen, 1, 5).parameters == frozen.parameters


def assert_has_the_error_that_it_states(part, fitted, seeds=xu2001_setup.SEEDS):
    gap = calibration.log_ratios(epoxy_motor.conditions_of(part), fitted, seeds)
    assert calibration.rms(gap) == pytest.approx(part["rms_log_error"], rel=0.02), part
    assert np.abs(np.expm1(gap)).max() == pytest.approx(part["largest_relative_error"], rel=0.05), part
    assert part["rms_log_error"] == min(part["rms_log_error_of_starts"])


def test_the_shipped_fits_of_the_tables_have_the_errors_that_they_state():
    file = epoxy_motor.shipped_file()
    assert_has_the_error_that_it_states(file["smooth_stribeck"], calibration.PID, (xu2001_setup.SEED,))
    assert_has_the_error_that_it_states(file["joint"][epoxy_motor.JOINT_LAW], calibration.ALL)
    for split, fitted in calibration.HELD_OUT.items():
        assert_has_the_error_that_it_states(file["held_out"][split], fitted)


@pytest.mark.study
def test_the_other_fits_have_the_errors_that_they_state():
    file = epoxy_motor.shipped_file()
    for law in set(epoxy_motor.LAWS) - {epoxy_motor.JOINT_LAW}:
        assert_has_the_error_that_it_states(file[law], calibration.PID, (xu2001_setup.SEED,))
    for part in (*file["earlier_runs"].values(), *file["readings"].values(), *file["joint"].values()):
        assert_has_the_error_that_it_states(part, calibration.ALL)


def test_no_nested_model_is_nearer_than_the_larger():
    file = epoxy_motor.shipped_file()
    for parts in (file, file["joint"]):
        for law in epoxy_motor.LAWS:
            for nested in set(calibration.nested_in(law)) & set(parts):
                assert parts[law]["rms_log_error"] <= parts[nested]["rms_log_error"], (law, nested)
    assert "smooth_coulomb" in calibration.nested_in("smooth_stribeck")
    assert "smooth_stribeck" not in calibration.nested_in("smooth_coulomb")


def test_held_out_is_what_took_no_part():
    for split, seen in calibration.HELD_OUT.items():
        table = table_of("xu2001", f"held_out_{split}")
        for row in table.rows:
            took_part = row.labels["set"] in seen.get(row.controller, ())
            expected = "calibrated" if took_part else "predicted" if row.index != "du_rms" else "derived"
            assert row.status == expected
        assert table.counts().predicted == 10


def test_the_joint_conditions_leave_least_of_what_was_tried():
    gaps = list(numbers_of("xu2001", "exploration").values())
    assert gaps[-1] == min(gaps)
    left = numbers_of("xu2001", "conditions")
    shipped = left["both", "rms_log_error", f"plant {epoxy_motor.JOINT_LAW}"]
    larger = {f"plant {law}" for law in epoxy_motor.LAWS if epoxy_motor.JOINT_LAW in calibration.nested_in(law)}
    for (_, _, name), size in left.items():
        assert size == shipped or (size < shipped) == (name in larger), name


def test_the_held_out_numbers_are_nearer_than_the_trivial_guess():
    # Within 5, 15, 40 %, of 10 numbers each.
    set_2, arc = (table_of("xu2001", f"held_out_{split}") for split in calibration.HELD_OUT)
    assert set_2.counts().predicted_within == (3, 8, 10)
    assert set_2.before.counts().within == (3, 5, 6)
    assert arc.counts().predicted_within == (3, 5, 10)
    assert arc.before.counts().within == (1, 3, 7)
    factors = [part["adaptation_factor"] for part in epoxy_motor.shipped_file()["held_out"].values()]
    assert factors == pytest.approx([2.78, 3.35], abs=0.01), "a part of the numbers gives much the same factor"


def test_the_trivial_guess_is_the_papers_own_ratio_or_set_1():
    # PID set 2 times ARC set 1 over PID set 1, and set 1.
    assert sinusoidal_motion.trivial("arc_sets_2_3", "ARC", "2")["e_M"] == pytest.approx(156e-6 * 14.4 / 51.2)
    assert sinusoidal_motion.trivial("set_2", "PID", "2")["e_F"] == 15.1e-6


@pytest.mark.study
def test_the_calibration_script_regenerates_what_is_shipped():
    found, shipped = parse_toml(calibration.plant_toml()), dict(epoxy_motor.shipped_file())
    # The plant of the PID columns is older than the rest: today's search ends elsewhere in the same rough valley. It is
    # kept, because the comparison, the tuning and the table before stand on it.
    of_today, kept = found.pop("smooth_stribeck"), shipped.pop("smooth_stribeck")
    assert found == shipped
    assert of_today["rms_log_error"] == pytest.approx(kept["rms_log_error"], abs=0.0005)
