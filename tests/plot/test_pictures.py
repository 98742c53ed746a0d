"""What each picture shows: the lines are the numbers that were given, in the units that the labels say."""

import itertools

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure

import cogging
from cogging.diagnosis.entries import Gap, Step
from tests.fixtures.examples import EXAMPLES, LOG, MODEL, MOVE

PREFIXES = {"": 1.0, "m": 1e3, "µ": 1e6, "n": 1e9}
FACTORS = {p + unit: f for unit in ("m", "s", "V", "m/s", "rad", "A") for p, f in PREFIXES.items()}
FACTORS |= {"m/s²": 1.0, "V/(m/s²)": 1.0}
AMPERES = cogging.Units(command="A", position="rad")


@pytest.fixture(autouse=True)
def settings_stay_and_pyplot_keeps_nothing():
    """Neither the user's settings nor a figure of pyplot is touched by any picture."""
    before, figures = dict(mpl.rcParams), plt.get_fignums()
    yield
    assert dict(mpl.rcParams) == before
    assert plt.get_fignums() == figures


def in_si(label, values):
    """Drawn values in the units that the label of their axis names."""
    unit = label[label.rindex("(", 0, label.rindex("(") + 1) :] if "((" in label else label[label.index("(") :]
    return np.asarray(values, dtype=float) / FACTORS[unit[1:-1]]


