"""`[units]`: labels of a model, and units written with them."""

import re

import pytest

import cogging
from cogging.files import InputError
from tests.fixtures.files import MODEL


def test_every_unit_is_written_with_the_labels_of_the_machine():
    units = cogging.Units(command="Q", position="turn")
    structs = [*cogging.EFFECTS.values(), cogging.AxisParameters, cogging.EncoderParameters, cogging.NoiseParameters]
    known = {unit for struct in structs for unit, _ in struct.FIELDS.values() if unit}
    assert len(known) > 8
    known |= {"mV", "um", "1/m", "min", "ms"}
    for unit in known:
        assert cogging.Units().of(unit) == unit
        expected = re.sub(r"(?<![a-z])(u?)m(?![a-zA-Z])", r"\1turn", unit.replace("V", "Q"))
        assert units.of(unit) == expected


def test_a_model_file_keeps_its_labels(tmp_path):
    (tmp_path / "plain.toml").write_text(MODEL)
    model = cogging.Model.read(tmp_path / "plain.toml")
    assert model.units == cogging.Units() == cogging.Units("V", "m")
    assert "units" not in model.to_dict()
    rotary = model.replace(units=cogging.Units(command="Nm", position="rad"))
    rotary.write(tmp_path / "rotary.toml")
    assert cogging.Model.read(tmp_path / "rotary.toml") == rotary != model
    assert ("Nm/(rad/s^2)" in repr(rotary), "V/(m/s^2)" in repr(model)) == (True, True)


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ('[units]\ncommand = ""', "units.command: must be the label of a unit"),
        ('[units]\ncommand = "a unit of two words"', "units.command: must be the label of a unit"),
        ('[units]\nforce = "N"', "units.force: is unknown"),
        ('units = "A"', "units: must be a section"),
    ],
)
def test_a_wrong_label_is_one_line_and_invalid_by_the_schema(tmp_path, section, message):
    import jsonschema

    path = tmp_path / "model.toml"
    path.write_text(f"{section}\n{MODEL}" if section.startswith("units") else f"{MODEL}\n{section}\n")
    with pytest.raises(InputError, match=message) as error:
        cogging.Model.read(path)
    assert len(str(error.value).splitlines()) == 1
    document = cogging.schema()["$defs"]["model"]["properties"]["units"]
    entry = cogging.files.read_toml(path)["units"]
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(entry, document)
