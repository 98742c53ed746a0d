"""Table 1 of Xu and Yao 2001 under the joint conditions and those before, what was held out, and what was tried."""

import numpy as np
import pytest

import cogging
from cogging.files import parse_toml
from cogging.papers.xu2001 import epoxy_motor, sinusoidal_motion
from cogging.papers.xu2001 import epoxy_motor as xu2001_setup
from studies.xu2001 import calibration
from tests.fixtures.reproduced import reproduced

# Committed means of the six indexes over the seeds (um, um, um, V, V, 1) by controller and set: the plant fitted to the
# PID alone with all as printed, and the joint conditions.
BEFORE = {
    ("PID", "1"): (58.33, 16.47, 3.053, 0.1957, 0.05154, 0.2633),
    ("PID", "2"): (152.1, 19.57, 7.096, 0.2122, 0.05201, 0.2451),
    ("PID", "3"): (87.69, 15.91, 4.439, 0.4164, 0.05151, 0.1237),
    ("ARC", "1"): (18.17, 17.87, 4.919, 0.1977, 0.07377, 0.3731),
    ("ARC", "2"): (272.6, 18.87, 10.47, 0.2132, 0.06792, 0.3186),
    ("ARC", "3"): (100.5, 17.27, 6.856, 0.4173, 0.07203, 0.1726),
}
JOINT = {
    ("PID", "1"): (57.13, 15.4, 3.08, 0.1886, 0.05303, 0.2812),
    ("PID", "2"): (147.5, 18.44, 6.813, 0.2123, 0.05419, 0.2552),
    ("PID", "3"): (86, 15.81, 4.434, 0.4075, 0.05295, 0.1299),
    ("ARC", "1"): (15.14, 7.749, 1.98, 0.1905, 0.07087, 0.3721),
    ("ARC", "2"): (130.6, 6.608, 4.015, 0.2135, 0.05788, 0.2711),
    ("ARC", "3"): (60.96, 7.358, 2.847, 0.4083, 0.06804, 0.1667),
}
#: Of the withheld numbers.
HELD_OUT = {
    "set_2": {
        ("PID", "2"): (148.8, 15.36, 6.657, 0.2154, 0.05524, 0.2564),
        ("ARC", "2"): (125.6, 5.83, 3.817, 0.2164, 0.05838, 0.2697),
    },
    "arc_sets_2_3": {
        ("ARC", "2"): (109.5, 5.922, 3.453, 0.2096, 0.05199, 0.248),
        ("ARC", "3"): (59.66, 7.721, 2.343, 0.4106, 0.06306, 0.1536),
    },
}


@pytest.fixture(scope="module")
def result():
    return reproduced("xu2001")


def table_of(result, name):
    return next(table for table in result.tables if table.id == name)


def summary(table):
    counts = table.counts()
    return counts.numbers, counts.calibrated, counts.predicted, counts.within, counts.free


def values_of(table):
    """The numbers of a table by controller, set and index, metres as um."""
    return {
        (row.controller, row.labels["set"], row.index): row.simulated * (1e6 if row.unit == "m" else 1.0)
        for row in table.rows
    }


@pytest.mark.parametrize("when", ["before", "joint"])
def test_table_1_is_the_committed_one(when, result):
    table, committed = (
        (table_of(result, "table1"), JOINT) if when == "joint" else (table_of(result, "table1").before, BEFORE)
    )
    print(f"\n{table.text()}")
    found = values_of(table)
    assert len(found) == 36
    for (controller, set_name), values in committed.items():
        for index, value in zip(xu2001_setup.INDEXES, values, strict=True):
            count = 0.3 if index in ("e_M", "e_F") else 0.0  # a third of an encoder count: means over eight seeds
            band = max(count, 0.01 * value)
            assert found[controller, set_name, index] == pytest.approx(value, abs=band), (controller, set_name, index)


