"""Large effects: found in the force balance of machines of any size, within what the model states to know."""

import numpy as np
import pytest

import cogging
from cogging.diagnosis.candidates.signatures import vocabulary_of
from cogging.diagnosis.entries import Gap, NamedEffect
from cogging.diagnosis.evidence.allowance import allowance
from cogging.diagnosis.large.balance import balances_of
from cogging.diagnosis.large.nuisances import bounded, nuisances_of, products_of
from cogging.diagnosis.large.search import search_large
from cogging.diagnosis.large.spectrum import peaks
from cogging.diagnosis.naming.large_names import common_pitch, map_note, unsettled
from cogging.diagnosis.search.large_start import added
from cogging.effects.effect import VOCABULARY

RATE = 500.0


class Machine:
    """A machine of drawn size, its model that knows mass and friction badly, and its logs of two motions."""

    def __init__(self, seed, known=None, spread=1.0, travel=None):
        random = np.random.default_rng(seed)
        self.random = random
        self.force = 10.0 ** random.uniform(-1.0, 2.0)  # V, what the command is like
        self.travel = 10.0 ** random.uniform(-1.0, 1.0)
        self.travel = travel or self.travel
        self.speed = self.travel / random.uniform(1.5, 3.0)
        acceleration = self.speed / random.uniform(0.15, 0.4)
        self.axis = cogging.AxisParameters(
            mass=0.25 * self.force / acceleration,
            viscous=0.1 * self.force / self.speed,
            coulomb=0.15 * self.force,
            coulomb_width=0.01 * self.speed,
            travel=[-0.6 * self.travel, 0.6 * self.travel],
        )
        wrong = np.exp(spread * random.uniform(-np.log(2.0), np.log(2.0), 3))
        self.model = cogging.Model(
            axis=self.axis.replace(
                mass=self.axis.mass * wrong[0],
                viscous=self.axis.viscous * wrong[1],
                coulomb=self.axis.coulomb * wrong[2],
            ),
            encoder=cogging.EncoderParameters(resolution=1e-6 * self.travel),
            uncertainty={} if known is None else known,
        )
        self.acceleration = acceleration

    def log(self, *effects, seed, share=1.0, repeats=2):
        """A run under a cascade that the model does not know, without columns of the reference."""
        stiffness = 20.0 * self.force / self.travel
        true = cogging.Model(
            axis=self.axis,
            encoder=self.model.encoder,
            effects=effects,
            noise=cogging.NoiseParameters(force=2e-3 * self.force, bandwidth=40.0),
            controller=cogging.PidParameters(
                sample_rate=RATE, kp=stiffness, ki=2.0 * stiffness, kd=0.1 * stiffness * self.travel / self.speed
            ),
            controller_type="pid",
        )
        motion = cogging.PointToPoint(
            cogging.PointToPointParameters(
                start=-0.45 * self.travel,
                distance=0.9 * self.travel,
                velocity=share * self.speed,
                acceleration=share * self.acceleration,
                jerk=20.0 * self.acceleration,
                dwell=0.1,
                repeats=repeats,
            )
        )
        run = cogging.simulate(true, motion, seed=seed)
        return cogging.Log(run.time, run.position, run.command)

    def effect(self, name):
        """An effect that makes about as much force as all else."""
        size, random = self.force * self.random.choice([-0.8, 0.8]), self.random
        turn = random.uniform(0.0, 2.0 * np.pi)
        wave = {"sine": abs(size) * np.cos(turn), "cosine": abs(size) * np.sin(turn)}
        period = self.travel / random.uniform(4.0, 25.0)
        fields = {
            "constant_force": {"force": size},
            "cable_spring": {"stiffness": abs(size) / (0.3 * self.travel), "center": 0.1 * self.travel},
            "cogging_harmonic": {"period": period, **wave},
            "end_effect": {"force": abs(size) * 1.5, "decay_length": 0.08 * self.travel},
            "local_force": {"force": 3.0 * size, "center": 0.13 * self.travel, "width": 0.04 * self.travel},
            "gravity": {"moment": abs(size), "angle": turn - np.pi},
            "force_constant_ripple": {"period": period, "sine": 0.35, "cosine": 0.2},
            "viscous_asymmetry": {"difference": 0.8 * size / self.speed},
            "quadratic_drag": {"coefficient": abs(size) / self.speed**2},
            "stribeck_friction": {"static_excess": 0.8 * abs(size), "velocity": 0.4 * self.speed, "exponent": 1.0},
        }[name]
        return VOCABULARY[name].replace(**fields)


