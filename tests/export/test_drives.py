"""What leaves for a drive, read back by a small model of that drive: it removes what the drive's resolution allows."""

import re
from dataclasses import dataclass

import numpy as np
import pytest

import cogging
from cogging import effects
from cogging.cli.main import main


class Drive:
    """Added to the command at the drive's own position, in its own unit."""

    def __init__(self, values, span, start=0.0, linear=True, wraps=True):
        self.values, self.span, self.start = np.asarray(values, dtype=float), span, start
        self.linear, self.wraps = linear, wraps

    def adds(self, place):
        n = len(self.values)
        if not self.wraps:  # an entry at both ends
            return np.interp(place, self.start + self.span * np.arange(n) / (n - 1), self.values, left=0.0, right=0.0)
        share = (np.asarray(place) - self.start) / self.span
        share = share - np.floor(share)
        if not self.linear:
            return self.values[np.minimum((share * n).astype(int), n - 1)]
        return np.interp(share * n, np.arange(n + 1), np.append(self.values, self.values[0]))


class Waves:
    """A sum of waves over one revolution."""

    def __init__(self, waves, turn):
        self.waves, self.turn = waves, turn

    def adds(self, place):
        angle = 2 * np.pi * np.asarray(place) / self.turn
        return sum(r * np.cos(n * angle + np.deg2rad(phi)) for n, phi, r in self.waves)


def _columns(exported, names):
    lines = exported.content.decode().splitlines()
    assert lines[0] == names
    return [line.split(",") for line in lines[1:]]


def csv(exported, machine):
    rows = np.array(_columns(exported, "position,force"), dtype=float)
    if machine.turn:
        return Drive(rows[:, 1], machine.turn, rows[0, 0])
    return Drive(rows[:, 1], rows[-1, 0] - rows[0, 0], rows[0, 0], wraps=False)


def akd(exported, machine):
    values = [float(line) for line in exported.content.decode().splitlines()]
    assert len(values) == 8192
    if machine.turn:
        return Drive(values, machine.turn)
    low, high = machine.drive_travel()
    return Drive(values, high - low, low, wraps=False)


def sinamics(exported, machine):
    rows = _columns(exported, "parameter,index,value")
    assert [(name, int(index)) for name, index, _ in rows] == [("p5260", i) for i in range(4096)]
    values = [float(np.float32(value)) for *_, value in rows]
    factor = float(re.search(r"^set p5253 to (\S+)$", exported.beside[".txt"].decode(), re.MULTILINE)[1])
    return Drive(values, factor * (machine.turn or machine.pitch), linear=False)


def novanta(exported, machine):
    rows = _columns(exported, "index,value")
    assert [int(index) for index, _ in rows] == list(range(256))
    return Drive([float(np.float32(value)) for _, value in rows], machine.electrical_period())


def odrive(exported, machine):
    text = exported.content.decode()
    values = [float(np.float32(v)) for v in re.findall(r"^ +(\S+)f,$", text, re.MULTILINE)]
    assert len(values) == 3600
    return Drive(values, machine.turn, linear=False)


def moteus(exported, machine):
    lines = exported.content.decode().splitlines()
    scale = float(np.float32(lines[0].removeprefix("conf set motor.cogging_dq_scale ")))
    found = [re.fullmatch(r"conf set motor\.cogging_dq_comp\.(\d+) (-?\d+)", line) for line in lines[1:-1]]
    assert [int(one[1]) for one in found] == list(range(1024))
    whole = np.array([int(one[2]) for one in found])
    assert np.abs(whole).max() == 127
    assert lines[-1] == "conf write"
    return Drive(whole * scale, machine.turn)


def ax8000(exported, machine):
    objects = {name: (kind, float(value)) for name, kind, value in _columns(exported, "object,type,value")}
    assert objects.pop("32CB:01") == ("INT16", 3.0)
    assert objects.pop("32CB:02") == ("REAL32", 1.0)
    waves = []
    for number in range(10):
        entry = [objects.pop(f"32CB:{0x07 + 3 * number + k:02X}") for k in range(3)]
        assert [kind for kind, _ in entry] == ["UINT32", "REAL32", "REAL32"]
        (_, times), (_, phase), (_, size) = entry
        assert 0 <= times <= 200
        assert 0.0 <= phase <= 360.0
        assert size >= 0.0
        waves.append((times, float(np.float32(phase)), float(np.float32(size))))
    assert not objects
    return Waves(waves, machine.turn)


