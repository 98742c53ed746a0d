"""What a log says about itself, whether the stated controller made it, hints that bear on a verdict, and its clock."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import cogging
from cogging import Log
from cogging.log_check.controller_samples import on_its_clock
from cogging.log_check.log_audit import hints
from cogging.model.model import CONTROLLERS
from tests.fixtures import moving_axis, pid_axis
from tests.fixtures.strokes import as_believed, drawn

LIMITS = {"velocity": 0.2, "acceleration": 5.0, "jerk": 500.0, "dwell": 0.1}
REFERENCE = {"type": "point_to_point", "start": 0.1, "distance": 0.05, **LIMITS}
PID = cogging.PidParameters(kp=9600.0, ki=1e5, kd=48.0)
FULL = PID.replace(mass=0.12, viscous=0.16, coulomb=0.15, coulomb_width=2e-3)
CASCADE = cogging.CascadeParameters(sample_rate=5000.0, kp=150.0, kv=40.0, mass=0.12)
CASCADE = CASCADE.replace(viscous=0.1, coulomb=0.1, coulomb_width=2e-3)


def make(parameters=PID, kind="pid"):
    return pid_axis.MODEL.replace(noise=cogging.NoiseParameters(), controller=parameters, controller_type=kind)


@pytest.fixture(scope="module")
def log():
    return cogging.simulate(make(), REFERENCE)


def test_time_base():
    rng = np.random.default_rng(0)
    steps = np.full(9999, 1e-3)
    steps[rng.choice(9999, 300, replace=False)] *= 1.0 + 0.05 * rng.choice([-1.0, 1.0], 300)
    steps[5000] = 0.2
    time = np.concatenate([[0.0], np.cumsum(steps)])
    found = cogging.audit(cogging.Log(time, np.sin(time), np.cos(time)))
    assert found.rate == pytest.approx(1000.0)
    assert found.jitter_share == pytest.approx(0.03, abs=0.001)
    assert found.jitter_rms == pytest.approx(5e-5 * np.sqrt(0.03), rel=0.05)
    assert (found.gaps, found.repeated_times) == (1, 0)
    assert found.gap_longest == pytest.approx(0.2)
    assert found.gap_times == (pytest.approx(time[5000]),)
    assert found.speed[1] == pytest.approx(1.0, abs=0.01), "the gap is no motion"


@pytest.mark.parametrize("kind", ["exact", "spurious readings", "written with 9 digits", "single precision"])
def test_encoder_quantum(kind):
    time = np.arange(30000) * 1e-3
    for quantum in [1e-6, 1e-6 / 3.0, 2.0 * np.pi / 20000] + [5e-8, 2e-10] * (kind != "single precision"):
        rng = np.random.default_rng(1)
        x = 0.25 + 0.2 * np.sin(time) + 1e-7 * rng.normal(size=30000)
        readings, expected = quantum * np.round(x / quantum), quantum
        if kind == "spurious readings":
            readings += (rng.random(30000) < 0.0002) * 0.4 * quantum
        elif kind == "written with 9 digits":
            readings, expected = np.round(readings, 9), max(quantum, 1e-9)
        elif kind == "single precision":
            readings = readings.astype(np.float32).astype(float)
        assert cogging.audit(cogging.Log(time, readings, x)).encoder_quantum == pytest.approx(expected, rel=1e-3)
    ideal = np.cumsum(np.random.default_rng(2).normal(size=30000)) * 1e-5
    assert cogging.audit(cogging.Log(time, ideal, x)).encoder_quantum == 0.0


def test_motion_command_and_outliers(log):
    limited = cogging.simulate(make(PID.replace(command_limit=0.3)), REFERENCE)
    found = cogging.audit(limited)
    assert found.encoder_quantum == pytest.approx(0.5e-6)
    assert found.travel == (limited.position.min(), limited.position.max())
    assert found.speed[1] == pytest.approx(limited.true_velocity.max(), rel=0.05)
    assert 1.0 < found.acceleration[1] < 6.0, "not the encoder's noise, differentiated twice: 12500 m/s^2 a count"
    plateau = np.abs(limited.command) == 0.3
    assert plateau.sum() > 20
    assert found.saturation_share == pytest.approx(plateau.mean(), abs=0.01)
    assert found.outliers == 0
    free = cogging.audit(log)
    assert free.saturation_share == 0.0
    assert free.share_at_rest == pytest.approx(0.2 / 0.8, abs=0.1)
    assert free.controller is None
    position = log.position.copy()
    position[[700, 1500]] += [3e-3, -2e-3]
    spoiled = cogging.audit(cogging.Log(log.time, position, log.command))
    assert (spoiled.outliers, spoiled.outlier_rows, spoiled.travel) == (2, (700, 1500), free.travel)


@pytest.mark.parametrize("kind", sorted(CONTROLLERS))
def test_the_replay_of_a_controller_is_its_run(kind):
    """Every controller, whatever its parameters mean: what it commanded, to the bit."""
    struct, made = CONTROLLERS[kind]
    motion = cogging.Sine(cogging.SineParameters(center=0.2, amplitude=1e-3, frequency=1.0))
    log = cogging.simulate(make(struct(), kind), motion, duration=0.05)
    # The previews of a controller that looks ahead come from the rows, whose last ones see the end of the log.
    names = ("time", "reference", "reference_velocity", "reference_acceleration", "position")
    command = cogging.replay_controller(made(struct()), **{name: getattr(log, name) for name in names})
    if hasattr(made, "preview"):
        np.testing.assert_allclose(command[:-2], log.command[:-2], rtol=0, atol=1e-6 * np.abs(log.command).max())
    else:
        np.testing.assert_array_equal(command, log.command)
    with pytest.raises(ValueError, match="position: must be as long as time"):
        cogging.replay_controller(made(struct()), time=log.time, reference=log.reference, position=log.position[1:])


@pytest.mark.parametrize("first", [0, 1300])
@pytest.mark.parametrize(
    ("parameters", "kind"),
    [(FULL, "pid"), (FULL.replace(feedforward_velocity="measured"), "pid"), (CASCADE, "cascade")],
)
def test_a_controller_that_made_the_log_is_confirmed_and_recovered(parameters, kind, first):
    model = make(parameters, kind)
    log = cogging.simulate(model, REFERENCE)[first:]
    check = cogging.check_controller(log, model)
    assert check.reproduces
    assert check.relative < 1e-10
    assert (check.best_shift, check.ratio) == (0, pytest.approx(1.0))
    for name, stated in check.stated.items():
        assert stated == getattr(parameters, name)
        assert check.fitted[name] == pytest.approx(stated, rel=1e-4)
    if kind == "pid" and first:
        assert abs(check.start) > 1e-3, "the integral at the cut"
    found = cogging.recover_controller(log)
    assert found.type == kind
    assert found.residual_rms < 1e-6
    for name, value in parameters.to_dict().items():
        if isinstance(value, float):
            assert getattr(found.parameters, name) == pytest.approx(value, rel=1e-4, abs=1e-9), name


def test_a_command_limit_and_its_anti_windup_are_replayed():
    model = make(PID.replace(command_limit=0.3))
    check = cogging.check_controller(cogging.simulate(model, REFERENCE), model)
    assert check.reproduces
    assert check.relative < 1e-12


def test_a_stated_controller_that_did_not_make_the_log(log):
    check = cogging.check_controller(log, make(PID.replace(kd=60.0)))
    assert check.reproduces is False
    assert check.fitted["kd"] == pytest.approx(48.0, rel=1e-6)
    assert check.fitted_rms < 1e-10
    late = cogging.Log(log.time[:-2], log.position[:-2], log.command[2:], log.reference[:-2])
    assert cogging.check_controller(late, make()).best_shift == -2
    check = cogging.check_controller(cogging.Log(log.time, log.position, 0.5 * log.command, log.reference), make())
    assert (check.reproduces, check.ratio) == (False, pytest.approx(0.5))
    assert any("in another unit" in note for note in check.notes)


def test_what_cannot_be_checked_or_recovered(log):
    bare = cogging.Log(log.time, log.position, log.command)
    assert cogging.check_controller(log, make().replace(controller=None, controller_type=None)) is None
    for part, note in ((bare, "no reference"), (log[::5], "1000 rows a second")):
        check = cogging.check_controller(part, make())
        assert check.reproduces is None
        assert note in check.notes[0]
    basis = cogging.SplineHarmonics(pitch=0.02, harmonics=[1, 2])
    other = make(cogging.ObserverBasedParameters(mass=0.12, periods=[0.02]), "observer_based")
    other = other.replace(cogging=cogging.CoggingModel(basis, [[0.1], [0.2]], [[0.0], [0.1]]))
    noise = 0.02 * np.random.default_rng(3).normal(size=len(log))
    noisy = cogging.Log(log.time, log.position, log.command + noise, log.reference)
    for part in (bare, noisy, cogging.simulate(other, REFERENCE)):
        assert cogging.recover_controller(part) is None


ROW, RANDOM = 1.0 / moving_axis.RATE, np.random.default_rng(5).uniform(-1.0, 1.0, 10_000)
UNCONTROLLED = moving_axis.machine().replace(controller=None, controller_type=None)


@pytest.fixture(scope="module")
def moved():
    return moving_axis.record(moving_axis.machine(), 3)


def rest(log, share):
    """The log with so many rows at rest after it."""
    more = int(len(log) * share / (1.0 - share))
    time = np.concatenate([log.time, log.time[-1] + ROW * np.arange(1, more + 1)])
    position = np.concatenate([log.position, np.full(more, log.position[-1])])
    return Log(time, position, np.concatenate([log.command, np.zeros(more)]))


#: How a log is changed, how much a hint needs, and what is too little for one.
CASES = {
    "limit": (lambda log, much: replace(log, command=np.clip(log.command, -much, much)), 2.0, 50.0),
    "at rest": (rest, 0.8, 0.1),
    "missing": (lambda log, much: log[np.arange(len(log)) % 100 >= much], 8, 0),
    "uneven": (lambda log, much: replace(log, time=log.time + much * ROW * RANDOM[: len(log)]), 0.2, 0.001),
    "step by": (lambda log, much: replace(log, position=much * np.round(log.position / much)), 1e-6, 1e-7),
}


@pytest.mark.parametrize("words", CASES)
def test_a_hint_is_given_where_it_matters(words, moved):
    change, much, little = CASES[words]
    many, few = (hints(cogging.audit(change(moved, size)), UNCONTROLLED) for size in (much, little))
    (hint,) = [one for one in many if words in one]
    assert any(character.isdigit() for character in hint)
    assert not any(words in one for one in few)
    assert hints(cogging.audit(moved), UNCONTROLLED) == []


def test_identify_repeats_a_hint(moved):
    coarse = replace(moved, position=1e-6 * np.round(moved.position / 1e-6))
    found = cogging.identify(coarse, UNCONTROLLED, free=["axis.mass"])
    assert any("readings step by 1e-06 m" in note for note in found.notes)


def test_a_time_in_ms_names_the_option_whatever_ends_the_call(moved):
    """No controller or reference betrays it."""
    try:
        notes = cogging.diagnose(Log(1e3 * moved.time, moved.position, moved.command), UNCONTROLLED).notes
    except cogging.DivergedError as error:
        notes = (str(error),)
    assert "--scale time=0.001" in " ".join(notes)


# Noisy stamps of an even clock, and rows that were really sampled at uneven times: which is which -------------------

STEP = 1e-3  # s


@pytest.fixture(scope="module")
def strokes():
    return drawn(1, "nothing")


def jitter(log, seed=0, share=0.3):
    time = log.time + share * STEP * np.random.default_rng(seed).uniform(-1.0, 1.0, len(log))
    return replace(log, time=np.maximum.accumulate(time))


def taken_at(log, time):
    """The same motion, read and logged at other times."""
    acted = np.append(0.0, np.cumsum(log.command * STEP))
    upto = np.interp(np.append(time, time[-1] + STEP), np.append(log.time, log.time[-1] + STEP), acted)
    position = np.round(CubicSpline(log.time, log.position)(time) / 2e-7) * 2e-7
    reference = CubicSpline(log.time, log.reference)(time)
    return cogging.Log(time, position, np.diff(upto) / np.diff(np.append(time, time[-1] + STEP)), reference)


#: How the stamps of an even clock are spoiled, and by how much of a step the clock that is found may be off.
SPOILED = {
    "slightly noisy": (lambda log: jitter(log, share=0.05), 0.02),
    "noisy": (jitter, 0.02),
    "rounded": (lambda log: replace(log, time=np.round(log.time / 3e-4) * 3e-4), 0.2),
}


@pytest.mark.parametrize("kind", SPOILED)
def test_spoiled_stamps_give_way_to_the_clock(strokes, kind):
    """Which counts the rows that were lost."""
    spoil, off = SPOILED[kind]
    log, kept = strokes[1], np.ones(len(strokes[1]), dtype=bool)
    found, note = on_its_clock(spoil(log))
    assert np.abs(found.time - log.time).max() < off * STEP
    assert "even clock of 0.001 s" in note
    kept[[900, 901, 1500]] = kept[2000:2100] = False
    assert np.abs(on_its_clock(spoil(log)[kept])[0].time - log.time[kept]).max() < max(off, 0.1) * STEP


@pytest.mark.parametrize("way", ["even", "about an even clock", "step by step"])
def test_rows_that_were_taken_when_they_say_keep_their_stamps(strokes, way):
    log, random = strokes[1], np.random.default_rng(2)
    if way == "step by step":
        time = np.cumsum(STEP * (1.0 + 0.3 * random.uniform(-1.0, 1.0, len(log))))
        log = taken_at(log, time[time < log.time[-1]])
    elif way == "about an even clock":
        log = taken_at(log, np.clip(log.time + 0.3 * STEP * random.uniform(-1.0, 1.0, len(log)), 0.0, log.time[-1]))
    assert on_its_clock(log) == (log, "")


def test_a_mass_is_found_from_stamps_that_jitter_by_three_tenths_of_a_step(strokes):
    machine, log = strokes
    noisy = jitter(log, 1)
    found = cogging.identify(noisy, as_believed(machine, noisy))
    mass = found["axis.mass"]
    assert mass.value == pytest.approx(machine.axis.mass, rel=0.005)
    assert mass.ci95[0] < machine.axis.mass < mass.ci95[1]
    assert mass.ci95[1] - mass.ci95[0] < 0.02 * machine.axis.mass
    assert found.warnings == ()
    assert any("even clock" in note for note in found.notes)
    assert cogging.draft_model(noisy).model.axis.mass == pytest.approx(machine.axis.mass, rel=0.1)
