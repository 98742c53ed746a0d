"""The schema that `cogging schema` prints says what the readers take."""

import json

import pytest

import cogging
from cogging.cli.main import main
from cogging.files import parse_toml
from cogging.model.model import COGGING_KEYS, CONTROLLERS, SECTIONS
from cogging.outputs import to_toml
from cogging.simulation.reference import REFERENCES, SAMPLED_KEYS
from tests.fixtures.covering import covering
from tests.fixtures.files import MODEL, REFERENCE
from tests.fixtures.model_files import BAD, CONTRACT


@pytest.fixture(scope="module")
def schema():
    return cogging.schema()


def validator(schema, part):
    import jsonschema

    return jsonschema.Draft202012Validator({"$ref": f"#/$defs/{part}", "$defs": schema["$defs"]})


def test_the_command_prints_it(capsys, schema):
    import jsonschema

    assert main(["schema"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads(json.dumps(schema))
    jsonschema.Draft202012Validator.check_schema(printed)


def test_every_section_and_field_stands_in_it_with_unit_and_meaning(schema):
    sections = schema["$defs"]["model"]["properties"]
    assert set(sections) == set(SECTIONS)
    assert set(sections["cogging"]["properties"]) == set(COGGING_KEYS)
    effects = {entry["properties"]["name"]["const"]: entry for entry in sections["effects"]["items"]["oneOf"]}
    assert set(effects) == set(cogging.EFFECTS)
    controllers = {entry["properties"]["type"]["const"]: entry for entry in sections["controller"]["oneOf"]}
    assert set(controllers) == set(CONTROLLERS)
    motions = {entry["properties"]["type"]["const"]: entry for entry in schema["$defs"]["reference"]["oneOf"]}
    assert set(motions) == {*REFERENCES, "sampled"}
    assert set(motions["sampled"]["properties"]) == {*SAMPLED_KEYS, "type", "duration"}
    structs = [
        *((kind, effects[name]) for name, kind in cogging.EFFECTS.items()),
        *((kind, controllers[name]) for name, (kind, _) in CONTROLLERS.items()),
        *((kind, motions[name]) for name, (kind, _) in REFERENCES.items()),
        (cogging.AxisParameters, sections["axis"]),
        (cogging.EncoderParameters, sections["encoder"]),
        (cogging.NoiseParameters, sections["noise"]),
    ]
    for struct, entry in structs:
        assert not entry["additionalProperties"]
        for name, (unit, meaning) in struct.FIELDS.items():
            field = entry["properties"][name]
            assert field["unit"] == unit
            assert field["description"] == meaning


def test_models_of_the_tests_are_valid(schema):
    check = validator(schema, "model")
    for text in (CONTRACT, MODEL):
        check.validate(parse_toml(text))
        check.validate(cogging.Model.from_dict(parse_toml(text)).to_dict())
    validator(schema, "reference").validate(parse_toml(REFERENCE))


@pytest.mark.parametrize(("controller", "effect"), covering(sorted(CONTROLLERS), sorted(cogging.EFFECTS)))
def test_what_is_written_is_valid(schema, controller, effect):
    model = cogging.Model(
        axis=cogging.AxisParameters(mass=0.15),
        effects=(cogging.EFFECTS[effect](),),
        controller=CONTROLLERS[controller][0](),
        controller_type=controller,
    )
    validator(schema, "model").validate(parse_toml(to_toml(model.to_dict())))


@pytest.mark.parametrize(
    "case", ["unknown key", "unknown section", "unknown effect", "unknown effect field", "no axis"]
)
def test_what_the_reader_refuses_for_its_shape_is_not_valid(schema, case):
    check = validator(schema, "model")
    assert not check.is_valid(parse_toml(BAD[case][0]))


@pytest.mark.parametrize("case", ["no mass", "mass text", "mass bool", "sine alone", "controller type", "ragged rows"])
def test_wrong_values_are_not_valid_or_are_rules_between_fields(schema, case):
    between_fields = case in ("sine alone", "ragged rows")
    assert validator(schema, "model").is_valid(parse_toml(BAD[case][0])) == between_fields


def test_references(schema):
    check = validator(schema, "reference")
    check.validate({"type": "sine", "amplitude": 0.1, "frequency": 1, "duration": 2.0})
    check.validate({"type": "sampled", "file": "motion.csv"})
    assert not check.is_valid({"type": "sine"})
    assert not check.is_valid({"type": "circle"})
    assert not check.is_valid({"type": "sine", "duration": 1, "phase": 0.0})
