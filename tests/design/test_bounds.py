"""From intervals to controllers: what the bounds are, what is designed from them, and what is refused."""

import itertools
import math

import numpy as np
import pytest

import cogging
from cogging.design.bounds import periods_of, pitch_and_harmonics
from cogging.papers.lu2008 import gantry as lu2008
from cogging.papers.xu2001 import epoxy_motor as xu2001_setup

AXIS = cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1 / 900, travel=[0.0, 0.51])
INTERVALS = {"axis.mass": (0.1, 0.2), "axis.viscous": (0.15, 0.35), "axis.coulomb": (0.1, 0.3)}


def model(**changes):
    fields = {"axis": AXIS, "intervals": INTERVALS, "encoder": cogging.EncoderParameters(resolution=0.5e-6)}
    return cogging.Model(**{**fields, **changes})


def three_harmonics(points=13):
    basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2, 3], control_points=points)
    shape = (3, points)
    rng = np.random.default_rng(1)
    return cogging.CoggingModel(basis, rng.uniform(-0.1, 0.1, shape), rng.uniform(-0.1, 0.1, shape))


def amplitude_intervals(cogging_model, width):
    return {
        f"cogging.{part}[{i}][{j}]": (float(value) - width, float(value) + width)
        for part in ("sine", "cosine")
        for (i, j), value in np.ndenumerate(getattr(cogging_model, part))
    }


# Intervals and where they come from -----------------------------------------------------------------------------------


def test_intervals_become_the_projection_set():
    force = three_harmonics()
    widths = INTERVALS | amplitude_intervals(force, 0.01) | {"effects.constant_force.force": (-0.5, 0.5)}
    bounds = cogging.Bounds.of(
        model(cogging=force, effects=[cogging.effects.ConstantForce(force=0.1)], intervals=widths)
    )
    assert (bounds.mass, bounds.viscous, bounds.coulomb) == ((0.1, 0.2), (0.15, 0.35), (0.1, 0.3))
    assert bounds.disturbance == pytest.approx((-0.5, 0.5))
    assert bounds.disturbance_estimate == 0.1
    largest = max(force.sine.max(), force.cosine.max())
    smallest = min(force.sine.min(), force.cosine.min())
    assert bounds.cogging == pytest.approx((smallest - 0.01, largest + 0.01))
    assert bounds.fallbacks == ()
    assert bounds.notes == ()

    parameters = bounds.adaptive_robust()
    assert parameters.mass_bounds == [0.1, 0.2]
    assert parameters.viscous_bounds == [0.15, 0.35]
    assert parameters.coulomb_bounds == [0.1, 0.3]
    assert parameters.disturbance_bounds == pytest.approx([-0.5, 0.5])
    assert parameters.cogging_bounds == pytest.approx(list(bounds.cogging))
    assert (parameters.mass, parameters.viscous, parameters.coulomb) == (0.12, 0.166, 0.15)
    assert parameters.disturbance == 0.1
    cogging.Dcarc(parameters)


def test_missing_intervals_fall_back_on_the_uncertainty_and_say_so():
    bounds = cogging.Bounds.of(model(intervals={"axis.mass": (0.1, 0.2)}, uncertainty={"viscous": 0.2, "coulomb": 0.0}))
    assert bounds.viscous == pytest.approx((0.166 * (1 - 1.96 * 0.2), 0.166 * (1 + 1.96 * 0.2)), rel=1e-4)
    assert bounds.coulomb == (0.15, 0.15)
    said = "\n".join(bounds.fallbacks)
    assert "axis.viscous: no interval in [bounds], 1.96 of its 20 % in [axis.uncertainty] counts" in said
    assert "axis.mass" not in said


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("axis.mass", "larger accelerations"),
        ("axis.viscous", "several speeds"),
        ("axis.coulomb", "slow travel"),
        ("cogging.sine[1][2]", "slowly over the whole travel"),
        ("effects.cable_spring.stiffness", "this effect acts"),
    ],
)
def test_an_infinite_interval_names_the_parameter_and_what_to_measure(path, words):
    machine = model(
        cogging=three_harmonics(),
        effects=[cogging.effects.CableSpring(stiffness=0.4)],
        intervals=INTERVALS | {path: (-math.inf, math.inf)},
    )
    with pytest.raises(ValueError, match=words) as error:
        cogging.Bounds.of(machine)
    assert str(error.value).startswith(f"{path}: the logs do not determine it, its interval is [-inf, inf]")
    default = {path: (0.05, 1.0)} if not path.startswith("cogging") else {"cogging": (-0.2, 0.2)}
    bounds = cogging.Bounds.of(machine, default=default)
    assert any(path in line or "amplitudes of the cogging" in line for line in bounds.fallbacks)


