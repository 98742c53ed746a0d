"""From intervals to controllers: the bounds, what is designed from them, and what is refused."""

import itertools
import math

import numpy as np
import pytest

import cogging
from cogging.papers.lu2008 import gantry as lu2008
from cogging.papers.xu2001 import epoxy_motor as xu2001_setup

AXIS = cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1 / 900, travel=[0.0, 0.51])
INTERVALS = {"axis.mass": (0.1, 0.2), "axis.viscous": (0.15, 0.35), "axis.coulomb": (0.1, 0.3)}
BASIS = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2, 3], control_points=13)
FORCE = cogging.CoggingModel(BASIS, *np.random.default_rng(1).uniform(-0.1, 0.1, (2, 3, 13)))


def model(**changes):
    fields = {"axis": AXIS, "intervals": INTERVALS, "encoder": cogging.EncoderParameters(resolution=0.5e-6)}
    return cogging.Model(**{**fields, **changes})


def bounds_of(default=None, **changes):
    """The bounds of the model with these changes."""
    return cogging.Bounds.of(model(**changes), default=default or {})


def test_intervals_become_the_projection_set():
    values = {f"cogging.{part}": getattr(FORCE, part) for part in ("sine", "cosine")}
    amplitudes = {
        f"{path}[{i}][{j}]": (value - 0.01, value + 0.01)
        for path, table in values.items()
        for (i, j), value in np.ndenumerate(table)
    }
    widths = INTERVALS | amplitudes | {"effects.constant_force.force": (-0.5, 0.5)}
    bounds = bounds_of(cogging=FORCE, effects=[cogging.effects.ConstantForce(force=0.1)], intervals=widths)
    assert (bounds.mass, bounds.viscous, bounds.coulomb) == ((0.1, 0.2), (0.15, 0.35), (0.1, 0.3))
    assert bounds.disturbance == pytest.approx((-0.5, 0.5))
    extent = np.concatenate([FORCE.sine, FORCE.cosine])
    assert bounds.cogging == pytest.approx((extent.min() - 0.01, extent.max() + 0.01))
    assert bounds.fallbacks == bounds.notes == ()
    parameters = bounds.adaptive_robust()
    for name in ("mass", "viscous", "coulomb", "disturbance", "cogging"):
        assert getattr(parameters, f"{name}_bounds") == pytest.approx(list(getattr(bounds, name)))
    estimates = [getattr(parameters, name) for name in ("mass", "viscous", "coulomb", "disturbance")]
    assert estimates == [0.12, 0.166, 0.15, 0.1]
    for position in (0.03, 0.2, 0.444):  # what believes the truth holds the axis against the whole cogging
        command = cogging.Dcarc(parameters.replace(disturbance=0.0)).command(reference=position, reading=position)
        assert command == pytest.approx(FORCE.force(position))


def test_missing_intervals_fall_back_on_the_uncertainty_and_are_reported():
    bounds = bounds_of(intervals={"axis.mass": (0.1, 0.2)}, uncertainty={"viscous": 0.2, "coulomb": 0.0})
    assert bounds.viscous == pytest.approx((0.166 * (1 - 1.96 * 0.2), 0.166 * (1 + 1.96 * 0.2)), rel=1e-4)
    assert bounds.coulomb == (0.15, 0.15)
    notes = "\n".join(bounds.fallbacks)
    assert "axis.viscous: no interval in [bounds], 1.96 of its 20 % in [axis.uncertainty] counts" in notes
    assert "axis.mass" not in notes


MEASURE = {"axis.mass": "larger accelerations", "cogging.sine[1][2]": "slowly over the whole travel"}
MEASURE |= {"effects.cable_spring.stiffness": "this effect acts"}


@pytest.mark.parametrize(("path", "words"), MEASURE.items())
def test_an_infinite_interval_names_the_parameter_and_what_to_measure(path, words):
    changes = {"cogging": FORCE, "effects": [cogging.effects.CableSpring(stiffness=0.4)]}
    changes["intervals"] = INTERVALS | {path: (-math.inf, math.inf)}
    with pytest.raises(ValueError, match=words) as error:
        bounds_of(**changes)
    assert str(error.value).startswith(f"{path}: the logs do not determine it, its interval is [-inf, inf]")
    default = {path: (0.05, 1.0)} if not path.startswith("cogging") else {"cogging": (-0.2, 0.2)}
    bounds = bounds_of(default, **changes)
    assert any(path in line or "amplitudes of the cogging" in line for line in bounds.fallbacks)


