"""The axis as a unit of FMI 3.0: what `simulate` does, bit for bit, without Python within."""

import platform
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

import cogging
from tests.fixtures.plants_by_hand import effect, varied
from tests.golden.logs import EFFECTS, LOOP, STROKE

TRAVEL = [0.0, 0.5]
MOTION = STROKE | {"start": 0.1, "distance": 0.1}


def draw_axis(first, seed):
    """A model with an effect, some more, cogging periodic, along the travel or none, and a PID that holds it."""
    rng = np.random.default_rng([seed, *first.encode()])
    alone = {"presliding_friction", "backlash", "flexible_mode", "actuator_lag"}  # each may stand once
    others = rng.choice([name for name in cogging.EFFECTS if name not in alone], size=rng.integers(0, 4))
    order = int(rng.integers(1, 5))
    terms = {"harmonics": [1, 3, 8]} if rng.random() < 0.5 else {"periods": rng.uniform(0.01, 0.04, 3).tolist()}
    knots = {"order": order, "origin": rng.uniform(-0.02, 0.02), "control_points": int(rng.choice([1, order + 12]))}
    basis = cogging.SplineHarmonics(pitch=0.04, **knots, **terms)
    mass, w = 10.0 ** rng.uniform(-1.5, 0.5), 2.0 * np.pi * rng.uniform(10.0, 20.0)
    axis = {"mass": mass, "viscous": rng.uniform(0.0, 0.5), "coulomb": rng.uniform(0.0, 0.2), "travel": TRAVEL}
    axis["coulomb_width"], rates = rng.choice([0.0, rng.uniform(1e-3, 1e-2)]), [1000.0, 5000.0, rng.uniform(1e3, 8e3)]
    pid = {"type": "pid", "kp": mass * w**2, "ki": 0.2 * mass * w**3, "kd": 1.4 * mass * w, "mass": mass}
    model = cogging.Model.from_dict(LOOP | {"axis": axis, "controller": pid | {"sample_rate": rng.choice(rates)}})
    cog = cogging.CoggingModel(basis, *rng.uniform(-0.1, 0.1, (2, 3, knots["control_points"])))
    return model.replace(
        cogging=cog if rng.random() < 0.8 else None,
        effects=[varied(effect(name, **EFFECTS[name]), rng) for name in (first, *others)],
        encoder=model.encoder.replace(resolution=rng.choice([0.0, 5e-6])),
        noise=model.noise.replace(force=rng.choice([0.0, 0.02])),
        steps_per_sample=int(rng.integers(1, 4)),
    )


SOURCES = Path(__file__).resolve().parents[2] / "cpp"
OFFICIAL = Path(fmpy.__file__).parent / "c-code"
LENGTH = TRAVEL[1] - TRAVEL[0]
REFERENCES = {name: number for number, name in enumerate(["time", "command", "reading", "position", "velocity"])}
REFERENCES |= {"seed": 5, "initial_position": 6, "initial_velocity": 7}
OUTPUTS = [REFERENCES[name] for name in ("reading", "position", "velocity")]


