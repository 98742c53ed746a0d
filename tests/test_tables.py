"""Results as pandas frames with their units, and as the tables of a notebook."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

import cogging
from cogging.papers.result import Reproduction, Row, Table
from cogging.tables import html_table
from tests.fixtures.drawn_results import drawn_result
from tests.fixtures.examples import EXAMPLES, LOG, MODEL, MOVE

FRAMED = ["Batch", "Diagnosis", "ErrorPrediction", "FrictionCurve", "Identification", "Log", "MapFit", "SweepRuns"]
FRAMED += ["TrackingSpectrum", "Tuning"]
SHOWN = ["Diagnosis", "FrictionCurve", "Identification", "Log", "MapFit", "Model"]
HOSTILE = '<script>alert("x")</script>&\u202e\x1b[31m$x$'


@pytest.mark.parametrize("name", FRAMED)
def test_a_result_is_a_frame_with_units(name):
    units = EXAMPLES[name].to_frame().attrs["units"]
    assert set(units) <= set(EXAMPLES[name].to_frame().columns)
    assert all(unit not in ("", "1") for unit in units.values())


def test_frames_have_the_numbers_and_units_of_the_results():
    frame = LOG.to_frame()
    assert list(frame.columns) == [*LOG.columns(), "true_position", "true_velocity"]
    assert all(np.array_equal(frame[name], getattr(LOG, name)) for name in frame.columns)
    rotary = cogging.simulate(MODEL.replace(units=cogging.Units(command="A", position="rad")), MOVE, seed=1)
    units = rotary.to_frame().attrs["units"]
    assert [units[name] for name in ("time", "true_velocity", "command")] == ["s", "rad/s", "A"]
    learned = cogging.Log(LOG.time, LOG.position, LOG.command, estimates=np.stack([LOG.time, LOG.command], axis=1))
    np.testing.assert_array_equal(learned.to_frame()["estimates[1]"], LOG.command)
    fit, found, curve = EXAMPLES["MapFit"], EXAMPLES["Identification"], EXAMPLES["FrictionCurve"]
    assert list(fit.to_frame()["amplitude"]) == [entry.amplitude for entry in fit.amplitudes]
    assert fit.to_frame().attrs["units"] == {"amplitude": "V", "standard_error": "V", "phase": "rad"}
    frame = found.to_frame().set_index("parameter")
    for one in found.parameters:
        row = frame.loc[one.path]
        assert (row["value"], row["low"], row["high"], row["unit"]) == (one.value, *one.ci95, one.unit)
    frame = curve.to_frame()
    assert set(frame.loc[frame["best"], "law"]) == {curve.best.name}
    np.testing.assert_array_equal(curve.to_frame("points")["force"], curve.force)
    prediction, tuning = EXAMPLES["ErrorPrediction"], EXAMPLES["Tuning"]
    np.testing.assert_array_equal(prediction.to_frame()["rms"], prediction["own"].rms.values)
    assert len(tuning.to_frame()) == len(tuning.trials["kept"])
    assert len(tuning.to_frame("front")) == len(tuning.front["trial"])


def test_frames_of_a_diagnosis():
    result = drawn_result(np.random.default_rng(1), "named", count=3)
    frame = result.to_frame()
    expected = [(one.name, name, value.value) for one in result.effects for name, value in one.parameters.items()]
    assert list(zip(frame["name"], frame["parameter"], frame["value"], strict=True)) == expected
    assert set(result.to_frame("limits")["name"]) == set(result.limits)
    ledger = result.to_frame("ledger")
    assert list(ledger["accepted"]) == [step.accepted for step in result.ledger]
    assert ledger.attrs["units"]["gap_after"] == "V"


def test_tables_of_a_paper():
    rows = [Row("C1", "e_inf", "m", 1e-5, 1.1e-5, "predicted", {"set": "1"}), Row("C2", "e_2", "m", None, 2e-6, "x")]
    table = Table("table1", "errors", rows)
    frame = Reproduction("lu2008", [table], {}).to_frame()
    assert list(frame["table"]) == ["table1"] * 2
    assert list(frame["simulated"]) == [1.1e-5, 2e-6]
    assert list(table.to_frame()["unit"]) == ["m", "m"]
    assert frame.attrs["paper"] == "lu2008"


@pytest.mark.parametrize(("name", "word"), [("Diagnosis", "gaps"), ("FrictionCurve", "points "), ("Tuning", "frnt")])
def test_an_unknown_table_is_an_error(name, word):
    with pytest.raises(ValueError, match=rf"^what: must be .* or .*, got '{word}'$"):
        EXAMPLES[name].to_frame(word)


def cells(text):
    """The texts of each row of a table."""
    return [["".join(cell.itertext()) for cell in row] for row in ElementTree.fromstring(text).iter("tr")]


@pytest.mark.parametrize("name", SHOWN)
def test_a_notebook_shows_a_small_table(name):
    text = EXAMPLES[name]._repr_html_()
    elements = list(ElementTree.fromstring(text).iter())
    assert {one.tag for one in elements} <= {"div", "b", "table", "thead", "tbody", "tr", "th", "td"}
    assert {name for one in elements for name in one.attrib} <= {"style", "class"}
    assert len({len(row) for row in cells(text)}) == 1
    assert len(text) < 20_000
    assert not re.search(r"https?:|url\(|#[0-9a-fA-F]{3}|\bcolor:|background", text)  # the page's colours, no resource
    assert name in text


def test_the_numbers_of_a_table_are_those_of_the_model():
    rows = {row[0]: row[1:] for row in cells(MODEL.replace(units=cogging.Units(command="N"))._repr_html_())}
    assert rows["axis.mass"] == ["0.12", "N/(m/s^2)", ""]
    assert rows["effects.cable_spring.stiffness"] == ["0.4", "N/m", "0.3 to 0.5"]
    log = {row[0]: row[1:] for row in cells(LOG._repr_html_())}
    assert float(log["command"][2]) == pytest.approx(LOG.command.max(), rel=1e-5)


def test_hostile_names_are_escaped():
    text = html_table(HOSTILE, [HOSTILE], [[HOSTILE], [float("nan")], [None], [True], [np.arange(9.0)]], [HOSTILE])
    assert "<script" not in text
    assert text.isprintable()
    assert [row[0] for row in cells(text)[2:]] == ["", "", "yes", "0, 1, 2, 3, 4, 5, ..."]
