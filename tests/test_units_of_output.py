"""`[units]` in all output: no volt and no metre for a model in newton and radian."""

import re

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from tests.fixtures.drawn_results import VERDICTS, drawn_result
from tests.fixtures.files import REFERENCE
from tests.fixtures.pid_axis import MODEL, PID, run

UNITS = cogging.Units(command="N", position="rad")
ROTARY = MODEL.replace(units=UNITS)
#: A unit of V and m, alone or with a prefix or a power, as a word of its text.
VOLT_OR_METRE = re.compile(r"(?<![\w.])(?:[kmunµ]?[Vm])(?![\w.=]|'')")
PICTURE = re.compile(r"<style>.*?</style>|data:image/png;base64,[^\"]*", re.DOTALL)


def left_in(text):
    """What of V and m a text still has, with the text around it."""
    return [text[max(0, found.start() - 30) : found.end() + 10] for found in VOLT_OR_METRE.finditer(text)]


def texts(value):
    """Every text in a JSON value."""
    if isinstance(value, str):
        yield value
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ():
        yield from texts(inner)


def said_of(result):
    """Text, one line, JSON and labels of axes of a result."""
    yield str(result)
    yield repr(result)
    if hasattr(result, "to_dict"):
        yield from texts(result.to_dict())
    if hasattr(result, "to_frame"):
        yield from result.to_frame().attrs["units"].values()
    if hasattr(result, "plot") and not getattr(result, "verdict", "").endswith(("mismatch", "excitation")):
        for axes in result.plot().axes:
            yield from (axes.get_xlabel(), axes.get_ylabel(), axes.get_title())


@pytest.fixture(scope="module")
def log():
    return run(cogging.effects.CableSpring(stiffness=3.0, center=0.2), duration=1.0)


SPEEDS = np.concatenate([-np.linspace(0.05, 1.0, 12), np.linspace(0.05, 1.0, 12)])
PLACES = np.linspace(0.0, 0.4, 801)
MOVE = cogging.Sine(cogging.SineParameters(center=0.2, amplitude=0.05, frequency=2.0))
STROKE = cogging.PointToPoint(cogging.PointToPointParameters(start=0.1, distance=0.2, velocity=0.1, dwell=0.1))
LIMITS = cogging.MotionLimits(velocity=0.3, acceleration=5.0, duration=3.0)
BOUNDED = ROTARY.replace(intervals={"axis.mass": (0.11, 0.13)})
GAINS = {"controller.kp": {"from": 5e3, "to": 2e4}}
FEW = {"trials": 2, "machines": 2, "held_out": 2, "duration": 0.2}
RESULTS = {
    "audit": lambda log: cogging.audit(log, ROTARY),
    "identify": lambda log: cogging.identify(log, ROTARY, free=["axis.mass", "axis.viscous", "axis.coulomb"]),
    "locate": lambda log: cogging.locate_gap(log, ROTARY),
    "diagnose a sign": lambda log: cogging.diagnose(cogging.Log(log.time, log.position, -log.command), ROTARY),
    "bounds": lambda log: cogging.Bounds.of(ROTARY),
    "predict": lambda log: cogging.predict_error(BOUNDED, MOVE, ["own"], samples=4, duration=0.2),
    "tune": lambda log: cogging.tune(BOUNDED, MOVE, GAINS, limits={"command_max": 9.0, "error_max": 1e-3}, **FEW),
    "experiment": lambda log: cogging.plan_experiment(ROTARY, LIMITS, goal="fit"),
    "sweep": lambda log: cogging.sweep(ROTARY, MOVE, {"axis.mass": [0.11, 0.12]}, duration=0.1),
    "simulate": lambda log: cogging.simulate(ROTARY, MOVE, duration=0.1),
    "friction": lambda log: cogging.fit_friction_curve(
        SPEEDS, 0.15 * np.sign(SPEEDS) + 0.2 * SPEEDS, exponent=1.0, units=UNITS
    ),
    "controller": lambda log: cogging.recover_controller(cogging.simulate(ROTARY, STROKE)),
    "spectrum": lambda log: cogging.tracking_spectrum(cogging.simulate(ROTARY, STROKE)),
    "batch": lambda log: cogging.closed_loop_batch(
        [ROTARY.plant()], [ROTARY.make_controller()], MOVE, duration=0.1, logs=True, units=UNITS
    ),
    "map": lambda log: cogging.fit_map(PLACES, 0.1 * np.sin(126.0 * PLACES) + 0.3 * PLACES, pitch=0.05, units=UNITS),
}


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_is_in_the_units_of_its_model(name, log):
    said = list(said_of(RESULTS[name](log)))
    assert sum(len(text) for text in said) > 30
    assert [left for text in said for left in left_in(text)] == []
    if name != "diagnose a sign":
        assert any(re.search(r"\b[kmun]?(N|rad)\b", text) for text in said), said


@pytest.mark.parametrize("verdict", VERDICTS)
def test_screen_json_and_page_of_a_diagnosis_have_no_volt_and_no_metre(verdict):
    """Of drawn results of every verdict; names of logs keep their letters."""
    generator = np.random.default_rng(7)
    for _ in range(2):
        result = drawn_result(generator, verdict, model=ROTARY)
        said = [result.text(), result.text(verbose=True), repr(result), *texts(result.to_dict())]
        assert [left for text in said for left in left_in(text)] == []
    if verdict not in ("ambiguous", "data_mismatch"):
        return  # one page with pictures and one without
    page = PICTURE.sub("", result.html(title="run 5 V at 3 m.csv")).replace("run 5 V at 3 m.csv", "")
    assert left_in(page) == []
    assert "N" in page
    if result.series:
        assert [left for text in said_of(result) for left in left_in(text)] == []


def test_errors_are_in_the_units_of_the_model(log):
    wild = ROTARY.replace(controller=PID.replace(kd=4800.0))
    with pytest.raises(cogging.DivergedError, match="the travel is") as error:
        cogging.simulate(wild, MOVE, duration=1.0)
    assert left_in(str(error.value)) == []
    long = cogging.Log(log.time, 1e3 * log.position, log.command)
    with pytest.raises(cogging.InputError, match=r"7 m\.csv: position: spans .* rad but .* travel is 0.51 rad"):
        cogging.check_against_model(long, ROTARY, "7 m.csv")
    travel = ROTARY.replace(axis=ROTARY.axis.replace(travel=[0.0, 0.4]))
    in_degrees = cogging.Log(log.time, np.degrees(log.position), log.command)
    with pytest.raises(cogging.InputError, match=r"position=0\.0174533 if it is in degrees"):
        cogging.check_against_model(in_degrees, travel)


def test_commands_print_and_write_them(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ROTARY.write("model.toml")
    (tmp_path / "ref.toml").write_text(REFERENCE)
    rows = "".join(f"{x},{np.sin(126.0 * x)}\n" for x in PLACES)
    (tmp_path / "scan.csv").write_text(f"position,force\n{rows}")
    assert main(["simulate", "model.toml", "--reference", "ref.toml", "--out", "log.csv"]) == 0
    assert main(["map", "scan.csv", "--pitch", "0.05", "--units", "command=N,position=rad", "--out", "part.toml"]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"max \|error\| [\d.e-]+ rad\n", printed)
    assert left_in(printed) == []
    assert cogging.read_log("log.csv").units == UNITS
    assert 'command = "N"' in (tmp_path / "part.toml").read_text()
