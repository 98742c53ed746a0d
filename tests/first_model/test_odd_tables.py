"""Drawn tables that are hardly logs: each is drafted, with a next command that runs, or refused in one line."""

import math
import random
import shlex

import numpy as np

import cogging
from cogging.cli.main import main

LABELS = ["time", "t", "Zeit [ms]", "x [mm]", "pos", "Iq", "u", "ref", "", "a", "a", "Größe [V]", "x,y", "1", "nan"]
LABELS += ["reference", "reference_velocity", "Velocity", "x [m/s]", "position [counts]", "t [ms]", "pos(um)", "'q'"]
LABELS += ["$HOME", "; rm", "soll", "x_ref_mm", "F [kN]", "v_ref", "a: b", "-x", "=", "x [", "%"]


def column(draw, rows):
    noise = np.random.default_rng(draw.randrange(100)).standard_normal(rows)
    time = np.arange(rows) * 10.0 ** draw.randrange(-5, 3)
    wave = np.sin(time * draw.uniform(0.0, 100.0)) * 10.0 ** draw.randrange(-12, 12)
    constant = np.full(rows, draw.choice([0.0, 1.0, -5.0, 1e20]))
    return draw.choice([time, wave, noise, np.cumsum(noise), constant, np.arange(rows) % 7.0])


def odd_table(seed):
    draw = random.Random(seed)
    rows, count = draw.choice([0, 1, 2, 5, 12, 100, 201, 400]), draw.randrange(1, 7)
    labels, columns = draw.sample(LABELS, count), [column(draw, rows) for _ in range(count)]
    if draw.random() < 0.8 and count >= 3:
        labels[:3], columns[0] = ["t", "x", "u"], np.arange(rows) * 1e-3
    holes = draw.random() < 0.2
    separator = draw.choice([",", ";", "\t"])
    cells = [
        [repr(float(c[i])) if not holes or draw.random() > 0.01 else draw.choice(["", "nan", "x"]) for c in columns]
        for i in range(rows)
    ]
    quoted = [f'"{label}"' if separator in label else label for label in labels]
    return "\n".join(separator.join(row) for row in [quoted, *cells]) + "\n"


def test_odd_tables(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    drafted = refused = 0
    for seed in range(20):
        for path in tmp_path.iterdir():
            path.unlink()
        (tmp_path / "a.csv").write_text(odd_table(seed))
        status = main(["init", "a.csv"])
        said = capsys.readouterr()
        if status != 0:
            refused += 1
            assert status == 2, seed
            assert said.err.startswith("cogging: a.csv: ")
            assert said.err.count("\n") == 1
            assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]
            continue
        drafted += 1
        assert math.isfinite(cogging.Model.read("model.toml").axis.mass)
        cogging.read_reference("reference.toml")
        words = shlex.split(said.out.splitlines()[-1].removeprefix("next: cogging "))
        assert main(words) == 0, (seed, words)
        capsys.readouterr()
    assert min(drafted, refused) >= 2