def searched(machine, logs, confirm=(), *, any_size=True):
    balances = balances_of(logs, machine.model)
    elsewhere = balances_of(confirm, machine.model) if confirm else None
    allowed = allowance(machine.model)
    vocabulary = vocabulary_of(machine.model)
    return search_large(balances, elsewhere, allowed, vocabulary, lambda step: None, any_size=any_size)


NAMES = ["constant_force", "cable_spring", "cogging_harmonic", "end_effect", "force_constant_ripple"]
NAMES += ["viscous_asymmetry", "quadratic_drag", "stribeck_friction", "local_force"]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", [3, 4])
def test_the_effect_that_makes_most_of_the_command_is_the_first(name, seed):
    machine = Machine(100 * seed + NAMES.index(name))
    effect = machine.effect(name)
    found = searched(machine, [machine.log(effect, seed=1)], [machine.log(effect, seed=2, share=0.6)])
    assert found is not None
    term = found.terms[0]
    assert name in {term.trial.name, *term.alternatives}
    # Levels stay where the model says that they may be, unless one was let go; what is left is little, here and there.
    limits = allowance(machine.model)
    gone = {term.trial.path for term in found.terms}
    for level in ("mass", "viscous", "coulomb"):
        path = f"axis.{level}"
        assert path in gone or limits.inside(path, getattr(found.model.axis, level))
    assert found.balances.rms < 0.25 * found.start.rms
    assert found.confirm.rms < 0.4 * found.confirm_start.rms


@pytest.mark.parametrize("turns", [0.8, 1.2, 4.0])
def test_a_wave_of_one_turn_is_gravity_where_the_axis_turns_and_nowhere_else(turns):
    machine = Machine(round(70 * turns), travel=2.0 * np.pi * turns)
    effect = machine.effect("gravity")
    logs = [machine.log(effect, seed=1)], [machine.log(effect, seed=2, share=0.6)]
    assert "gravity" not in vocabulary_of(machine.model)
    straight = searched(machine, *logs)
    assert straight is None or "gravity" not in [term.trial.name for term in straight.terms]
    machine.model = machine.model.replace(units=cogging.Units(command="Nm", position="rad"))
    found = searched(machine, *logs)
    term = found.terms[0]
    assert term.trial.name == "gravity"
    assert "cogging_harmonic" not in [*term.alternatives, *(one.trial.name for one in found.terms)]
    (fitted,) = (one for one in found.model.effects if one.NAME == "gravity")
    assert fitted.moment == pytest.approx(effect.moment, rel=0.1)
    assert np.cos(fitted.angle - effect.angle) > 0.99


@pytest.mark.parametrize("name", ["cogging_harmonic", "force_constant_ripple", "constant_force"])
def test_what_is_added_has_all_its_amplitudes(name):
    """Which the verdict asks of an effect that is refused in the end."""
    machine = Machine(300 + NAMES.index(name))
    found = searched(machine, [machine.log(machine.effect(name), seed=1)])
    place, term = next((k, one) for k, one in enumerate(found.effects) if one.trial.name == name)
    finding = added(term, place, found).finding
    candidate = finding.candidate
    assert len(finding.amplitudes) == max(1, len(candidate.amplitudes))
    for field, index in candidate.amplitudes:
        both = finding.effect(), term.trial.effect
        there, tried = (np.ravel(getattr(effect, field))[index or 0] for effect in both)
        assert there == tried