class Unit:
    """An instance of an exported model, run by its importer's rules; use as a context."""

    def __init__(self, model, **start):
        self.folder = Path(tempfile.mkdtemp())
        (self.folder / "axis.fmu").write_bytes(cogging.export.to(model, "fmi").content)
        fmpy.extract(str(self.folder / "axis.fmu"), str(self.folder / "unit"))
        self.description = fmpy.read_model_description(str(self.folder / "unit"), validate=False)
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.instances, self.lines, self.rate = [], [], model.controller.sample_rate
        self.first = self.instance(**start)

    def instance(self, **start):
        """One more instance, in step mode."""
        made = self.instantiated()
        self.begin(made, **start)
        return made

    def instantiated(self, token=None, **options):
        place = {"unzipDirectory": str(self.folder / "unit"), "modelIdentifier": "axis", "instanceName": "x"}
        made = FMU3Slave(guid=token or self.description.guid, **place)
        self.instances.append(made)
        made.instantiate(logMessage=lambda *line: self.lines.append(line[3].decode()), **options)
        return made

    def begin(self, instance, start_time=0.0, **start):
        for name, value in start.items():
            setter = instance.setUInt64 if name == "seed" else instance.setFloat64
            setter([self.references[name]], [value])
        instance.enterInitializationMode(startTime=start_time)
        instance.exitInitializationMode()

    def run(self, commands, instance=None, step=1, begin=0):
        """Readings, positions and velocities, (n, 3): where each command begins, each held over `step` samples."""
        instance = instance or self.first
        rows = []
        for k, command in enumerate(commands, begin):
            rows.append(instance.getFloat64(OUTPUTS))
            instance.setFloat64([REFERENCES["command"]], [float(command)])
            instance.doStep(k * step / self.rate, step / self.rate)
        return np.array(rows)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for instance in self.instances:
            if instance.component:
                instance.freeInstance()
        shutil.rmtree(self.folder)


def simulated(effect, seed):
    """A drawn model, its log, and what of it a unit gives, (n, 3)."""
    model = draw_axis(effect, seed)
    log = cogging.simulate(model, MOTION, seed=seed)
    assert np.ptp(log.true_position) > 0.01
    return model, log, np.column_stack([log.position, log.true_position, log.true_velocity])


def start_of(log, seed):
    return {"seed": seed, "initial_position": float(log.reference[0])}


@pytest.mark.parametrize("effect", cogging.EFFECTS)
def test_under_the_commands_of_a_run_it_does_what_the_run_did(effect):
    """To 1e-9 of the travel; where unit and package are of one compiler there is no difference at all."""
    seed = sum(effect.encode()) % 97
    model, log, expected = simulated(effect, seed)
    with Unit(model, **start_of(log, seed)) as unit:
        got = unit.run(log.command)
        assert unit.lines == []
    of_one_compiler = sys.platform.startswith("linux") and platform.machine() == "x86_64"
    np.testing.assert_allclose(got, expected, rtol=0, atol=0 if of_one_compiler else 1e-9 * LENGTH)


