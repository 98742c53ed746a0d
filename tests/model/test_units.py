"""`[units]`: labels that a model carries, and what they do to the units of everything that is said of it."""

import pytest

import cogging
from cogging.files import InputError
from tests.fixtures.files import MODEL


@pytest.mark.parametrize(
    ("unit", "rotary"),
    [
        ("V", "A"),
        ("mV", "mA"),
        ("m", "rad"),
        ("mm", "mrad"),
        ("um", "urad"),
        ("V/(m/s^2)", "A/(rad/s^2)"),
        ("V/(m s)", "A/(rad s)"),
        ("1/m", "1/rad"),
        ("m/s", "rad/s"),
        ("s", "s"),
        ("ms", "ms"),
        ("min", "min"),
        ("Hz", "Hz"),
        ("1", "1"),
        ("", ""),
    ],
)
def test_what_stands_for_the_command_and_the_position_is_named_as_the_machine_has_it(unit, rotary):
    assert cogging.Units(command="A", position="rad").of(unit) == rotary
    assert cogging.Units().of(unit) == unit


def test_every_unit_of_the_package_changes_wherever_volts_and_metres_stand():
    units = cogging.Units(command="Q", position="turn")
    structs = [*cogging.EFFECTS.values(), cogging.AxisParameters, cogging.EncoderParameters, cogging.NoiseParameters]
    told = {unit for struct in structs for unit, _ in struct.FIELDS.values() if unit}
    assert len(told) > 8
    for unit in told:
        letters = "".join(c if c.isalpha() else " " for c in unit).split()
        changed = units.of(unit)
        assert ("Q" in changed) == ("V" in letters)
        assert ("turn" in changed) == ("m" in letters)
        assert "V" not in changed


def test_a_model_carries_them_and_a_model_without_keeps_the_usual_ones(tmp_path):
    plain = tmp_path / "plain.toml"
    plain.write_text(MODEL)
    model = cogging.Model.read(plain)
    assert model.units == cogging.Units() == cogging.Units("V", "m")
    assert "units" not in model.to_dict()
    rotary = model.replace(units=cogging.Units(command="Nm", position="rad"))
    rotary.write(tmp_path / "rotary.toml")
    again = cogging.Model.read(tmp_path / "rotary.toml")
    assert again == rotary != model
    assert again.units.command == "Nm"
    assert "Nm/(rad/s^2)" in repr(again)
    assert "V/(m/s^2)" in repr(model)


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ('[units]\ncommand = ""', "units.command: must be the label of a unit"),
        ("[units]\nposition = 3", "units.position: must be the label of a unit"),
        ('[units]\ncommand = "a unit of two words"', "units.command: must be the label of a unit"),
        ('[units]\ncommand = "<b>"', "units.command: must be the label of a unit"),
        ('[units]\nforce = "N"', "units.force: is unknown"),
        ('units = "A"', "units: must be a section"),
    ],
)
def test_what_is_no_label_is_refused_in_one_line_and_by_the_schema(tmp_path, section, said):
    import jsonschema

    path = tmp_path / "model.toml"
    path.write_text(f"{section}\n{MODEL}" if section.startswith("units") else f"{MODEL}\n{section}\n")
    with pytest.raises(InputError, match=said) as error:
        cogging.Model.read(path)
    assert len(str(error.value).splitlines()) == 1
    document = cogging.schema()["$defs"]["model"]["properties"]["units"]
    entry = cogging.model.model.read_toml(path)["units"]
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(entry, document)


@pytest.mark.parametrize("label", ["A", "N", "Nm", "V", "%", "rad", "µm", "A/m", "deg", "kN"])
def test_what_a_machine_builder_calls_a_unit_is_a_label(label):
    import jsonschema

    units = cogging.Units(command=label, position=label)
    jsonschema.validate(units.to_dict(), cogging.schema()["$defs"]["model"]["properties"]["units"])
    assert cogging.Units.from_dict(units.to_dict()) == units


def test_a_model_takes_units_alone():
    axis = cogging.AxisParameters(mass=1.0)
    with pytest.raises(TypeError, match="units: must be Units"):
        cogging.Model(axis, units="A")
