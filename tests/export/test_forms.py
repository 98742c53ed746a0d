"""The list of forms: what leads nowhere, and what a form is asked for that it does not take."""

import importlib
import inspect

import pytest

import cogging
from cogging.cli.main import main
from cogging.export.drive_table import frame_of
from cogging.export.forms import FORMS
from tests.fixtures.files import MODEL


@pytest.mark.parametrize("form", FORMS.values(), ids=list(FORMS))
def test_a_form_leads_to_its_function_and_states_its_options(form):
    module, function = form.made_by.split(":")
    parameters = inspect.signature(getattr(importlib.import_module(module), function)).parameters
    taken = [p for name, p in parameters.items() if name not in ("model", "view")]
    if "view" in parameters:
        taken += [p for name, p in inspect.signature(frame_of).parameters.items() if name not in ("model", "unit")]
    assert all(p.kind is p.KEYWORD_ONLY for p in taken)
    assert {option.name for option in form.options} == {p.name for p in taken}
    assert all(len(option.help) > 10 for option in form.options)


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
