"""First models from logs that others measured, beside what is published of their machines."""

import shlex

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.datasets import emps, laas, odrive, tro2021
from cogging.files import InputError
from tests.fixtures.measured import FOLDER

pytestmark = pytest.mark.data


def test_emps():
    draft = cogging.draft_model(emps.files(FOLDER)["DATA_EMPS_PULSES"])
    assert draft.columns.columns == {"time": "t", "position": "qm", "command": "vir", "reference": "qg"}
    assert draft.scale == {}
    assert draft.motion.kind == "sampled"
    assert draft.audit.rate == pytest.approx(1000.0, rel=1e-3)
    for path in ("axis.mass", "axis.viscous", "axis.coulomb"):
        size = draft.sizes.sizes[path.partition(".")[2]]
        published = emps.PUBLISHED[path] / emps.FORCE_CONSTANT  # the command is in V
        assert size.value == pytest.approx(published, rel=0.1)
        assert abs(size.value / published - 1.0) < 2.0 * size.uncertainty
    assert -35.15065 * draft.sizes.offset == pytest.approx(3.16, abs=0.3)


def test_emps_from_init_to_a_fit(tmp_path, monkeypatch, capsys):
    """The printed command fits the model."""
    monkeypatch.chdir(tmp_path)
    path = emps.files(FOLDER)["DATA_EMPS"]
    assert main(["init", str(path), "--rows", "0:9000"]) == 0
    words = shlex.split(capsys.readouterr().out.splitlines()[-1].removeprefix("next: cogging "))
    assert "--rows" in words
    assert main(words) == 0
    fitted = cogging.Model.read("fitted.toml")
    assert fitted.axis.mass == pytest.approx(95.11 / emps.FORCE_CONSTANT, rel=0.03)


def test_laas():
    files = laas.files(FOLDER)
    held, fast, turning = (cogging.draft_model(files[name]) for name in laas.FILES)
    for draft in (held, fast, turning):
        found = {name: guess.label for name, guess in draft.columns.used.items()}
        assert found == {"time": "Time", "position": "Position", "command": "Iq"}
        assert any(entry.startswith("command: its unit is not stated") for entry in draft.unsure)
        assert any(entry.startswith("position: ") for entry in (*draft.unsure, *draft.likely))
    unit = fast.scale.get("position", 1.0)  # what a turning motor is taken for
    assert fast.sizes.sizes["mass"].value * unit == pytest.approx(1.93e-4, rel=0.3)
    assert turning.sizes.sizes["coulomb"].value == pytest.approx(0.053, rel=0.2)
    assert held.sizes.sizes["mass"].uncertainty is None


def test_odrive():
    """Seven periods a turn stand out first, as the makers' own map has them."""
    draft = cogging.draft_model(odrive.read("slow2_nocomp_0", FOLDER))
    assert odrive.TURN / draft.wave.period == pytest.approx(7.0, rel=0.03)
    assert np.hypot(draft.wave.sine, draft.wave.cosine) == pytest.approx(0.86, rel=0.15)
    assert draft.sizes.sizes["viscous"].uncertainty is None


def test_tro2021_has_no_position():
    """Its time has a unit, `ms`, and no name; beside it stand a speed and a torque."""
    path = tro2021.files(FOLDER)["start_stop/200"]
    with pytest.raises(InputError, match="column time: cannot be identified among 'Velocity actual value"):
        cogging.draft_model(path)
