"""Table 1 of Xu and Yao 2001 under the joint conditions and those before, what was held out, and what was tried."""

import numpy as np
import pytest

import cogging
from cogging.files import parse_toml
from cogging.papers.xu2001 import conditions, conditions_fit, exploration, tables
from cogging.papers.xu2001 import setup as xu2001_setup
from studies.xu2001 import calibration
from studies.xu2001 import study as xu2001_study
from tests.fixtures.reproduced import reproduced

# Committed values of the six indexes (um, um, um, V, V, 1) by controller and set: the plant fitted to the PID alone
# with all as printed, and the joint conditions.
BEFORE = {
    ("PID", "1"): (57.1, 16.05, 3.046, 0.1958, 0.05199, 0.2656),
    ("PID", "2"): (152, 20.09, 7.082, 0.2122, 0.05195, 0.2448),
    ("PID", "3"): (87.44, 16.1, 4.433, 0.4164, 0.05146, 0.1236),
    ("ARC", "1"): (18.02, 17.77, 4.919, 0.1977, 0.07321, 0.3704),
    ("ARC", "2"): (272.7, 19.11, 10.47, 0.2132, 0.06845, 0.3211),
    ("ARC", "3"): (100.8, 17.11, 6.856, 0.4172, 0.07198, 0.1725),
}
JOINT = {
    ("PID", "1"): (58.1, 15.05, 3.256, 0.1887, 0.05482, 0.2904),
    ("PID", "2"): (145.0, 18.09, 6.861, 0.2138, 0.05649, 0.2642),
    ("PID", "3"): (87.44, 15.05, 4.565, 0.4104, 0.0549, 0.1338),
    ("ARC", "1"): (15.85, 7.096, 1.866, 0.1907, 0.07242, 0.3798),
    ("ARC", "2"): (123.8, 6.054, 3.808, 0.2159, 0.0588, 0.2723),
    ("ARC", "3"): (57.78, 7.054, 2.586, 0.4113, 0.06957, 0.1692),
}
#: Of the withheld numbers.
HELD_OUT = {
    "set_2": {
        ("PID", "2"): (142, 14.6, 6.39, 0.2143, 0.05349, 0.2496),
        ("ARC", "2"): (162, 6.42, 5.027, 0.2172, 0.05991, 0.2759),
    },
    "arc_sets_2_3": {
        ("ARC", "2"): (218, 8.42, 7.222, 0.2312, 0.06134, 0.2653),
        ("ARC", "3"): (61.39, 8.391, 2.776, 0.4226, 0.06588, 0.1559),
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
            count = 1.0 if index in ("e_M", "e_F") else 0.0  # one encoder count
            band = max(count, 0.02 * value)
            assert found[controller, set_name, index] == pytest.approx(value, abs=band), (controller, set_name, index)


def test_calibrated_is_exactly_what_took_part(result):
    joint = table_of(result, "table1")
    for table, controllers in ((joint.before, {"PID"}), (joint, {"PID", "ARC"})):
        calibrated = {(row.controller, row.index) for row in table.rows if row.status == "calibrated"}
        assert calibrated == {(name, index) for name in controllers for index in conditions_fit.FITTED}
        derived = {(row.controller, row.index) for row in table.rows if row.status == "derived"}
        assert derived == {("PID", "du_rms"), ("ARC", "du_rms")}
    assert {row.status for row in joint.rows} == {"calibrated", "derived"}


def test_as_many_numbers_come_near_as_committed(result):
    joint = table_of(result, "table1")
    # Numbers, calibrated, predicted; within 5, 15, 40 %; free parameters.
    assert summary(joint.before) == (30, 15, 15, (11, 20, 22), 9)
    assert summary(joint) == (30, 30, 0, (13, 27, 30), 11)


def test_du_rms_is_derived_from_two_others(result):
    """By (54), in the paper's numbers and in ours."""
    for controller, sets in xu2001_setup.TABLE_1.items():
        for name, (*_, u_rms, du_rms, c_u) in sets.items():
            assert du_rms == pytest.approx(c_u * u_rms, abs=0.0062), (controller, name)
    found = values_of(table_of(result, "table1"))
    for controller, name, index in found:
        if index == "du_rms":
            product = found[controller, name, "u_rms"] * found[controller, name, "c_u"]
            assert found[controller, name, index] == pytest.approx(product)


def test_the_free_parameters_are_those_of_the_fits(result):
    joint = table_of(result, "table1")
    free = conditions_fit.Problem(calibration.ALL, start=calibration.JOINT_START).names()
    assert list(joint.free) == [*free, "earlier_runs"]
    assert list(joint.before.free) == conditions_fit.Problem(calibration.PID).names()
    assert conditions.joint_conditions().earlier_runs == calibration.EARLIER_RUNS


def test_every_fitted_number_is_as_near_the_papers_as_committed(result):
    errors = {
        (row.controller, row.labels["set"], row.index): row.simulated / row.paper - 1.0
        for row in table_of(result, "table1").rows
        if row.status == "calibrated"
    }
    worst = max(errors, key=lambda place: abs(errors[place]))
    print(f"\nworst: {worst}, {errors[worst]:+.1%}")
    assert len(errors) == 30
    assert errors[worst] == pytest.approx(0.216, abs=0.02)
    assert worst == ("PID", "3", "c_u")
    far = {place for place, error in errors.items() if abs(error) > 0.15}
    assert far == {worst, ("ARC", "1", "c_u"), ("ARC", "3", "e_rms")}


def test_the_arc_is_better_than_the_pid_in_every_error_index_as_printed(result):
    shares = tables.better_shares(table_of(result, "table1"))
    printed = {
        (name, index): np.divide(*(xu2001_setup.TABLE_1[c][name][place] for c in ("ARC", "PID")))
        for name in xu2001_setup.SETS
        for place, index in enumerate(("e_M", "e_F", "e_rms"))
    }
    assert shares.keys() == printed.keys()
    for place, share in shares.items():
        print(f"\n{place}: error of the ARC over that of the PID {share:.2f}, paper {printed[place]:.2f}", end="")
        assert share < 1.0, place
        assert share == pytest.approx(printed[place], abs=0.20 if place == ("3", "e_rms") else 0.14), place
    assert max(shares.values()) == pytest.approx(0.854, abs=0.02)
    before = tables.better_shares(table_of(result, "table1").before)
    assert sum(share < 1.0 for share in before.values()) == 2


def test_other_noise_changes_little():
    # The fit saw one seed, at which 27 of 30 numbers lie within 15 %; of others fewer do.
    counts = xu2001_study.counts_by_seed(conditions.joint_conditions(), (100, 200))
    print(f"\n{counts}")
    assert [near for near, _ in counts] == pytest.approx([24, 25], abs=1)
    assert [smaller for _, smaller in counts] == [9, 9]


def test_the_note_says_what_the_table_shows(result):
    joint = conditions.joint_conditions()
    note = result.notes[0]
    assert f"adaptation rates {joint.adaptation_factor:.3g} times" in note
    assert f"kept from {joint.earlier_runs} earlier runs" in note
    assert f"{table_of(result, 'table1').counts().within[1]} of 30 lie within 15 %" in note
    assert "smaller than the PID's in 9 of 9 cases" in note
    assert "factors of 2.81 and 2.9;" in note


def test_earlier_runs_leave_theta_1_and_theta_2_to_the_next_and_nothing_else():
    machine = xu2001_setup.plant(xu2001_setup.shipped_unknowns(), "2")
    first = cogging.OutputFeedbackArc(xu2001_setup.arc_parameters(adaptation=[1.5e6, 9e5, 6e6]))
    known = [xu2001_setup.after_earlier_runs(machine, first, runs, 5).parameters for runs in range(3)]
    assert known[0] == first.parameters
    alone = cogging.closed_loop(
        machine, first, xu2001_setup.reference(), duration=xu2001_setup.DURATION, seed=6, record_estimates=True
    )
    assert np.abs(alone.estimates[-1][2]) > 1.0
    np.testing.assert_allclose(known[1].theta, [*alone.estimates[-1][:2], 0.0], rtol=1e-12)
    assert 30.0 > known[1].theta[0] + 3.0 > known[2].theta[0] + 6.0 > 16.0, "towards 10, the payload's"
    assert known[2].replace(theta=first.parameters.theta) == first.parameters
    frozen = cogging.OutputFeedbackArc(xu2001_setup.arc_parameters(adaptation=[0.0] * 3))
    assert xu2001_setup.after_earlier_runs(machine, frozen, 1, 5).parameters == frozen.parameters


def rms(gap):
    return np.sqrt(np.mean(gap**2))


def assert_has_the_error_that_it_states(part, fitted):
    gap = conditions_fit.log_ratios(conditions.conditions_of(part), fitted)
    assert rms(gap) == pytest.approx(part["rms_log_error"], rel=0.02), part
    assert np.abs(np.expm1(gap)).max() == pytest.approx(part["largest_relative_error"], rel=0.05), part
    assert part["rms_log_error"] == min(part["rms_log_error_of_starts"])


def test_the_shipped_fits_have_the_errors_that_they_state():
    file = conditions.shipped_file()
    assert set(file) == {*conditions_fit.LAWS, "joint", "earlier_runs", "readings", "held_out"}
    assert set(file["joint"]) == set(conditions_fit.LAWS)
    assert set(file["readings"]) == {*calibration.READINGS, calibration.EACH_RATE}
    for law in conditions_fit.LAWS:
        assert_has_the_error_that_it_states(file[law], calibration.PID)
        assert_has_the_error_that_it_states(file["joint"][law], calibration.ALL)
    for split, fitted in calibration.HELD_OUT.items():
        assert_has_the_error_that_it_states(file["held_out"][split], fitted)
    for part in (file["earlier_runs"]["0"], file["readings"]["w_2 = 0.3 for 0.1"]):
        assert_has_the_error_that_it_states(part, calibration.ALL)


@pytest.mark.study
def test_the_other_conditions_leave_what_their_table_states():
    file = conditions.shipped_file()
    for part in (*file["earlier_runs"].values(), *file["readings"].values()):
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
                band = max(1.0 if index in ("e_M", "e_F") else 0.0, 0.02 * value)
                assert found[controller, name, index] == pytest.approx(value, abs=band), (split, name, index)
                predicted += 1
        assert table.counts().predicted + 2 == predicted == 12


def test_the_held_out_numbers_are_nearer_than_the_trivial_guess(result):
    # Within 5, 15, 40 %, of 10 numbers each.
    set_2, arc = (table_of(result, f"held_out_{split}") for split in calibration.HELD_OUT)
    assert set_2.counts().predicted_within == (3, 6, 9)
    assert set_2.before.counts().within == (3, 5, 6)
    assert arc.counts().predicted_within == (1, 5, 8)
    assert arc.before.counts().within == (1, 3, 7)
    factors = [part["adaptation_factor"] for part in conditions.shipped_file()["held_out"].values()]
    assert factors == pytest.approx([2.81, 2.90], abs=0.01), "a part of the numbers gives much the same factor"


def test_the_trivial_guess_is_the_papers_own_ratio_or_set_1():
    # PID set 2 times ARC set 1 over PID set 1, and set 1.
    assert tables.trivial("arc_sets_2_3", "ARC", "2")["e_M"] == pytest.approx(156e-6 * 14.4 / 51.2)
    assert tables.trivial("set_2", "PID", "2")["e_F"] == 15.1e-6


def test_other_conditions_leave_more(result):
    left = {row.labels["conditions"]: row.simulated for row in table_of(result, "conditions").rows}
    shipped = left[f"friction {conditions_fit.JOINT_LAW}"]
    assert shipped == left[f"earlier runs: {calibration.EARLIER_RUNS}"]
    assert shipped == pytest.approx(0.0997, abs=0.001)
    assert left["friction smooth_coulomb"] == pytest.approx(0.0971, abs=0.001), "the table cannot tell the two apart"
    assert all(size > shipped for name, size in left.items() if size != shipped and name != "friction smooth_coulomb")
    sticking = [left[f"friction exact_{law}"] for law in ("stribeck", "coulomb")]
    assert sticking == pytest.approx([0.153, 0.110], abs=0.002)
    runs = [left[f"earlier runs: {number}"] for number in range(5)]
    assert runs == pytest.approx([0.160, 0.113, 0.0997, 0.113, 0.144], abs=0.002)
    readings = [left[name] for name in (*calibration.READINGS, calibration.EACH_RATE)]
    assert readings == pytest.approx([0.266, 0.146, 0.110, 0.108, 0.107, 0.153, 0.100, 0.186, 0.112], abs=0.002)


def test_the_rates_of_mass_and_constant_ask_for_much_the_same_factor():
    # Each rate free, from the printed ones: theta_1 and theta_3 agree, theta_2 decides little.
    part = conditions.shipped_file()["readings"][calibration.EACH_RATE]
    factors = np.divide(part["changes"]["adaptation"], xu2001_setup.arc_parameters().adaptation)
    print(f"\nfactors on the three rates: {factors}")
    assert factors == pytest.approx([3.36, 0.88, 2.88], abs=0.01)


def test_the_exploration_leads_to_the_joint_conditions(result):
    gaps = {row.labels["change"]: row.simulated for row in table_of(result, "exploration").rows}
    kept, both, all_fitted = list(gaps.values())[-3:]
    print(f"\n{gaps}")
    assert gaps["as printed, g only"] == pytest.approx(0.657, abs=0.02)
    assert (kept, both, all_fitted) == pytest.approx((0.532, 0.157, 0.106), abs=0.01)
    assert all_fitted == min(gaps.values())


@pytest.mark.study
def test_the_calibration_script_regenerates_what_is_shipped():
    found, shipped = parse_toml(calibration.plant_toml()), conditions.shipped_file()
    # The plant of the PID columns is older than the rest: today's search ends elsewhere in the same rough valley. It is
    # kept, because the comparison, the tuning and the table before stand on it.
    of_today, kept = found.pop("smooth_stribeck"), shipped.pop("smooth_stribeck")
    assert found == shipped
    assert of_today["rms_log_error"] == pytest.approx(kept["rms_log_error"], abs=0.0005)


def test_faster_adaptation_closes_most_of_the_gap():
    unknowns = xu2001_setup.shipped_unknowns()
    as_printed = exploration.gap(
        exploration.columns(cogging.OutputFeedbackArc(xu2001_setup.arc_parameters()), unknowns)
    )
    changed = xu2001_setup.arc_parameters(**exploration.changes()["adaptation x 3.5"])
    faster = exploration.gap(exploration.columns(cogging.OutputFeedbackArc(changed), unknowns))
    print(f"\nrms log gap of the ARC columns: {as_printed:.3f} as printed, {faster:.3f} with 3.5 times the adaptation")
    assert 0.3 < faster / as_printed < 0.6


def test_the_claims_stand_in_the_result(result):
    claims = {"fast_motion", "robust_terms", "robust_subsets", "theorem_1", "pid_poles"}
    assert claims <= {table.id for table in result.tables}
    assert set(result.figures) == {f"xu2001_{name}" for name in ("fig2", "fig3", "fig4", "fig5", "fig6", "increment")}