def test_the_longest_default_that_fits_counts():
    default = {"axis": (0.0, 1.0), "axis.mass": (0.05, 0.3), "cogging": (-0.2, 0.2), "cogging.sine[0]": (-0.4, 0.4)}
    bounds = bounds_of(default, cogging=FORCE, intervals={})
    assert (bounds.mass, bounds.viscous, bounds.cogging) == ((0.05, 0.3), (0.0, 1.0), (-0.4, 0.4))


REFUSED = [
    ({"axis.mass": None}, {}, r"axis\.mass: needs an interval in \[bounds\], a 1-sigma"),
    ({"axis.mass": (0.13, 0.2)}, {}, r"axis\.mass: its interval \[0\.13, 0\.2\] must hold the model's value, got 0\."),
    ({"axis.mass": (-0.1, 0.2)}, {}, r"axis\.mass: its interval must lie above 0 to design a controller, got \[-0\.1"),
    ({"axis.weight": (1, 2)}, {}, r"bounds\.axis\.weight: must be a parameter"),
    ({}, {"default": {"axle": (0, 1)}}, r"default\['axle'\]: must be a parameter"),
    ({}, {"default": {"axis.mass": (1, 0)}}, r"default\['axis\.mass'\]: must be \(lower"),
    ({}, {"default": {"disturbance": (0, math.inf)}}, r"default\['disturbance'\]: must be"),
    ({}, {"velocity_max": 0.0}, r"velocity_max: must be finite and above 0, got 0\.0"),
]


@pytest.mark.parametrize(("changes", "arguments", "message"), REFUSED)
def test_refuses(changes, arguments, message):
    intervals = {path: ends for path, ends in (INTERVALS | changes).items() if ends}
    with pytest.raises(ValueError, match=f"^{message}"):
        cogging.Bounds.of(model(intervals=intervals), **arguments)


FORCES = {
    "harmonic": (cogging.effects.CoggingHarmonic(period=0.02, sine=0.3, cosine=0.4), -0.5, 0.5),
    "drag at both speeds": (cogging.effects.QuadraticDrag(coefficient=0.3), -0.3 * 4, 0.3 * 4),
    "step that comes late": (cogging.effects.DisturbanceStep(force=0.5, start=22.0, stop=23.0), 0.0, 0.5),
    # slopes B +- difference / 2, levels + difference / 2 forward and - backward: both directions push alike
    "viscous asymmetry": (cogging.effects.ViscousAsymmetry(difference=0.1), -0.1, 0.0),
    "Stribeck": (cogging.effects.StribeckFriction(static_excess=0.2, velocity=0.01), -0.2, 0.2),
}


@pytest.mark.parametrize("name", FORCES)
def test_disturbance_is_the_range_of_the_force(name):
    effect, low, high = FORCES[name]
    bounds = cogging.Bounds.of(model(effects=[effect]), default={"disturbance": (0.0, 0.0)}, velocity_max=2.0)
    assert bounds.disturbance == pytest.approx((low, high), rel=3e-3, abs=1e-9)


def test_disturbances_add_up_and_effects_on_the_command_are_reported():
    present = [cogging.effects.ConstantForce(force=0.1), cogging.effects.CableSpring(stiffness=1.0, center=0.255)]
    widths = {"effects.constant_force.force": (0.0, 0.2), "effects.cable_spring.stiffness": (0.9, 1.1)}
    changes = {"effects": present, "noise": cogging.NoiseParameters(force=0.01), "intervals": INTERVALS | widths}
    reach = 0.255 * 1.1 + 0.1 + 1.96 * 0.01
    assert bounds_of(**changes).disturbance == pytest.approx((0.1 - reach, 0.1 + reach), rel=1e-4)
    more = bounds_of({"disturbance": (-1.0, 2.0)}, **changes).disturbance
    assert more == pytest.approx((0.1 - reach - 1.0, 0.1 + reach + 2.0), rel=1e-4)
    late = bounds_of(effects=[cogging.effects.CommandDelay(delay=1e-3)])
    assert any(note.startswith("effects.command_delay: acts on command or reading") for note in late.notes)