def test_calibrated_is_exactly_what_took_part(result):
    joint = table_of(result, "table1")
    for table, controllers in ((joint.before, {"PID"}), (joint, {"PID", "ARC"})):
        calibrated = {(row.controller, row.index) for row in table.rows if row.status == "calibrated"}
        assert calibrated == {(name, index) for name in controllers for index in epoxy_motor.FITTED}
        derived = {(row.controller, row.index) for row in table.rows if row.status == "derived"}
        assert derived == {("PID", "du_rms"), ("ARC", "du_rms")}
    assert {row.status for row in joint.rows} == {"calibrated", "derived"}


def test_as_many_numbers_come_near_as_committed(result):
    joint = table_of(result, "table1")
    # Numbers, calibrated, predicted; within 5, 15, 40 %; free parameters.
    assert summary(joint.before) == (30, 15, 15, (11, 20, 22), 9)
    assert summary(joint) == (30, 30, 0, (13, 25, 30), 8)


def test_du_rms_is_derived_from_two_others(result):
    """By (54), in the paper's numbers and in ours."""
    for controller, sets in xu2001_setup.TABLE_1.items():
        for name, (*_, u_rms, du_rms, c_u) in sets.items():
            assert du_rms == pytest.approx(c_u * u_rms, abs=0.0062), (controller, name)
    found = values_of(table_of(result, "table1"))
    for controller, name, index in found:
        if index == "du_rms":
            product = found[controller, name, "u_rms"] * found[controller, name, "c_u"]
            assert found[controller, name, index] == pytest.approx(product, rel=1e-4)  # means over the seeds, each


def test_theta_with_and_without_payload_is_that_of_52():
    unknowns = xu2001_setup.shipped_unknowns()
    for name, expected in (("1", (37.0, 37.0 * 0.273)), ("2", (10.0, 2.73))):
        axis = xu2001_setup.plant(unknowns, name).axis
        assert (1.0 / axis.mass, axis.viscous / axis.mass) == pytest.approx(expected)


def test_the_free_parameters_are_those_of_the_fits(result):
    joint = table_of(result, "table1")
    free = calibration.Problem(calibration.ALL, start=calibration.JOINT_START).names()
    assert list(joint.free) == [*free, "earlier_runs"]
    assert list(joint.before.free) == calibration.Problem(calibration.PID, "smooth_stribeck").names()
    assert epoxy_motor.joint_conditions().earlier_runs == calibration.EARLIER_RUNS


def test_every_fitted_number_is_as_near_the_papers_as_committed(result):
    errors = {
        (row.controller, row.labels["set"], row.index): row.simulated / row.paper - 1.0
        for row in table_of(result, "table1").rows
        if row.status == "calibrated"
    }
    worst = max(errors, key=lambda place: abs(errors[place]))
    print(f"\nworst: {worst}, {errors[worst]:+.1%}")
    assert len(errors) == 30
    assert errors[worst] == pytest.approx(0.181, abs=0.01)
    assert worst == ("PID", "3", "c_u")
    far = {place for place, error in errors.items() if abs(error) > 0.15}
    assert far == {
        worst,
        *(("ARC", *place) for place in (("1", "c_u"), ("2", "e_M"), ("3", "e_F"))),
        ("PID", "2", "e_rms"),
    }


def test_the_arc_is_better_than_the_pid_in_every_error_index_as_printed(result):
    shares = sinusoidal_motion.better_shares(table_of(result, "table1"))
    printed = {
        (name, index): np.divide(*(xu2001_setup.TABLE_1[c][name][place] for c in ("ARC", "PID")))
        for name in xu2001_setup.SETS
        for place, index in enumerate(("e_M", "e_F", "e_rms"))
    }
    assert shares.keys() == printed.keys()
    for place, share in shares.items():
        print(f"\n{place}: error of the ARC over that of the PID {share:.2f}, paper {printed[place]:.2f}", end="")
        assert share < 1.0, place
        assert share == pytest.approx(printed[place], abs=0.17 if place == ("2", "e_M") else 0.14), place
    assert max(shares.values()) == pytest.approx(0.886, abs=0.02)
    before = sinusoidal_motion.better_shares(table_of(result, "table1").before)
    assert sum(share < 1.0 for share in before.values()) == 2