@pytest.mark.parametrize("seed", range(6))
def test_nothing_large_is_found_where_only_levels_are_wrong(seed):
    machine = Machine(40 + seed)
    assert searched(machine, [machine.log(seed=1)], [machine.log(seed=2, share=0.6)], any_size=False) is None


@pytest.mark.parametrize("seed", range(3))
def test_a_mass_beyond_what_is_stated_is_a_change_of_mass(seed):
    machine = Machine(60 + seed, known={"mass": 0.02, "viscous": 0.3, "coulomb": 0.3}, spread=0.0)
    machine.model = machine.model.replace(axis=machine.axis.replace(mass=machine.axis.mass / 2.5))
    found = searched(machine, [machine.log(seed=1)], [machine.log(seed=2, share=0.6)])
    assert [term.trial.name for term in found.terms] == ["mass_change"]
    assert found.model.axis.mass == pytest.approx(machine.axis.mass, rel=0.05)
    assert found.start.model.axis.mass <= machine.model.axis.mass * (1.0 + 4.2 * 0.02) * 1.0001


def test_levels_that_are_stated_to_be_exact_do_not_move():
    machine = Machine(70, known={"mass": 0.0, "viscous": 0.0, "coulomb": 0.0}, spread=0.0)
    effect = machine.effect("cogging_harmonic")
    found = searched(machine, [machine.log(effect, seed=1)])
    assert found.model.axis == machine.model.axis
    assert found.terms[0].trial.name == "cogging_harmonic"


def test_what_a_statement_leaves_open():
    axis = cogging.AxisParameters(mass=2.0, viscous=0.0, coulomb=3.0)
    allowed = allowance(cogging.Model(axis=axis, uncertainty={"coulomb": 0.1}))
    assert dict(allowed.floors) == pytest.approx({"axis.mass": 2.0 / 3.0, "axis.coulomb": 1.74, "axis.viscous": 0.0})
    assert dict(allowed.ceilings) == pytest.approx({"axis.mass": 6.0, "axis.coulomb": 4.26})
    assert [allowed.at_end("axis.mass", value) for value in (6.0, 5.9, 2.0 / 3.0)] == [True, False, True]
    assert allowed.nearest("axis.mass", 1e9) == 6.0
    free = allowed.without(("axis.mass",))
    assert [free.inside("axis.mass", value) for value in (100.0, 1e3, 0.0)] == [True, False, False]
    exact = allowance(cogging.Model(axis=axis, uncertainty={"mass": 0.0}))
    assert exact.exact == ("axis.mass",)
    assert not exact.inside("axis.mass", 2.001)


@pytest.mark.parametrize("first", range(0, 200, 50))
def test_bounded_least_squares_is_that_of_scipy(first):
    from scipy.optimize import lsq_linear

    for seed in range(first, first + 50):
        random = np.random.default_rng(seed)
        p = int(random.integers(1, 9))
        columns = random.normal(size=(p, 150)) * 10.0 ** random.uniform(-3.0, 3.0, (p, 1))
        if p > 1 and random.random() < 0.3:  # two nearly alike
            columns[0] = columns[1] * random.uniform(0.5, 2.0) + 1e-3 * columns[0]
        size = np.linalg.norm(columns, axis=1)
        residual = random.normal(size=150) + random.uniform(0.0, 3.0) * np.sum(columns / size[:, None], axis=0)
        reach = np.linalg.norm(residual) / size
        low, high = (reach * 10.0 ** random.uniform(-3.0, 1.0, p) for _ in range(2))
        low, high = np.where(random.random(p) < 0.2, 0.0, -low), np.where(random.random(p) < 0.2, np.inf, high)
        rows = np.vstack([columns, residual])
        weights, left = bounded(products_of(rows, rows), low, high)
        scaled = (columns / size[:, None]).T
        other = lsq_linear(scaled, -residual, (low * size - 1e-12, high * size), method="bvls", tol=1e-14)
        assert left == pytest.approx(2.0 * other.cost, rel=1e-6), seed
        assert left == pytest.approx(float(np.sum((residual + weights @ columns) ** 2)), rel=1e-9), seed
        assert np.all((low <= weights) & (weights <= high)), seed