def test_the_longest_default_that_fits_counts():
    machine = model(cogging=three_harmonics(), intervals={})
    default = {"axis": (0.0, 1.0), "axis.mass": (0.05, 0.3), "cogging": (-0.2, 0.2), "cogging.sine[0]": (-0.4, 0.4)}
    bounds = cogging.Bounds.of(machine, default=default)
    assert bounds.mass == (0.05, 0.3)
    assert bounds.viscous == (0.0, 1.0)
    assert bounds.cogging == (-0.4, 0.4)


REFUSED = {
    "nothing known": (model(intervals={}), {}, r"axis\.mass: needs an interval in \[bounds\], a 1-sigma"),
    "value outside": (
        model(intervals=INTERVALS | {"axis.mass": (0.13, 0.2)}),
        {},
        r"axis\.mass: its interval \[0\.13, 0\.2\] must hold the model's value, got 0\.12",
    ),
    "mass down to zero": (
        model(intervals=INTERVALS | {"axis.mass": (-0.1, 0.2)}),
        {},
        r"axis\.mass: its interval must lie above 0 to design a controller, got \[-0\.1, 0\.2\]",
    ),
    "unknown path": (model(intervals={"axis.weight": (1, 2)}), {}, r"bounds\.axis\.weight: must be a parameter"),
    "unknown default": (model(), {"default": {"axle": (0, 1)}}, r"default\['axle'\]: must be a parameter"),
    "default in disorder": (model(), {"default": {"axis.mass": (1, 0)}}, r"default\['axis\.mass'\]: must be \(lower"),
    "infinite default": (model(), {"default": {"disturbance": (0, math.inf)}}, r"default\['disturbance'\]: must be"),
    "velocity": (model(), {"velocity_max": 0.0}, r"velocity_max: must be finite and above 0, got 0\.0"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refuses(case):
    machine, arguments, message = REFUSED[case]
    with pytest.raises(ValueError, match=f"^{message}"):
        cogging.Bounds.of(machine, **arguments)


# The disturbance ------------------------------------------------------------------------------------------------------

SINE = {"period": 0.02, "sine": 0.3, "cosine": 0.4}
FORCES = {
    "constant": (cogging.effects.ConstantForce(force=-0.3), -0.3, -0.3),
    "harmonic": (cogging.effects.CoggingHarmonic(**SINE), -0.5, 0.5),
    "drag at both speeds": (cogging.effects.QuadraticDrag(coefficient=0.3), -0.3 * 4, 0.3 * 4),
    "step that comes late": (cogging.effects.DisturbanceStep(force=0.5, start=22.0, stop=23.0), 0.0, 0.5),
    "fast tone": (cogging.effects.DisturbanceTone(frequency=53.1, sine=0.3, cosine=0.4), -0.5, 0.5),
    "viscous asymmetry": (cogging.effects.ViscousAsymmetry(difference=0.1), -0.1, 0.0),
    "Coulomb asymmetry": (cogging.effects.CoulombAsymmetry(difference=0.1), -0.05, -0.05),
    "Stribeck": (cogging.effects.StribeckFriction(static_excess=0.2, velocity=0.01), -0.2, 0.2),
}


@pytest.mark.parametrize("name", FORCES)
def test_disturbance_is_the_range_of_the_force(name):
    effect, low, high = FORCES[name]
    bounds = cogging.Bounds.of(model(effects=[effect]), default={"disturbance": (0.0, 0.0)}, velocity_max=2.0)
    if name == "viscous asymmetry":  # slopes B +- difference / 2: both directions push back or forward alike
        low, high = sorted((effect.force_at(velocity=2.0), 0.0))
        assert low == pytest.approx(-0.1)
    if name == "Coulomb asymmetry":  # + difference / 2 forward and - backward: the same push on both sides
        high = 0.0
        assert effect.friction_level_at(velocity=1.0) == -effect.friction_level_at(velocity=-1.0) == 0.05
    assert bounds.disturbance == pytest.approx((low, high), rel=3e-3, abs=1e-9)


def test_disturbance_adds_up():
    machine = model(
        effects=[cogging.effects.ConstantForce(force=0.1), cogging.effects.CableSpring(stiffness=1.0, center=0.255)],
        noise=cogging.NoiseParameters(force=0.01),
        intervals=INTERVALS
        | {"effects.constant_force.force": (0.0, 0.2), "effects.cable_spring.stiffness": (0.9, 1.1)},
    )
    reach = 0.255 * 1.1 + 0.1 + 1.96 * 0.01
    assert cogging.Bounds.of(machine).disturbance == pytest.approx((0.1 - reach, 0.1 + reach), rel=1e-4)
    more = cogging.Bounds.of(machine, default={"disturbance": (-1.0, 2.0)}).disturbance
    assert more == pytest.approx((0.1 - reach - 1.0, 0.1 + reach + 2.0), rel=1e-4)


def test_without_a_word_on_constant_forces_the_coulomb_level_counts():
    for effects in ([], [cogging.effects.ConstantForce(force=0.02)]):
        bounds = cogging.Bounds.of(model(effects=effects))
        middle = 0.02 if effects else 0.0
        assert bounds.disturbance == pytest.approx((middle - 0.3, middle + 0.3))
        assert any(note.startswith("disturbance: no interval says") for note in bounds.notes)
    assert cogging.Bounds.of(model(), default={"disturbance": (0.0, 0.0)}).disturbance == (0.0, 0.0)


def test_an_effect_on_the_command_is_not_within_the_disturbance_and_said_to_be_so():
    bounds = cogging.Bounds.of(model(effects=[cogging.effects.CommandDelay(delay=1e-3)]))
    assert any(note.startswith("effects.command_delay: acts on command or reading") for note in bounds.notes)


# Controllers ----------------------------------------------------------------------------------------------------------


def test_the_rule_gives_the_gains_of_lu2008():
    """From the X axis' mass, bounds and bandwidth alone: the printed gains, the adaptation within 4 %."""
    axis = lu2008.AXES["X"]
    printed = lu2008.controller_parameters(axis, "C3")
    bounds = cogging.Bounds.of(
        model(cogging=three_harmonics(), intervals=INTERVALS),
        default={"disturbance": (-0.5, 0.5), "cogging": (-0.1, 0.1)},
    )
    found = bounds.adaptive_robust(bandwidth=200.0)
    assert found.error_gain == printed.error_gain
    assert found.feedback_gain == pytest.approx(printed.feedback_gain)
    for name in ("mass", "viscous", "coulomb", "disturbance", "cogging"):
        assert getattr(found, f"{name}_bounds") == pytest.approx(getattr(printed, f"{name}_bounds"))
        assert getattr(found, f"{name}_adaptation") == pytest.approx(getattr(printed, f"{name}_adaptation"), rel=0.05)
    for name in ("pitch", "harmonics", "order", "origin", "control_points"):
        assert getattr(found, f"cogging_{name}") == getattr(printed, f"cogging_{name}")


@pytest.mark.parametrize(("mass_high", "viscous_high"), [(0.13, 100.0), (0.5, 5.0), (3.0, 0.2), (3.0, 100.0)])
def test_gains_are_admissible_without_slopes(mass_high, viscous_high):
    widths = INTERVALS | {"axis.mass": (0.01, mass_high), "axis.viscous": (0.0, viscous_high)}
    parameters = cogging.Bounds.of(model(intervals=widths)).adaptive_robust()
    assert min(cogging.desired_compensation_condition(parameters, friction_slope=0.0, cogging_slope=0.0)) > 0.0


def test_condition_looks_at_the_steepest_friction_and_cogging():
    bounds = cogging.Bounds.of(model(cogging=three_harmonics()), default={"cogging": (-0.1, 0.1)})
    gentle = bounds.adaptive_robust(coulomb_width=0.5)
    assert bounds.condition(gentle) > bounds.condition(bounds.adaptive_robust())
    expected = cogging.desired_compensation_condition(
        gentle,
        friction_slope=cogging.friction_slope_max(0.5),
        cogging_slope=cogging.cogging_slope_max(three_harmonics().basis, 0.1),
    )
    assert bounds.condition(gentle) == pytest.approx(expected)
    assert bounds.condition(bounds.adaptive_robust(coulomb_width=0.0)) == (-math.inf, -math.inf)


def test_periods_become_harmonics_of_a_common_pitch():
    basis = cogging.SplineHarmonics(periods=[0.024, 0.016])
    pitch, harmonics = pitch_and_harmonics(basis)
    assert (pitch, harmonics) == (pytest.approx(0.048), [2, 3])
    assert periods_of(basis) == pytest.approx([0.024, 0.016])
    assert periods_of(three_harmonics().basis) == pytest.approx([0.05, 0.025, 0.05 / 3])
    force = cogging.CoggingModel(basis, [[0.1], [0.2]], [[0.05], [-0.1]])
    parameters = cogging.Bounds.of(model(cogging=force)).adaptive_robust()
    controller = cogging.Dcarc(parameters)
    assert controller.command(reference=0.123, reading=0.123) == pytest.approx(force.force(0.123))
    with pytest.raises(ValueError, match=r"^cogging\.periods: must be whole fractions of one pitch"):
        pitch_and_harmonics(cogging.SplineHarmonics(periods=[0.024, 0.024 / math.pi]))
    with pytest.raises(ValueError, match=r"^cogging\.periods: must be whole fractions"):
        pitch_and_harmonics(cogging.SplineHarmonics(periods=[0.024, 0.016], pitch=0.05, control_points=4))


def test_pid_has_its_poles_for_the_smallest_mass_and_cascade_is_never_underdamped():
    pid = cogging.Bounds.of(model()).pid(bandwidth=150.0)
    np.testing.assert_allclose(cogging.pid_poles(pid.kp, pid.ki, pid.kd, 0.1), [-150.0] * 3, rtol=1e-4)
    assert (pid.mass, pid.viscous, pid.coulomb) == (0.12, 0.166, 0.15)
    parameters = cogging.Bounds.of(model()).cascade(bandwidth=150.0)
    np.testing.assert_allclose(np.roots([0.2, parameters.kv, parameters.kv * parameters.kp]), [-150] * 2, rtol=1e-6)
    for mass in (0.1, 0.15, 0.2):
        assert np.all(np.roots([mass, parameters.kv, parameters.kv * parameters.kp]).imag < 1e-3)
    machine = model(encoder=cogging.EncoderParameters())
    reference = {"type": "point_to_point", "start": 0.05, "distance": 0.4, "velocity": 0.5, "acceleration": 5.0}
    log = cogging.simulate(machine, reference, controller=cogging.Cascade(parameters))
    assert np.abs(log.error).max() < 0.05 * 0.5 / parameters.kp


def test_output_feedback_is_the_papers_at_its_bandwidth_and_mass():
    printed = xu2001_setup.arc_parameters()
    axis = cogging.AxisParameters(mass=1 / 30, viscous=1 / 3, coulomb=0.1, coulomb_width=1 / 900)
    exact = cogging.Model(axis, uncertainty={"mass": 0.0, "viscous": 0.0, "coulomb": 0.0})
    found = cogging.Bounds.of(exact).output_feedback(bandwidth=300.0, sample_rate=2500.0)
    gains = ("observer_gain_1", "observer_gain_2", "gain_1", "gain_2", "weight_1", "weight_2", "theta", "adaptation")
    for name in gains:
        assert getattr(found, name) == pytest.approx(getattr(printed, name)), name


def test_output_feedback_bounds_hold_every_quotient():
    bounds = cogging.Bounds.of(model(), default={"disturbance": (-0.5, 0.2)})
    parameters = bounds.output_feedback()
    rng = np.random.default_rng(0)
    for _ in range(200):
        mass, viscous, force = (
            rng.uniform(*interval) for interval in (bounds.mass, bounds.viscous, bounds.disturbance)
        )
        theta = np.array([1 / mass, viscous / mass, force / mass])
        assert np.all(theta >= parameters.theta_min)
        assert np.all(theta <= parameters.theta_max)


def test_observer_design_data():
    bounds = cogging.Bounds.of(model(cogging=three_harmonics()), default={"cogging": (-0.2, 0.2)})
    problem = bounds.observer_problem(0.1, 0.4, bandwidth=300.0, decay_rate=4.0)
    assert problem.periods == pytest.approx([0.05, 0.025, 0.05 / 3])
    assert (problem.velocity_min, problem.velocity_max, problem.decay_rate) == (0.1, 0.4, 4.0)
    assert problem.viscous == pytest.approx(0.166 / 0.12)
    assert (problem.omega, problem.pole_radius) == (300.0, 450.0)
    faster = bounds.observer_problem(0.1, 0.8, bandwidth=300.0)
    assert faster.pole_radius == pytest.approx(2.4 * 2 * math.pi * 0.8 * 3 / 0.05), "the harmonics are within the disk"
    with pytest.raises(ValueError, match=r"^cogging: must be in the model"):
        cogging.Bounds.of(model()).observer_problem(0.1, 0.5)
    with pytest.raises(ValueError, match=r"^velocity_min: must be above 0"):
        bounds.observer_problem(0.0, 0.5)


def test_sample_rate_and_overrides():
    own = cogging.PidParameters(sample_rate=2000.0)
    bounds = cogging.Bounds.of(model(controller=own, controller_type="pid"))
    assert bounds.adaptive_robust().sample_rate == 2000.0
    assert bounds.adaptive_robust().error_gain == 80.0, "sample_rate / 25 below 5 kHz"
    assert bounds.adaptive_robust(sample_rate=20_000.0).error_gain == 200.0
    assert bounds.pid(command_limit=3.0).command_limit == 3.0
    assert bounds.adaptive_robust(epsilon=0.1, mass_adaptation=0.0).mass_adaptation == 0.0
    assert bounds.cascade(kv=10.0).viscous == pytest.approx(10.0 + 0.166)
    for design in (bounds.adaptive_robust, bounds.output_feedback, bounds.pid, bounds.cascade):
        with pytest.raises(ValueError, match=r"^bandwidth: must be finite and above 0, got -1"):
            design(bandwidth=-1)
        with pytest.raises(TypeError):
            design(no_such_field=1.0)


def test_every_controller_holds_every_corner_of_the_bounds():
    """Machines at all corners of mass, viscous and Coulomb friction, with an offset: no run diverges or drifts."""
    machine = cogging.Bounds.of(
        model(cogging=three_harmonics()), default={"cogging": (-0.2, 0.2), "disturbance": (-0.3, 0.3)}
    )
    reference = cogging.PointToPoint(
        cogging.PointToPointParameters(start=0.1, distance=0.2, velocity=0.4, acceleration=8.0, jerk=800.0)
    )
    designs = {
        "pid": cogging.Pid(machine.pid()),
        "cascade": cogging.Cascade(machine.cascade()),
        "arc": cogging.Arc(machine.adaptive_robust()),
        "dcarc": cogging.Dcarc(machine.adaptive_robust()),
        "output_feedback_arc": cogging.OutputFeedbackArc(machine.output_feedback()),
    }
    problem = machine.observer_problem(0.1, 0.4)
    certified = cogging.design_observer(problem)
    parameters = machine.observer_based(problem, certified, command_limit=50.0)
    assert parameters.observer_gain == certified.observer_gain.tolist()
    assert (parameters.position_gain, parameters.command_limit) == (200.0**2, 50.0)
    cogging.ObserverBased(parameters)
    for corner in itertools.product(machine.mass, machine.viscous, machine.coulomb):
        axis = AXIS.replace(**dict(zip(("mass", "viscous", "coulomb"), corner, strict=True)))
        offset = [cogging.effects.ConstantForce(force=0.2)]
        truth = cogging.Plant(axis, cogging=three_harmonics(), effects=offset)
        for name, controller in designs.items():
            log = cogging.closed_loop(truth, controller, reference)
            assert np.abs(log.position - log.reference).max() < 5e-3, (name, corner)


def test_infinite_intervals_survive_a_file(tmp_path):
    machine = model(intervals=INTERVALS | {"axis.coulomb_width": (-math.inf, math.inf)})
    machine.write(tmp_path / "model.toml")
    again = cogging.Model.read(tmp_path / "model.toml")
    assert again.intervals == machine.intervals
    assert cogging.Bounds.of(again).mass == (0.1, 0.2), "the width of the friction is no bound"


def test_cogging_estimates_are_the_models():
    """A controller that believes the truth pushes back the whole cogging: its command holds the axis."""
    force = three_harmonics(points=13)
    parameters = cogging.Bounds.of(model(cogging=force)).adaptive_robust()
    assert parameters.cogging_estimates == force.coefficients.tolist()
    for position in (0.03, 0.2, 0.444):
        controller = cogging.Dcarc(parameters)
        assert controller.command(reference=position, reading=position) == pytest.approx(force.force(position))


def test_output_feedback_scales_with_the_units_of_command_and_time():
    """A mass in other units or a bandwidth in other seconds: the same motion, where nothing else sets a scale."""
    reference = {"type": "filtered_sine", "amplitude": 0.05, "frequency": 0.5, "duration": 2.0}
    errors = []
    for unit in (1.0, 7.0):
        axis = cogging.AxisParameters(mass=0.12 * unit, viscous=0.166 * unit, travel=[-0.5, 0.5])
        machine = cogging.Model(axis, uncertainty={"mass": 0.1, "viscous": 0.1, "coulomb": 0.0})
        parameters = cogging.Bounds.of(machine, default={"disturbance": (-unit, unit)}).output_feedback()
        errors.append(cogging.simulate(machine, reference, controller=cogging.OutputFeedbackArc(parameters)).error)
    np.testing.assert_allclose(errors[0], errors[1], rtol=1e-4, atol=1e-12)