#: How each form is read back, where it may go, and what stands between its entries: a line, the last one, or waves.
BOTH, ROTARY = ("rotary", "linear"), ("rotary",)
FORMS = {
    "csv": (csv, BOTH, "linear"),
    "akd": (akd, BOTH, "linear"),
    "sinamics": (sinamics, BOTH, "hold"),
    "ax8000": (ax8000, ROTARY, "waves"),
    "novanta": (novanta, BOTH, "linear"),
    "odrive": (odrive, ROTARY, "hold"),
    "moteus": (moteus, ROTARY, "linear"),
}
CASES = [(form, kind, seed) for form, (_, kinds, _) in FORMS.items() for kind in kinds for seed in range(2)]


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


@dataclass
class Machine:
    """A drawn motor, and how the drive sits on it."""

    model: cogging.Model
    turn: float
    pairs: int
    pitch: float
    options: dict

    def __post_init__(self):
        self.direction = -1 if self.options["reverse"] else 1

    def place(self, position):
        """The drive's own position."""
        return self.direction * (position - self.options["zero"])

    def drive_travel(self):
        return tuple(sorted(self.place(end) for end in self.model.axis.travel))

    def electrical_period(self):
        return self.turn / self.pairs if self.turn else self.pitch

    def feedforward(self, drive, position):
        """The command that the drive adds, as the axis feels it: it counts, pushes and has units of its own."""
        added = drive.adds(self.place(np.asarray(position)))
        return self.direction * self.options["sign"] * added / self.options["scale"]

    def positions(self, count=30_000):
        low, high = (0.0, self.turn) if self.turn else self.model.axis.travel
        return np.random.default_rng(5).uniform(low, high, count)