def test_a_balance_closes_for_the_true_machine_and_tells_commands():
    machine = Machine(80, spread=0.0)
    for effect in (machine.effect("force_constant_ripple"), VOCABULARY["actuator_lag"].replace(time_constant=0.02)):
        log = machine.log(effect, seed=1)
        right = balances_of([log], machine.model.replace(effects=(effect,)))
        wrong = right.under(machine.model)
        assert right.rms < 0.25 * wrong.rms
    # An effect that takes the command away leaves nothing to explain, and explains nothing.
    dead = VOCABULARY["command_dead_zone"].replace(width=0.99 * float(np.abs(log.command).max()))
    assert right.under(machine.model.replace(effects=(dead,))).rms > wrong.rms


def test_the_inertia_of_a_load_is_that_of_the_simulated_one():
    mode = VOCABULARY["flexible_mode"].replace(frequency=40.0, damping_ratio=0.05, mass_ratio=0.4)
    random = np.random.default_rng(5)
    time = np.arange(4000) / 1000.0
    command = sum(np.cos(2.0 * np.pi * f * time + random.uniform(0.0, 6.3)) for f in np.arange(2.0, 90.0, 1.3))
    axis = cogging.AxisParameters(mass=0.02, viscous=0.2)
    run = cogging.closed_loop(
        cogging.Plant(axis=axis, effects=[mode]),
        OpenLoop(command, 1000.0),
        cogging.Sampled(time, np.zeros_like(time)),
        duration=3.999,
    )
    log = cogging.Log(run.time, run.position, run.command)
    right = balances_of([log], cogging.Model(axis=axis, effects=(mode,)))
    rigid = right.under(cogging.Model(axis=axis))
    assert right.rms < 0.03 * right.command < 0.1 * rigid.rms
    found = search_large(rigid, None, allowance(rigid.model), VOCABULARY, lambda step: None)
    assert found.terms[0].trial.name == "flexible_mode"
    (seen,) = found.model.effects
    assert seen.frequency == pytest.approx(40.0, rel=0.01)
    assert seen.mass_ratio == pytest.approx(0.4, abs=0.02)


class OpenLoop:
    """A controller that plays a record."""

    def __init__(self, record, sample_rate):
        self.record, self.sample_rate, self.row = record, sample_rate, 0

    def reset(self):
        self.row = 0

    def command(self, reference, reading):
        self.row += 1
        return float(self.record[min(self.row - 1, len(self.record) - 1)])


@pytest.mark.parametrize("seed", range(4))
def test_waves_are_found_where_they_are(seed):
    machine = Machine(90 + seed)
    balances = balances_of([machine.log(seed=1)], machine.model)
    place = balances.joined([source.balance.dynamics.motion.middle_position for source in balances.sources])
    wave = machine.random.uniform(3.0, 30.0) / machine.travel
    found = peaks(balances, np.sin(2.0 * np.pi * wave * place + 1.0), 1, spatial=True)
    assert found[0] == pytest.approx(wave, abs=0.5 / machine.travel)


def test_harmonics_of_one_pitch_are_a_map():
    assert common_pitch([0.05, 0.025, 0.05 / 3.0]) == pytest.approx(0.05)
    assert common_pitch([2.0 * np.pi / n * f for n, f in ((7, 1.0005), (12, 0.9995), (28, 1.0))]) == pytest.approx(
        2.0 * np.pi, rel=1e-3
    )
    assert common_pitch([0.05, 0.05 / np.pi, 0.05 / np.e**2, 0.05 / np.sqrt(7.0)]) is None
    wave = VOCABULARY["cogging_harmonic"]
    model = Machine(1).model
    waves = [wave.replace(period=0.06 / n, sine=1.0 / n, cosine=0.0) for n in (1, 2, 3)]
    assert "pitch = 0.06 and harmonics = [1, 2, 3]" in map_note(waves, model)
    assert map_note(waves[:2], model) is None