@pytest.mark.parametrize("seed", [1, 2])
def test_a_log_is_drawn_row_by_row_with_gaps(seed):
    """Seconds to milliseconds, metres to micrometres, with jitter; lost rows are not bridged."""
    rng = np.random.default_rng(seed)
    rows, step = 500, 10.0 ** rng.uniform(-5, -2)
    size, volts = 10.0 ** rng.uniform(-7, 0.5), 10.0 ** rng.uniform(-4, 3)
    time = step * (np.arange(rows) + 0.3 * rng.uniform(-0.5, 0.5, rows))
    position, command = size * np.cumsum(rng.normal(size=rows)), volts * rng.normal(size=rows)
    reference = position + 1e-3 * size * rng.normal(size=rows)
    kept, lost = np.ones(rows, dtype=bool), seed % 3
    kept[rows // 3 : rows // 3 + lost] = False
    log = cogging.Log(time[kept], position[kept], command[kept], reference[kept] if seed % 2 else None)
    panels = cogging.plot.log(log)
    names = ["position", *(["error"] if seed % 2 else []), "command"]
    assert panels[-1].get_xlabel().startswith("time (")
    for panel, name in zip(panels, names, strict=True):
        assert panel.get_ylabel().startswith(f"{name} (")
        x, y = panel.lines[0].get_data()
        missing = np.isnan(y)
        assert missing.sum() == (lost > 0)  # one gap, however many rows it is long
        assert in_si(panel.get_ylabel(), y[~missing]) == pytest.approx(getattr(log, name), rel=1e-12)
        assert in_si(panels[-1].get_xlabel(), x[~missing]) == pytest.approx(log.time, rel=1e-12)


def test_a_long_log_is_an_envelope_that_loses_no_peak():
    rng = np.random.default_rng(1)
    values = rng.normal(size=400_000)
    values[rng.integers(0, values.size, 3)] = (40.0, -50.0, 60.0)
    (panel,) = cogging.plot.log(cogging.Log(1e-4 * np.arange(values.size), values, values), ["command"])
    y = np.asarray(panel.lines[0].get_ydata())
    assert len(y) < 10_000
    assert in_si(panel.get_ylabel(), [y.min(), y.max()]) == pytest.approx([values.min(), values.max()])


def test_columns_of_a_table_and_units_of_the_model():
    table = {"time": [0.0, 1.0, 2.0], "position": [0.0, 1e-3, 2e-3], "temperature": [20.0, 21.0, 19.0]}
    position, warm = cogging.plot.log(table, ["position", "temperature"])
    assert list(warm.lines[0].get_ydata()) == table["temperature"]
    assert (position.get_ylabel(), warm.get_ylabel()) == ("position (mm)", "temperature")
    rotary = cogging.simulate(MODEL.replace(units=AMPERES), MOVE, seed=1)
    panels = cogging.plot.log(rotary, ["position", "error", "command", "reference_acceleration"])
    labels = ["position (mrad)", "error (µrad)", "command (A)", "reference acceleration (rad/s²)"]
    assert [panel.get_ylabel() for panel in panels] == labels
    assert cogging.plot.error(rotary).get_ylabel() == "tracking error (µrad)"
    assert cogging.plot.error(rotary, units=cogging.Units()).get_ylabel() == "tracking error (µm)"


def test_errors_of_several_logs():
    ax = cogging.plot.error({"first": LOG, "$bad{": cogging.repeat(LOG), "_third": LOG})
    assert [line.get_label() for line in ax.lines] == ["first", r"\$bad{", " _third"]
    assert len(ax.get_legend().get_texts()) == 3
    for line in ax.lines:
        assert in_si(ax.get_ylabel(), np.nanmax(line.get_ydata())) == pytest.approx(LOG.error.max())
    assert ax._repr_png_().startswith(b"\x89PNG")  # a name is no formula


# Maps and spectra -----------------------------------------------------------------------------------------------------


def test_the_band_of_a_map_holds_the_truth_as_often_as_it_says():
    """95 % of places, over drawn noises."""
    held, x = [], np.linspace(0.0, 0.4, 1601)
    truth = 0.1 * np.sin(2 * np.pi * x / 0.05) + 0.04 * np.cos(6 * np.pi * x / 0.05)
    for seed in range(6):
        noisy = truth + 0.02 * np.random.default_rng(seed).normal(size=x.size)
        fit = cogging.fit_map(x, noisy, pitch=0.05, harmonics=[1, 3], order=3)
        ax = cogging.plot.cogging_map(fit, position=x)
        edge = ax.collections[0].get_paths()[0].vertices
        lower, upper = edge[1 : x.size + 1, 1], edge[x.size + 2 : 2 * x.size + 2, 1][::-1]
        held.append(np.mean((lower <= truth) & (truth <= upper)))
        assert ax.lines[-1].get_ydata() == pytest.approx(fit.cogging.force(x))
    assert 0.92 < np.mean(held) < 0.98


def test_a_map_of_a_model_and_of_an_array():
    ax = cogging.plot.cogging_map(MODEL)
    x, y = ax.lines[0].get_data()
    place = in_si(ax.get_xlabel(), x)
    assert y == pytest.approx(MODEL.cogging.force(place))
    assert [place.min(), place.max()] == pytest.approx([0.0, 0.51])
    half = 0.1 * np.sqrt(np.sum(np.square(MODEL.cogging.basis.regressor(place)), axis=1))
    upper = ax.collections[0].get_paths()[0].vertices[:, 1].max()
    assert upper == pytest.approx(np.max(y + half), rel=1e-6)
    assert not cogging.plot.cogging_map(MODEL.replace(intervals={})).collections
    ax = cogging.plot.cogging_map([0.0, 0.2, 0.3], [1e-3, 2e-3, 0.0], deviation=[1e-4] * 3, units=AMPERES)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("position (mrad)", "cogging force (mA)")
    assert ax.collections[0].get_paths()[0].vertices[:, 1].max() == pytest.approx(2.0 + 0.1959964)


def test_spectra():
    found = cogging.tracking_spectrum(LOG)
    ax = cogging.plot.spectrum(found)
    assert list(ax.lines[0].get_xdata()) == list(found.frequency)
    assert in_si("(µm)", ax.lines[0].get_ydata()) == pytest.approx(found.amplitude)
    assert list(ax.lines[2].get_xdata()) == pytest.approx([1.0 / period for period in found.periods])
    assert [text.get_text() for text in ax.texts] == [f"{1e3 * period:.4g} mm" for period in found.periods]
    fit = EXAMPLES["MapFit"]
    ax = cogging.plot.spectrum(fit)
    assert in_si(ax.get_ylabel(), ax.lines[1].get_ydata()) == pytest.approx(fit.line_threshold)


# What was learned, what is left --------------------------------------------------------------------------------------


def test_adaptation_is_drawn_with_its_bounds():
    bounds = {"mass_bounds": (0.05, 0.3), "cogging_bounds": (-0.2, 0.3), "viscous_bounds": (0.0, 0.7)}
    spline = {"cogging_harmonics": [1, 3], "cogging_control_points": 4, "cogging_order": 1}
    parameters = cogging.AdaptiveRobustParameters(cogging_adaptation=5.0, mass_adaptation=1.0, **bounds, **spline)
    log = cogging.simulate(MODEL, MOVE, controller=cogging.Dcarc(parameters), record_estimates=True)
    panels = cogging.plot.adaptation(log)
    assert len(panels) == 12
    ends = [(0.05, 0.3), (0.0, 0.7), parameters.coulomb_bounds, parameters.disturbance_bounds, *[(-0.2, 0.3)] * 8]
    for panel, limits, values in zip(panels, ends, log.estimates.T, strict=False):
        learned, low, high = (np.asarray(line.get_ydata()) for line in panel.lines)
        factor = 1e3 if "mV" in panel.get_ylabel() else 1.0
        assert [low[0], high[0]] == pytest.approx(factor * np.array(limits))
        assert [learned.min(), learned.max()] == pytest.approx([factor * values.min(), factor * values.max()])
    assert panels[0].get_ylabel() == "mass (V/(m/s²))"
    assert panels[4].get_ylabel().startswith("sine 1, point 0 (")


def test_a_residual_in_bins_is_the_mean_of_its_rows():
    rng = np.random.default_rng(1)
    x = rng.uniform(-1.0, 1.0, 20_000)
    (panel,) = cogging.plot.residual(x, 0.3 * x + 0.05 * rng.normal(size=x.size), "velocity")
    place = in_si(panel.get_xlabel(), panel.lines[1].get_xdata())
    assert len(place) == 40
    assert in_si(panel.get_ylabel(), panel.lines[1].get_ydata()) == pytest.approx(0.3 * place, abs=0.01)


def diagnosis_of(steps, before, after, floor, given=None):
    gap = Gap("V", floor, before, after, None, None, "command", given=given)
    return cogging.Diagnosis("named", (), None, gap, None, MODEL, MODEL, ledger=tuple(steps))


def step(name, before, after, accepted=True):
    return Step(name, accepted, "", 10.0, before, after, None, None)


@pytest.mark.parametrize("given", [None, 1.3])
def test_shares_of_a_ledger_add_up_and_are_drawn_end_to_end(given):
    sizes = np.array([0.9, 0.7, 0.72, 0.4])  # with the second effect the gap rose
    steps = [step(f"effect_{k}", *pair) for k, pair in enumerate(itertools.pairwise(sizes))]
    steps.insert(2, step("refused", None, None, accepted=False))
    ax = cogging.plot.ledger(diagnosis_of(steps, sizes[0], 0.9 * sizes[-1], 0.05, given))
    names = [text.get_text() for text in ax.get_yticklabels()]
    widths = {name: bar.get_width() for name, bar in zip(names, ax.patches, strict=True)}
    whole = (given or sizes[0]) ** 2
    assert sum(widths.values()) == pytest.approx(100.0)
    effects = [widths[name] for name in names if name.startswith("effect ")]
    assert effects == pytest.approx(-100.0 * np.diff(sizes**2) / whole)
    assert widths["noise and quantiser"] == pytest.approx(100.0 * 0.05**2 / whole)
    places = [bar.get_x() for bar in ax.patches]
    assert places[1:] == pytest.approx(np.cumsum(list(widths.values()))[:-1], abs=1e-9)


# Friction, fits, many runs --------------------------------------------------------------------------------------------


def test_friction():
    curve = EXAMPLES["FrictionCurve"]
    ax = cogging.plot.friction_curve(curve)
    assert in_si(ax.get_ylabel(), ax.lines[0].get_ydata()) == pytest.approx(curve.force[curve.velocity > 0])
    best = next(line for line in ax.lines if line.get_label() == curve.best.name.replace("_", " "))
    assert in_si(ax.get_ylabel(), best.get_ydata()) == pytest.approx(curve.best.force(best.get_xdata()))
    machine = MODEL.replace(effects=[cogging.effects.QuadraticDrag(coefficient=0.3), *MODEL.effects])
    (_, line, *_) = cogging.plot.friction_curve(machine, fastest=0.8).lines
    v = np.asarray(line.get_xdata())
    assert line.get_ydata() == pytest.approx(0.3 / np.pi * np.arctan(v / 0.01) + 0.166 * v + 0.3 * v**2)


def test_intervals_of_a_fit():
    fit = EXAMPLES["Identification"]
    ax = cogging.plot.intervals(fit)
    assert len(ax.get_yticks()) == len(fit.parameters)
    bars = [line for line in ax.lines if line.get_linewidth() == 3.0]
    for bar, one in zip(bars, fit.parameters, strict=True):
        size = max(abs(one.value), abs(one.prior))
        assert list(bar.get_xdata()) == pytest.approx([100 * (end - one.value) / size for end in one.ci95])
    assert "mass: 0.12 V/(m/s²)" in ax.get_yticklabels()[0].get_text()


def test_a_sweep_is_lines_of_a_grid():
    vary = {"axis.mass": [0.11, 0.13, 0.12], "axis.coulomb": [0.1, 0.2]}
    runs = cogging.sweep(MODEL, MOVE, vary, duration=0.05)
    ax = cogging.plot.sweep(runs, "error_max", "axis.mass")
    lines = [line for line in ax.lines if line.get_linestyle() != "None"]
    assert [list(line.get_xdata()) for line in lines] == [[0.11, 0.12, 0.13]] * 2
    drawn = np.sort(np.concatenate([line.get_ydata() for line in lines]))
    assert in_si(ax.get_ylabel(), drawn) == pytest.approx(np.sort(runs.table["error_max"]))
    assert ax.get_xlabel() == "axis.mass (V/(m/s²))"
    table = {**runs.table, "error_rms": np.where(np.arange(len(runs)) == 0, np.nan, 1e-6)}
    ax = cogging.plot.sweep(cogging.SweepRuns(table, runs.varied, runs.units))
    (mark,) = [line for line in ax.lines if line.get_label() == "failed"]
    assert len(mark.get_xdata()) == 1


def test_predictions_and_trade_off():
    found = EXAMPLES["ErrorPrediction"]
    ax = cogging.plot.prediction(found, "max")
    assert in_si("(µm)", sorted(ax.lines[0].get_xdata())) == pytest.approx(sorted(found["own"].max.values))
    assert in_si("(µm)", ax.lines[1].get_xdata()) == pytest.approx(found["own"].max.interval)
    tuning = EXAMPLES["Tuning"]
    left, right = tuning.plot().axes
    (line,) = [one for one in left.lines if one.get_label() == "none is better"]
    assert sorted(in_si(left.get_ylabel(), line.get_ydata())) == pytest.approx(sorted(tuning.front["error_rms"]))
    assert right.get_xlabel() == "delay margin (ms)"


# What holds for all ---------------------------------------------------------------------------------------------------

#: The arguments of each, made when they are asked for.
LEARNED = cogging.Log(LOG.time, LOG.position, LOG.command, estimates=LOG.position[:, None])
PICTURES = {
    "log": lambda: (LOG, "command"),
    "error": lambda: (LOG,),
    "cogging_map": lambda: (MODEL,),
    "spectrum": lambda: ([1.0, 2.0], [1e-6, 2e-6]),
    "residual": lambda: (LOG.position, LOG.command, "position"),
    "friction_curve": lambda: (MODEL,),
    "intervals": lambda: (EXAMPLES["Identification"],),
    "sweep": lambda: (EXAMPLES["SweepRuns"],),
    "prediction": lambda: (EXAMPLES["ErrorPrediction"],),
    "trade_off": lambda: (EXAMPLES["Tuning"],),
    "adaptation": lambda: (LEARNED, [(0.0, 1.0)]),
    "ledger": lambda: (diagnosis_of([step("cable_spring", 1.0, 0.5)], 1.0, 0.5, 0.1),),
}
EVERY = pytest.mark.parametrize("name", cogging.plot.__all__)


@EVERY
def test_axes_are_taken_and_returned(name):
    function = getattr(cogging.plot, name)
    axes = Figure().subplots(2)[1]
    axes.plot([0.0], [0.0], label="my own")
    found = function(*PICTURES[name](), ax=axes)
    assert axes in np.atleast_1d(np.asarray(list(found) if hasattr(found, "__len__") else found, dtype=object))
    assert axes.lines[0].get_label() == "my own"
    assert axes.get_xlabel()
    found = function(*PICTURES[name]())
    assert found._repr_png_().startswith(b"\x89PNG")


@EVERY
def test_mistakes_are_told_in_one_line(name):
    function = getattr(cogging.plot, name)
    with pytest.raises(TypeError, match=r"ax: must be axes of matplotlib, as plt\.subplots\(\) gives them, got"):
        function(*PICTURES[name](), ax="here")
    with pytest.raises(TypeError, match=rf"{name}: axs: is not an argument; did you mean ax\?"):
        function(*PICTURES[name](), axs=None)
    if name != "ledger":
        with pytest.raises(TypeError, match=r"units: must be cogging\.Units\(.*\), got 'A'"):
            function(*PICTURES[name](), units="A")
    with pytest.raises((TypeError, ValueError), match=r"^\w+: must (be|name|have)[^\n]*$"):
        function(object(), *PICTURES[name]()[1:])


FURTHER = [
    (lambda plot: plot.log(LOG, ["postion"]), "columns: must be columns of the log, got 'postion': did you mean"),
    (lambda plot: plot.log(LOG, ax=Figure().subplots(2)), "ax: must be 3 axes for as many panels, got 2"),
    (lambda plot: plot.error([0.0, 1.0], [1.0]), r"error: must be as long as what it is drawn over \(2\), got 1"),
    (lambda plot: plot.cogging_map(MODEL.replace(cogging=None)), "cogging: must be in the model to be drawn"),
    (lambda plot: plot.residual(LOG.position, LOG.command), "against: must name the coordinate of an array"),
    (lambda plot: plot.sweep(EXAMPLES["SweepRuns"], "error_rm"), "index: must be of these runs, got 'error_rm': did"),
    (lambda plot: EXAMPLES["Batch"].plot(), "logs: must be recorded to be read"),
]


@pytest.mark.parametrize(("call", "rule"), FURTHER)
def test_further_mistakes(call, rule):
    with pytest.raises(ValueError, match=f"^{rule}"):
        call(cogging.plot)


RESULTS = ["Log", "MapFit", "FrictionCurve", "Identification", "Location", "ErrorPrediction", "TrackingSpectrum"]
RESULTS += ["Tuning", "SweepRuns", "ExperimentPlan", "Model"]


@pytest.mark.parametrize("name", RESULTS)
def test_every_result_draws_itself(name):
    figure = EXAMPLES[name].plot()
    assert isinstance(figure, Figure)
    axes = np.array(Figure().subplots(len(figure.axes), squeeze=False)).ravel()
    assert EXAMPLES[name].plot(ax=axes) is axes[0].figure
    for mine, theirs in zip(axes, figure.axes, strict=True):
        assert len(mine.lines) == len(theirs.lines)
        assert mine.get_ylabel() == theirs.get_ylabel()


def test_pyplot_has_a_figure_only_where_a_window_shows_it(monkeypatch, tmp_path):
    monkeypatch.setattr(plt, "get_backend", lambda: "qtagg")
    EXAMPLES["MapFit"].write(tmp_path / "map.toml")
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")
    assert plt.get_fignums() == [], "what is written opens none"
    figure = EXAMPLES["MapFit"].plot()
    assert plt.get_fignums() == [figure.number]
    plt.close(figure)
    monkeypatch.setattr(plt, "get_backend", lambda: "inline")
    cogging.plot.spectrum([1.0, 2.0], [1.0, 2.0])
    assert plt.get_fignums() == []