def test_without_an_interval_of_constant_forces_the_coulomb_level_counts():
    bounds = bounds_of(effects=[cogging.effects.ConstantForce(force=0.02)])
    assert bounds.disturbance == pytest.approx((0.02 - 0.3, 0.02 + 0.3))
    assert any(note.startswith("disturbance: no interval says") for note in bounds.notes)
    assert bounds_of({"disturbance": (0.0, 0.0)}).disturbance == (0.0, 0.0)


def test_the_rule_gives_the_gains_of_lu2008():
    """From the X axis' mass, bounds and bandwidth alone: the printed gains, the adaptation within 4 %."""
    printed = lu2008.controller_parameters(lu2008.AXES["X"], "C3")
    bounds = bounds_of({"disturbance": (-0.5, 0.5), "cogging": (-0.1, 0.1)}, cogging=FORCE)
    found = bounds.adaptive_robust(bandwidth=200.0)
    assert found.error_gain == printed.error_gain
    assert found.feedback_gain == pytest.approx(printed.feedback_gain)
    for name in ("mass", "viscous", "coulomb", "disturbance", "cogging"):
        assert getattr(found, f"{name}_bounds") == pytest.approx(getattr(printed, f"{name}_bounds"))
        assert getattr(found, f"{name}_adaptation") == pytest.approx(getattr(printed, f"{name}_adaptation"), rel=0.05)
    for name in ("pitch", "harmonics", "order", "origin", "control_points"):
        assert getattr(found, f"cogging_{name}") == getattr(printed, f"cogging_{name}")


def test_periods_become_harmonics_of_a_common_pitch():
    force = cogging.CoggingModel(cogging.SplineHarmonics(periods=[0.024, 0.016]), [[0.1], [0.2]], [[0.05], [-0.1]])
    parameters = bounds_of(cogging=force).adaptive_robust()
    assert (parameters.cogging_pitch, parameters.cogging_harmonics) == (pytest.approx(0.048), [2, 3])
    assert cogging.Dcarc(parameters).command(reference=0.123, reading=0.123) == pytest.approx(force.force(0.123))
    for basis in (
        cogging.SplineHarmonics(periods=[0.024, 0.024 / math.pi]),
        cogging.SplineHarmonics(periods=[0.024, 0.016], pitch=0.05, control_points=4),
    ):
        amplitudes = np.full((2, 2, basis.spline.control_points), 0.1)
        bounds = bounds_of({"cogging": (-0.2, 0.2)}, cogging=cogging.CoggingModel(basis, *amplitudes))
        with pytest.raises(ValueError, match=r"^cogging\.periods: must be whole fractions of one pitch"):
            bounds.adaptive_robust()


def test_pid_has_its_poles_for_the_smallest_mass_and_cascade_is_never_underdamped():
    pid = bounds_of().pid(bandwidth=150.0)
    np.testing.assert_allclose(cogging.pid_poles(pid.kp, pid.ki, pid.kd, 0.1), [-150.0] * 3, rtol=1e-4)
    assert (pid.mass, pid.viscous, pid.coulomb) == (0.12, 0.166, 0.15)
    cascade = bounds_of().cascade(bandwidth=150.0)
    np.testing.assert_allclose(np.roots([0.2, cascade.kv, cascade.kv * cascade.kp]), [-150] * 2, rtol=1e-6)
    for mass in (0.1, 0.15, 0.2):
        assert np.all(np.roots([mass, cascade.kv, cascade.kv * cascade.kp]).imag < 1e-3)


