"""The schema that `cogging schema` prints agrees with the readers."""

import json

import jsonschema
import pytest

import cogging
from cogging.cli.main import main
from cogging.file_schema import TUNE_INDEXES
from cogging.files import parse_toml, shipped_toml
from cogging.model.model import COGGING_KEYS, CONTROLLERS, SECTIONS
from cogging.simulation.reference import REFERENCES
from tests.fixtures import command_files
from tests.fixtures.files import MODEL
from tests.fixtures.model_files import BAD, CONTRACT


@pytest.fixture(scope="module")
def schema():
    return cogging.schema()


def validator(schema, part):
    return jsonschema.Draft202012Validator({"$ref": f"#/$defs/{part}", "$defs": schema["$defs"]})


def test_the_command_prints_it(capsys, schema):
    assert main(["schema"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads(json.dumps(schema))
    jsonschema.Draft202012Validator.check_schema(printed)


def test_every_section_and_field_has_its_unit_and_meaning(schema):
    sections = schema["$defs"]["model"]["properties"]
    assert set(sections) == set(SECTIONS)
    assert set(sections["cogging"]["properties"]) == set(COGGING_KEYS)
    effects = {entry["properties"]["name"]["const"]: entry for entry in sections["effects"]["items"]["oneOf"]}
    assert set(effects) == set(cogging.EFFECTS)
    controllers = {entry["properties"]["type"]["const"]: entry for entry in sections["controller"]["oneOf"]}
    assert set(controllers) == set(CONTROLLERS)
    motions = {entry["properties"]["type"]["const"]: entry for entry in schema["$defs"]["reference"]["oneOf"]}
    assert set(motions) == {*REFERENCES, "sampled"}
    assert set(schema["$defs"]["tune"]["properties"]["limits"]["properties"]) == set(TUNE_INDEXES)
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


FILES = [("model", parse_toml(CONTRACT)), ("model", parse_toml(MODEL)), ("reference", command_files.REFERENCE)]
FILES += [(part, getattr(command_files, part.upper())) for part in ("limits", "sweep", "tune")]
FILES += [(part, shipped_toml(f"cli/example_files/{part}.toml")) for part in ("limits", "sweep", "tune")]


@pytest.mark.parametrize(("part", "document"), FILES)
def test_files_and_the_examples_of_the_help_are_valid(schema, part, document):
    validator(schema, part).validate(document)


VALID = {"sine alone": True, "ragged rows": True}  # rules between fields
WRONG = ["unknown key", "unknown section", "unknown effect", "unknown effect field", "no axis", "no mass", "mass text"]


@pytest.mark.parametrize("case", [*WRONG, "mass bool", "controller type", *VALID])
def test_the_schema_refuses_what_the_reader_refuses_but_rules_between_fields(schema, case):
    assert validator(schema, "model").is_valid(parse_toml(BAD[case][0])) == VALID.get(case, False)