def test_seeds_outside_the_fit_come_as_near(result):
    rows = {
        (row.labels["seeds"], row.index, row.labels["of 8"]): row.simulated for row in table_of(result, "seeds").rows
    }
    for words, near, left in (("fitted", 24.6, 0.0929), ("others", 25.0, 0.0950)):
        assert rows[words, "within_15", "mean"] == pytest.approx(near, abs=0.3)
        assert rows[words, "rms_log_error", "mean"] == pytest.approx(left, abs=0.001)
        assert (rows[words, "within_15", "least"], rows[words, "within_15", "largest"]) == (24, 26)
    by_hand = [sinusoidal_motion.table_1({name: joint_by_seed(name)[:, 0] for name in xu2001_setup.CONTROLLERS})]
    assert (
        rows["others", "within_15", "least"] <= by_hand[0].counts().within[1] <= rows["others", "within_15", "largest"]
    )


def joint_by_seed(controller):
    return epoxy_motor.joint_conditions().by_seed(controller, seeds=sinusoidal_motion.OTHER_SEEDS[:1])


def test_the_indexes_over_seeds_are_those_of_each_run():
    joint = epoxy_motor.joint_conditions()
    for name in xu2001_setup.CONTROLLERS:
        found = joint.by_seed(name, seeds=(2001, 2002))
        for place, log in enumerate(joint.logs(name, seed=2001).values()):
            np.testing.assert_allclose(found[place, 0], list(xu2001_setup.indexes(log).values()), rtol=1e-9)
        assert not np.array_equal(found[:, 0], found[:, 1])


def test_the_note_says_what_the_table_shows(result):
    joint = epoxy_motor.joint_conditions()
    note = result.notes[0]
    said = " ".join(note.split())
    assert f"adaptation rates {joint.adaptation_factor:.3g} times" in said
    assert f"kept from {joint.earlier_runs} earlier runs" in said
    assert f"Of 30 fitted numbers {table_of(result, 'table1').counts().within[1]} lie within 15 %" in said
    assert "smaller than the PID's in 9 of 9 cases" in said


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


def test_the_shipped_fits_have_the_errors_that_they_state():
    file = epoxy_motor.shipped_file()
    laws = set(epoxy_motor.LAWS)
    assert set(file) == {*laws - {epoxy_motor.JOINT_LAW}, "joint", "earlier_runs", "readings", "held_out"}
    assert set(file["joint"]) == laws
    assert set(file["readings"]) == set(calibration.READINGS)
    for law in laws - {epoxy_motor.JOINT_LAW}:
        assert_has_the_error_that_it_states(file[law], calibration.PID, (xu2001_setup.SEED,))
    for law in (epoxy_motor.JOINT_LAW, "smooth_stribeck"):
        assert_has_the_error_that_it_states(file["joint"][law], calibration.ALL)
    for split, fitted in calibration.HELD_OUT.items():
        assert_has_the_error_that_it_states(file["held_out"][split], fitted)


def test_no_nested_model_is_nearer_than_the_larger():
    file = epoxy_motor.shipped_file()
    for parts in (file, file["joint"]):
        for law in epoxy_motor.LAWS:
            for nested in set(calibration.nested_in(law)) & set(parts):
                assert parts[law]["rms_log_error"] <= parts[nested]["rms_log_error"], (law, nested)
    assert "smooth_coulomb" in calibration.nested_in("smooth_stribeck")
    assert "smooth_stribeck" not in calibration.nested_in("smooth_coulomb")


@pytest.mark.study
def test_the_other_conditions_leave_what_their_table_states():
    file = epoxy_motor.shipped_file()
    for part in (*file["earlier_runs"].values(), *file["readings"].values(), *file["joint"].values()):
        assert_has_the_error_that_it_states(part, calibration.ALL)