def test_output_feedback_is_the_papers_at_its_bandwidth_and_mass():
    printed = xu2001_setup.arc_parameters()
    axis = cogging.AxisParameters(mass=1 / 30, viscous=1 / 3, coulomb=0.1, coulomb_width=1 / 900)
    exact = cogging.Model(axis, uncertainty={"mass": 0.0, "viscous": 0.0, "coulomb": 0.0})
    found = cogging.Bounds.of(exact).output_feedback(bandwidth=300.0, sample_rate=2500.0)
    gains = ("observer_gain_1", "observer_gain_2", "gain_1", "gain_2", "weight_1", "weight_2", "theta", "adaptation")
    for name in gains:
        assert getattr(found, name) == pytest.approx(getattr(printed, name)), name


def test_observer_design_data():
    bounds = bounds_of({"cogging": (-0.2, 0.2)}, cogging=FORCE)
    problem = bounds.observer_problem(0.1, 0.4, bandwidth=300.0, decay_rate=4.0)
    assert problem.periods == pytest.approx([0.05, 0.025, 0.05 / 3])
    assert (problem.velocity_min, problem.velocity_max, problem.decay_rate) == (0.1, 0.4, 4.0)
    assert problem.viscous == pytest.approx(0.166 / 0.12)
    assert (problem.omega, problem.pole_radius) == (300.0, 450.0)
    faster = bounds.observer_problem(0.1, 0.8, bandwidth=300.0)
    assert faster.pole_radius == pytest.approx(2.4 * 2 * math.pi * 0.8 * 3 / 0.05), "the harmonics are within the disk"
    with pytest.raises(ValueError, match=r"^cogging: must be in the model"):
        bounds_of().observer_problem(0.1, 0.5)
    with pytest.raises(ValueError, match=r"^velocity_min: must be above 0"):
        bounds.observer_problem(0.0, 0.5)


def test_sample_rate_and_overrides():
    bounds = bounds_of(controller=cogging.PidParameters(sample_rate=2000.0), controller_type="pid")
    assert bounds.adaptive_robust().sample_rate == 2000.0
    assert bounds.adaptive_robust().error_gain == 80.0, "sample_rate / 25 below 5 kHz"
    assert bounds.adaptive_robust(sample_rate=20_000.0).error_gain == 200.0
    assert bounds.pid(command_limit=3.0).command_limit == 3.0
    assert bounds.cascade(kv=10.0).viscous == pytest.approx(10.0 + 0.166)
    for design in (bounds.adaptive_robust, bounds.output_feedback, bounds.pid, bounds.cascade):
        with pytest.raises(ValueError, match=r"^bandwidth: must be finite and above 0, got -1"):
            design(bandwidth=-1)
        with pytest.raises(TypeError):
            design(no_such_field=1.0)


def test_every_controller_holds_every_corner_of_the_bounds():
    """Machines at all corners of mass, viscous and Coulomb friction, with an offset: no run diverges or drifts."""
    bounds = bounds_of({"cogging": (-0.2, 0.2), "disturbance": (-0.3, 0.3)}, cogging=FORCE)
    limits = {"velocity": 0.4, "acceleration": 8.0, "jerk": 800.0}
    reference = cogging.PointToPoint(cogging.PointToPointParameters(start=0.1, distance=0.2, **limits))
    designs = [cogging.Pid(bounds.pid()), cogging.Cascade(bounds.cascade()), cogging.Arc(bounds.adaptive_robust())]
    designs += [cogging.Dcarc(bounds.adaptive_robust()), cogging.OutputFeedbackArc(bounds.output_feedback())]
    problem = bounds.observer_problem(0.1, 0.4)
    certified = cogging.design_observer(problem)
    parameters = bounds.observer_based(problem, certified, command_limit=50.0)
    assert parameters.observer_gain == certified.observer_gain.tolist()
    assert (parameters.position_gain, parameters.command_limit) == (200.0**2, 50.0)
    cogging.ObserverBased(parameters)
    for corner in itertools.product(bounds.mass, bounds.viscous, bounds.coulomb):
        axis = AXIS.replace(**dict(zip(("mass", "viscous", "coulomb"), corner, strict=True)))
        truth = cogging.Plant(axis, cogging=FORCE, effects=[cogging.effects.ConstantForce(force=0.2)])
        for controller in designs:
            log = cogging.closed_loop(truth, controller, reference)
            assert np.abs(log.position - log.reference).max() < 5e-3, (controller, corner)