def test_the_guide_s_lines_run(tmp_path, monkeypatch, capsys):
    model, log, _ = simulated("constant_force", 1)
    (lines,) = re.findall(r"```python\n(.*?)```", (SOURCES.parent / "docs" / "fmi.md").read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    model.write("model.toml")
    with monkeypatch.context() as patch:
        patch.setattr(cogging, "simulate", lambda *_, **__: log)
        exec(lines, {})
    assert capsys.readouterr().out == "True\n"


@pytest.mark.parametrize(("effect", "seed"), [("command_delay", 0), ("disturbance_step", 2)])
def test_neither_the_steps_of_the_importer_nor_the_start_of_its_time_change_a_result(effect, seed):
    """Commands held over several samples: one long step each, or many short ones, of any lengths."""
    rng = np.random.default_rng(seed)
    model = draw_axis(effect, seed)
    commands, step = rng.uniform(-1, 3, 40) * (0.3 + 2 * model.axis.mass), int(rng.integers(2, 6))
    with Unit(model, seed=seed) as unit:
        long = unit.run(commands, step=step)
        short = unit.run(np.repeat(commands, step), unit.instance(seed=seed))[::step]
        np.testing.assert_array_equal(long, short)
        assert np.ptp(long[:, 1]) > 1e-4
        third, rows = unit.instance(seed=seed, start_time=12.5), []
        for k, command in enumerate(commands):
            rows.append(third.getFloat64(OUTPUTS))
            third.setFloat64([REFERENCES["command"]], [float(command)])
            cuts = np.sort([k, k + 1, *rng.uniform(k, k + 1, 3)]) * step / unit.rate
            for begin, length in zip(cuts, np.diff(cuts), strict=False):
                third.doStep(12.5 + begin, length)
    # The integrator's own error, 1e-6 of the motion, is all that differs; a reading may fall on the next count.
    assert (abs(np.array(rows) - long)[:, 1:] <= 1e-5 * np.ptp(long, axis=0)[1:]).all()


def test_instances_do_not_meet_and_states_come_back():
    model, log, expected = simulated("presliding_friction", 3)
    half = len(log) // 2
    with Unit(model, **start_of(log, 3)) as unit:
        first, second = unit.first, unit.instance(**start_of(log, 9))
        for k, command in enumerate(log.command[:half]):  # in turn, the second under other commands and noise
            np.testing.assert_array_equal(first.getFloat64(OUTPUTS), expected[k])
            unit.run([command], first, begin=k)
            unit.run([0.5 * command], second, begin=k)
        state = first.getFMUState()
        for _ in range(2):
            np.testing.assert_array_equal(unit.run(log.command[half:], begin=half), expected[half:])
            first.setFMUState(state)
        first.freeFMUState(state)
        first.reset()
        unit.begin(first, **start_of(log, 3))
        np.testing.assert_array_equal(unit.run(log.command), expected)


def test_parameters_that_are_set_are_those_of_a_changed_model():
    model, log, _ = simulated("stribeck_friction", 2)
    changed = {"axis.mass": 1.3 * model.axis.mass, "noise.force": 0.01, "stribeck_friction.velocity": 0.02}
    effects = [model.effects[0].replace(velocity=0.02), *model.effects[1:]]
    noise, axis = model.noise.replace(force=0.01), model.axis.replace(mass=changed["axis.mass"])
    with Unit(model, **start_of(log, 2)) as unit:
        plain = unit.run(log.command)
        got = unit.run(log.command, unit.instance(**start_of(log, 2), **changed))
    with Unit(model.replace(axis=axis, noise=noise, effects=effects), **start_of(log, 2)) as unit:
        np.testing.assert_array_equal(unit.run(log.command), got)
    assert abs(got - plain)[:, 1].max() > 1e-4


def test_leaving_the_travel_is_an_error_that_says_when_and_where():
    model = draw_axis("cable_spring", 0)
    with Unit(model, initial_velocity=0.1) as unit:
        with pytest.raises(FMICallException):
            unit.run(np.full(10**5, 50.0))
        unit.first.getFloat64(OUTPUTS)  # the last state can still be read
        with pytest.raises(FMICallException):
            unit.run([0.0])
    time = float(re.match(r"x: the run diverged at (\S+) s", unit.lines[0])[1])
    still = np.full(2 + int(time * unit.rate), 50.0)
    push = cogging.Sampled(np.arange(len(still)) / unit.rate, 0 * still, 0 * still, still)
    pid = cogging.Pid(cogging.PidParameters(sample_rate=unit.rate, mass=1.0))
    with pytest.raises(cogging.DivergedError) as diverged:
        cogging.simulate(model, push, controller=pid, initial_position=0.5 * LENGTH, initial_velocity=0.1)
    assert unit.lines[0] == f"x: {diverged.value}"


def test_calls_out_of_order_and_wrong_arguments_are_errors_in_one_line():
    with Unit(draw_axis("cable_spring", 0)) as unit:
        axis, of = unit.first, unit.references

        def said(call, *arguments, error=FMICallException, **options):
            with pytest.raises(error):
                call(*arguments, **options)
            return unit.lines[-1]

        assert "after initialization" in said(axis.setFloat64, [of["axis.mass"]], [1.0])
        assert "must be that of an input or a parameter" in said(axis.setFloat64, [of["reading"]], [1.0])
        assert "Point: must be the time that is reached, 0 s, got 0.7" in said(axis.doStep, 0.7, 1e-3)
        assert "StepSize: must be finite and above 0, got nan" in said(axis.doStep, 0.0, float("nan"))
        assert "must be called first, once" in said(axis.enterInitializationMode)
        unit.run([0.01] * 3)  # none of them has done harm
        axis.setFloat64([of["command"]], [float("nan")])
        assert "the command must be a finite number, got nan" in said(axis.doStep, 3 / unit.rate, 1 / unit.rate)
        for name, value, line in (
            ("axis.mass", -1.0, "mass: must be finite and above 0, got -1"),
            ("initial_position", 9.0, "the run diverged at 0 s: position 9,"),
            ("initial_velocity", float("inf"), "initial_velocity: must be a finite number, got inf"),
        ):
            assert said(unit.instance, **{name: value}).startswith(f"x: {line}")
        for options, line in (({"token": "{0}"}, "Token"), ({"eventModeUsed": True}, "neither an event mode")):
            assert line in said(unit.instantiated, error=Exception, **options)
            unit.instances.pop()


def test_the_same_model_gives_the_same_bytes_and_another_another_token():
    model = draw_axis("backlash", 1)
    one, two = (cogging.export.to(model, "fmi").content for _ in range(2))
    assert one == two
    assert cogging.export.to(model, "fmi", sample_rate=1234.5).content != one


def test_the_description_says_what_the_model_says():
    model = draw_axis("flexible_mode", 5).replace(units=cogging.Units(command="A", position="rad"))
    with Unit(model) as unit:
        assert validate_fmu(str(unit.folder / "axis.fmu")) == []
        variables = {v.name: v for v in unit.description.modelVariables}
        (capabilities,) = ET.parse(unit.folder / "unit" / "modelDescription.xml").iterfind("CoSimulation")
        options = {"canHandleVariableCommunicationStepSize": "true", "canGetAndSetFMUState": "true"}
        assert capabilities.attrib == {"modelIdentifier": "axis"} | options
        assert float(unit.description.defaultExperiment.stepSize) == 1 / model.controller.sample_rate
        units = {"reading": "rad", "initial_position": "rad", "command": "A", "axis.mass": "A/(rad/s^2)"}
        assert {name: variables[name].unit for name in units} == units
        assert float(variables["flexible_mode.frequency"].start) == model.effects[0].frequency
        parameters = [v for name, v in variables.items() if "." in name]
        assert unit.first.getFloat64([v.valueReference for v in parameters]) == [float(v.start) for v in parameters]
        text = (unit.folder / "unit" / "documentation" / "licenses" / "license.txt").read_text()
        assert "Permission is hereby granted" in text


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="asks the tools of Linux")
def test_the_library_needs_no_python_and_shows_the_interface_alone():
    with Unit(draw_axis("cable_spring", 0)) as unit:
        (library,) = (unit.folder / "unit" / "binaries" / fmpy.platform_tuple).glob("*.so")
        needed, listed = (
            subprocess.run([*tool, library], capture_output=True, text=True, check=True).stdout
            for tool in (["ldd"], ["nm", "-D", "--defined-only"])
        )
    assert "libc.so" in needed
    assert "python" not in needed
    official = re.findall(r"^FMI3_Export \w+\s+(fmi3\w+);", (OFFICIAL / "fmi3Functions.h").read_text(), re.MULTILINE)
    assert {line.split()[-1] for line in listed.splitlines()} == set(official)


@pytest.mark.parametrize("file", ["co_simulation", "not_supported"])
def test_the_functions_are_those_of_the_official_headers(file):
    """The Modelica Association's declarations and these definitions, in one translation unit."""
    compiler = shutil.which("g++") or pytest.skip("no g++")
    options = ["-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-DCOGGING_OFFICIAL_FMI3"]
    command = [compiler, *options, f"-I{OFFICIAL}", f"-I{SOURCES}", str(SOURCES / "fmi" / f"{file}.cpp")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]


def test_an_effect_in_python_is_refused():
    own = cogging.effects.Custom("breeze", force=lambda velocity: 0.1)
    with pytest.raises(ValueError, match=r"effects: must be of the core's list to run without Python, got breeze"):
        cogging.export.to(draw_axis("cable_spring", 0).replace(effects=[own]), "fmi")