def drawn(form, kind, seed, waves=None):
    """A motor: pitches, harmonics, amplitudes, travel, units, zero, direction and sign."""
    rng = np.random.default_rng([seed, sorted(FORMS).index(form), kind == "rotary"])
    pairs = int(rng.integers(2, 12))
    count = waves or int(rng.integers(1, 5))
    if kind == "rotary":
        turn = float(rng.choice([1.0, 2 * np.pi, 360.0, 8192.0]))
        pitch, travel = turn, [-np.inf, np.inf]
        step = pairs if form == "novanta" else 1
        times = step * rng.choice(np.arange(1, 100 // step), count, replace=False)
    else:
        turn, pitch = 0.0, float(rng.uniform(0.01, 0.08))
        low = float(rng.uniform(-0.5, 0.5))
        travel = [low, low + pitch * float(rng.uniform(2.0, 12.0))]
        times = rng.choice(np.arange(1, 7), count, replace=False)
    size = 10 ** rng.uniform(-1.5, 1.5)
    sine, cosine = size * rng.normal(size=(2, count, 1))
    basis = cogging.SplineHarmonics(pitch=pitch, harmonics=sorted(times.tolist()))
    axis = cogging.AxisParameters(mass=1e-3 * size, travel=travel)
    model = cogging.Model(axis, cogging=cogging.CoggingModel(basis, sine, cosine))
    options = {
        "scale": float(rng.uniform(0.3, 1.5) / size),  # a current of the order of 1 A
        "sign": int(rng.choice([-1, 1])),
        "zero": float(rng.uniform(-1.0, 1.0) * (turn or 0.3)),
        "reverse": bool(rng.integers(2)),
    }
    return Machine(model, turn, pairs, pitch, options)


def made(form, machine, **changes):
    turn = {"turn": machine.turn} | ({"pole_pairs": machine.pairs} if form == "novanta" else {})
    options = machine.options | ({"entries": 256} if form == "novanta" else {}) | (turn if machine.turn else {})
    return cogging.export.to(machine.model, form, **options | changes)


def allowed(form, machine, drive, x):
    """What entries and quantum leave of a smooth map: step h of a held entry h^2 F'^2 / 12, of a line h^4 F''^2 / 120.

    A quantum q leaves q^2/12 in an entry, two thirds of that between two.
    """
    cog, how = machine.model.cogging, FORMS[form][2]
    h = drive.span / (len(drive.values) - (not drive.wraps))
    quantum = {"akd": 1e-3, "moteus": np.abs(drive.values).max() / 127}.get(form, 0.0) / machine.options["scale"]
    if how == "hold":
        return np.sqrt(h**2 / 12 * np.mean(cog.slope(x) ** 2) + quantum**2 / 12)
    d = 1e-4 * h
    curvature = (cog.slope(x + d) - cog.slope(x - d)) / (2 * d)
    return np.sqrt(h**4 / 120 * np.mean(curvature**2) + 2 / 3 * quantum**2 / 12)


@pytest.mark.parametrize(("form", "kind", "seed"), CASES)
def test_the_drive_removes_what_its_resolution_allows(form, kind, seed):
    machine = drawn(form, kind, seed)
    exported = made(form, machine)
    drive = FORMS[form][0](exported, machine)
    x = machine.positions()
    force = machine.model.cogging.force(x)
    left = rms(force - machine.feedforward(drive, x))
    if form == "ax8000":
        assert left < 3e-6 * rms(force)
    else:
        bound = allowed(form, machine, drive, x)
        assert 0.9 * bound < left < 1.1 * bound + 2e-7 * rms(force)
        assert left < 0.15 * rms(force)
    removed = float(re.search(r"removes (\S+) % of the cogging's rms", exported.text)[1])
    assert removed == pytest.approx(100 * (1 - left / rms(force)), abs=0.05 * 100 * left / rms(force) + 1e-3)


@pytest.mark.parametrize(("form", "seed"), [("csv", 0), ("akd", 1), ("sinamics", 2), ("novanta", 3)])
def test_a_table_over_the_travel_holds_what_changes_along_it_and_one_of_a_period_says_what_it_cannot(form, seed):
    machine = drawn("novanta", "linear", seed)
    old, (low, _) = machine.model.cogging, machine.model.axis.travel
    knots = {"order": 3, "origin": low, "control_points": 7}
    basis = cogging.SplineHarmonics(pitch=machine.pitch, harmonics=old.basis.harmonics, **knots)
    grown = np.random.default_rng(seed).uniform(0.4, 1.6, (old.basis.terms, 7))
    machine.model = machine.model.replace(cogging=cogging.CoggingModel(basis, old.sine * grown, old.cosine * grown))
    exported = made(form, machine)
    x = machine.positions()
    force = machine.model.cogging.force(x)
    left = rms(force - machine.feedforward(FORMS[form][0](exported, machine), x))
    if form == "novanta":
        (printed,) = re.findall(r"cannot hold (\S+) V rms: amplitudes that change along the travel", exported.text)
        assert float(printed) == pytest.approx(left, rel=0.03)
    else:
        assert left < 0.02 * rms(force)
        assert "cannot hold" not in exported.text


def test_ten_coefficients_hold_the_ten_largest_waves_that_the_drive_has():
    machine = drawn("ax8000", "rotary", 0, waves=14)
    drive = ax8000(made("ax8000", machine), machine)
    cog, x = machine.model.cogging, machine.positions(200_000)
    sizes = np.sort(np.hypot(cog.sine, cog.cosine).ravel())
    left = rms(cog.force(x) - machine.feedforward(drive, x))
    assert left == pytest.approx(np.sqrt(0.5 * np.sum(sizes[:4] ** 2)), rel=0.02)
    waves = ax8000(made("ax8000", machine, wave="sine"), machine)
    waves.waves = [(n, phi - 90.0, r) for n, phi, r in waves.waves]
    np.testing.assert_allclose(waves.adds(machine.place(x)), drive.adds(machine.place(x)), atol=1e-5)


#: Form, options, the map (None: none), and the error.
REFUSED = [
    ("odrive", {}, {}, "turn: must be given"),
    ("novanta", {}, {}, "entries: must be given: as many as register 0x2307"),
    ("akd", {"entries": 8193}, {}, "entries: must be a whole number from 2 to 8192, got 8193"),
    ("akd", {}, {}, r"axis\.travel: must have two finite ends"),
    ("sinamics", {"scale": 1e39}, {}, "scale: must keep entries within 32-bit numbers"),
    ("csv", {"sign": 2}, {}, "sign: must be 1 or -1, got 2"),
    ("ax8000", {"turn": 0.2, "channel": "C"}, {}, "channel: must be one of A, B"),
    ("csv", {"turn": 1.0}, None, "cogging: must be given to export a map"),
    ("csv", {"turn": 1.0}, {"sine": [[0.0]]}, "cogging: must have an amplitude other than 0"),
    ("csv", {"turn": 1.0}, {"pitch": 2.7, "harmonics": [3]}, "turn: must be a whole number of times each .* 0.9"),
    ("cpp", {}, None, "controller: must be there to be exported"),
    ("fmi", {}, None, "controller: or an option sample_rate must be there"),
    ("fmi", {"sample_rate": 0.0}, None, r"sample_rate: must be finite and above 0, got 0\.0"),
    *(("fmi", {"sample_rate": 1e3, "name": word}, None, r"name: must be a name in C\+\+") for word in ("", "9", "ä")),
]


@pytest.mark.parametrize(("form", "options", "cogs", "rule"), REFUSED)
def test_what_cannot_be_exported(form, options, cogs, rule):
    axis = {"mass": 1.0} | ({"travel": [0.0, 0.5]} if "scale" in options else {})
    wave = {"pitch": 0.05, "harmonics": [1], "sine": [[1.0]], "cosine": [[0.0]]}
    model = cogging.Model.from_dict({"axis": axis} | ({} if cogs is None else {"cogging": wave | cogs}))
    with pytest.raises(ValueError, match=rule) as refused:
        cogging.export.to(model, form, **options)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("form", FORMS)
def test_a_unit_that_is_not_the_drives_needs_a_scale_and_no_unit_is_an_assumption(form):
    machine = drawn(form, FORMS[form][1][0], 0)
    del machine.options["scale"]
    assert ("assumed: 1 V of the model is 1 " in made(form, machine).text) == (form != "csv")
    assert "of the model is" not in made(form, machine, scale=1.0).text
    machine.model = machine.model.replace(units=cogging.Units(command="mN"))
    if form == "csv":  # in whatever unit the model has
        assert made(form, machine).content == made(form, machine, scale=1.0).content
        return
    with pytest.raises(ValueError, match=r"scale: must be given, (A|Nm|N) per mN: the drive takes (A|Nm|N), got a mod"):
        made(form, machine)
    assert made(form, machine, scale=0.2).content


@pytest.mark.parametrize("form", ["csv", "ax8000"])
def test_effects_that_are_cogging_go_with_the_map(form):
    """A map whose terms stand in effects, as a diagnosis adds them, is the same map; what else pushes is named."""
    machine = drawn(form, FORMS[form][1][0], 2, waves=3)
    cog = machine.model.cogging
    waves = [
        effects.CoggingHarmonic(period=2 * np.pi / k, sine=a[0], cosine=b[0])
        for k, a, b in zip(cog.basis.wavenumbers, cog.sine, cog.cosine, strict=True)
    ]
    whole = made(form, machine)
    first = cogging.SplineHarmonics(pitch=machine.pitch, harmonics=cog.basis.harmonics[:1])
    part = cogging.CoggingModel(first, cog.sine[:1], cog.cosine[:1])
    machine.model = machine.model.replace(cogging=part, effects=[*waves[1:], effects.CableSpring(stiffness=0.1)])
    split = made(form, machine)
    x = machine.positions(5000)
    one, other = (machine.feedforward(FORMS[form][0](each, machine), x) for each in (whole, split))
    np.testing.assert_allclose(one, other, atol=1e-5 * rms(one))
    assert "not in it, as no cogging: cable_spring" in split.text
    machine.model = machine.model.replace(cogging=None, effects=waves)
    alone = machine.feedforward(FORMS[form][0](made(form, machine), machine), x)
    np.testing.assert_allclose(one, alone, atol=1e-5 * rms(one))


def test_the_command_takes_what_map_wrote(tmp_path, monkeypatch, capsys):
    """A scan becomes a map, and the map a table: no `[axis]` between."""
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(3)
    x = np.linspace(0.0, 360.0, 1500, endpoint=False)
    force = 0.3 * np.sin(np.deg2rad(12 * x) + 0.4) + 0.1 * np.cos(np.deg2rad(28 * x)) + 0.003 * rng.normal(size=x.size)
    np.savetxt("scan.csv", np.column_stack([x, force]), delimiter=",", header="position,force", comments="")
    assert main(["map", "scan.csv", "--pitch", "360", "--out", "map.toml"]) == 0
    assert main(["export", "map.toml", "--to", "moteus", "--out", "table.cfg", "--turn", "360", "--scale", "2.5"]) == 0
    printed = capsys.readouterr().out
    assert "table.cfg, table.cfg.txt written" in printed
    assert re.search(r"removes 9\d\.\d+ % of the cogging's rms", printed)
    exported = cogging.export.to("map.toml", "moteus", turn=360.0, scale=2.5)
    assert (tmp_path / "table.cfg").read_bytes() == exported.content
    assert (tmp_path / "table.cfg.txt").read_bytes() == exported.beside[".txt"]