def test_the_held_out_numbers_are_the_committed_ones(result):
    for split in calibration.HELD_OUT:
        table = table_of(result, f"held_out_{split}")
        print(f"\n{table.text()}")
        seen = calibration.HELD_OUT[split]
        for row in table.rows:
            took_part = row.labels["set"] in seen.get(row.controller, ())
            expected = "calibrated" if took_part else "predicted" if row.index != "du_rms" else "derived"
            assert row.status == expected
        found, predicted = values_of(table), 0
        for (controller, name), values in HELD_OUT[split].items():
            for index, value in zip(xu2001_setup.INDEXES, values, strict=True):
                band = max(0.3 if index in ("e_M", "e_F") else 0.0, 0.01 * value)
                assert found[controller, name, index] == pytest.approx(value, abs=band), (split, name, index)
                predicted += 1
        assert table.counts().predicted + 2 == predicted == 12


def test_the_held_out_numbers_are_nearer_than_the_trivial_guess(result):
    # Within 5, 15, 40 %, of 10 numbers each.
    set_2, arc = (table_of(result, f"held_out_{split}") for split in calibration.HELD_OUT)
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


def test_other_conditions_leave_more(result):
    left = {row.labels["conditions"]: row.simulated for row in table_of(result, "conditions").rows}
    shipped = left[f"plant {epoxy_motor.JOINT_LAW}"]
    assert shipped == left[f"earlier runs: {calibration.EARLIER_RUNS}"]
    assert shipped == pytest.approx(0.0914, abs=0.0005)
    larger = {f"plant {law}" for law in epoxy_motor.LAWS if epoxy_motor.JOINT_LAW in calibration.nested_in(law)}
    assert all((size <= shipped) == (name in larger) for name, size in left.items() if size != shipped)
    runs = [left[f"earlier runs: {number}"] for number in range(4)]
    assert runs == pytest.approx([0.161, 0.110, 0.0914, 0.105], abs=0.001)
    readings = [left[name] for name in calibration.READINGS]
    assert readings == pytest.approx([0.298, 0.101, 0.111, 0.0915], abs=0.001)


def test_the_exploration_leads_to_the_joint_conditions(result):
    gaps = {row.labels["change"]: row.simulated for row in table_of(result, "exploration").rows}
    kept, both, all_fitted = list(gaps.values())[-3:]
    print(f"\n{gaps}")
    assert gaps["as printed, g only"] == pytest.approx(0.657, abs=0.02)
    assert (kept, both, all_fitted) == pytest.approx((0.532, 0.167, 0.100), abs=0.01)
    assert all_fitted == min(gaps.values())


@pytest.mark.study
def test_the_calibration_script_regenerates_what_is_shipped():
    found, shipped = parse_toml(calibration.plant_toml()), dict(epoxy_motor.shipped_file())
    # The plant of the PID columns is older than the rest: today's search ends elsewhere in the same rough valley. It is
    # kept, because the comparison, the tuning and the table before stand on it.
    of_today, kept = found.pop("smooth_stribeck"), shipped.pop("smooth_stribeck")
    assert found == shipped
    assert of_today["rms_log_error"] == pytest.approx(kept["rms_log_error"], abs=0.0005)


def test_faster_adaptation_closes_most_of_the_gap():
    unknowns = xu2001_setup.shipped_unknowns()
    as_printed = sinusoidal_motion.gap(
        sinusoidal_motion.columns(cogging.OutputFeedbackArc(xu2001_setup.arc_parameters()), unknowns)
    )
    changed = xu2001_setup.arc_parameters(**sinusoidal_motion.changes()["adaptation x 3.5"])
    faster = sinusoidal_motion.gap(sinusoidal_motion.columns(cogging.OutputFeedbackArc(changed), unknowns))
    print(f"\nrms log gap of the ARC columns: {as_printed:.3f} as printed, {faster:.3f} with 3.5 times the adaptation")
    assert 0.3 < faster / as_printed < 0.6


def test_the_claims_stand_in_the_result(result):
    claims = {"fast_motion", "robust_terms", "robust_subsets", "theorem_1", "pid_poles"}
    assert claims <= {table.id for table in result.tables}
    assert set(result.figures) == {f"xu2001_{name}" for name in ("fig2", "fig3", "fig4", "fig5", "fig6", "increment")}
