"""The list of forms: what leads nowhere, and what a form is asked for that it does not take."""

import pytest

import cogging
from cogging.cli.main import main
from tests.fixtures.files import MODEL


def test_a_form_that_is_not_there(tmp_path, capsys):
    (tmp_path / "model.toml").write_text(MODEL)
    out = tmp_path / "out"
    assert main(["export", str(tmp_path / "model.toml"), "--to", "nothing", "--out", str(out)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "--to: must be one of " in said
    assert "'nothing'" in said
    assert not out.exists()
    with pytest.raises(ValueError, match="form: must be one of "):
        cogging.export.to(cogging.Model(cogging.AxisParameters(mass=1.0)), "nothing")