def test_waves_are_told_as_harmonics_of_the_known_pitch():
    wave, basis = VOCABULARY["cogging_harmonic"], cogging.SplineHarmonics(pitch=0.024, harmonics=[1, 3])
    model = Machine(1).model.replace(cogging=cogging.CoggingModel(basis, np.ones((2, 1)), np.ones((2, 1))))
    note = map_note([wave.replace(period=0.01201, sine=1.0), wave.replace(period=0.001999, sine=1.0)], model)
    assert "the 2nd harmonic of your 24 mm pitch and the 12th harmonic of your 24 mm pitch" in note
    assert "harmonics = [1, 2, 3, 12]" in note
    assert map_note([wave.replace(period=0.0155, sine=1.0)], model) is None


def test_the_nuisances_are_the_free_ones():
    machine = Machine(2, known={"mass": 0.0})
    nuisances = nuisances_of(balances_of([machine.log(seed=1)], machine.model), allowance(machine.model))
    assert nuisances.paths == ("axis.viscous", "axis.coulomb")
    assert np.all(nuisances.low <= 0.0)
    assert np.all(nuisances.high >= 0.0)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_diagnosis_in_the_large(seed):
    """Gap as given, re-tuned and after; nothing grows; nominal levels within what is stated; the name and its size."""
    machine = Machine(200 + seed, known={"mass": 0.2, "viscous": 0.3, "coulomb": 0.3}, spread=0.2)
    effect = machine.effect("cogging_harmonic")
    result = cogging.diagnose(
        machine.log(effect, seed=1), machine.model, confirm=machine.log(effect, seed=2, share=0.6)
    )
    assert result.effects[0].name == "cogging_harmonic"
    assert result.effects[0].confidence >= 0.9
    found = result.effects[0].parameters
    assert found["period"].value == pytest.approx(effect.period, rel=2e-3)
    size = np.hypot(found["sine"].value, found["cosine"].value)
    assert size == pytest.approx(np.hypot(effect.sine, effect.cosine), rel=0.05)
    gap = result.gap
    assert gap.given >= gap.before > 5.0 * gap.after
    assert gap.confirm_after < 0.2 * gap.confirm_before
    assert gap.to_dict()["given"] == gap.given
    assert f"{gap.given:.4g} V as given" in result.text()
    limits = allowance(machine.model)
    for level in ("mass", "viscous", "coulomb"):
        assert limits.inside(f"axis.{level}", getattr(result.nominal.axis, level))
        assert result.to_dict()["nominal"][f"axis.{level}"]["stated"] == getattr(machine.model.axis, level)


def test_amplitudes_of_either_sign_are_never_far_outside_what_is_allowed():
    """Of what the statement says nothing: a known cogging whose sine is negative asks for no large effect."""
    allowed = allowance(Machine(2).model)
    assert not any(allowed.far_outside("cogging.sine[0][0]", value) for value in (-1e3, -1e-6, 0.0, 1e3))
    mass = Machine(2).model.axis.mass
    assert not allowed.far_outside("axis.mass", mass)
    assert allowed.far_outside("axis.mass", 100.0 * mass)
    assert allowed.far_outside("axis.mass", 0.01 * mass)


@pytest.mark.parametrize(
    ("after", "floor", "sure"), [(0.1, 0.001, True), (0.3, 0.25, True), (0.3, 0.1, False), (0.9, 0.1, False)]
)
def test_no_large_name_is_sure_while_much_of_the_gap_is_left(after, floor, sure):
    gap = Gap("V", floor, 1.0, after, None, None, "force balance")
    names = [NamedEffect(name, (), 0.97, {}, {}, 900.0, -400.0) for name in ("command_saturation", "mass_change")]
    saturation, change = unsettled(names, gap)
    assert (saturation.confidence >= 0.9) is sure
    assert change.confidence == 0.97
