"""The core's types are written from its bindings, and what is public is documented."""

import ast
import inspect

import cogging
from cogging import _core
from tests.attack.stub_signatures import stubs


def test_each_class_and_function_of_the_core_has_its_types():
    named = {node.name for text in stubs().values() for node in ast.parse(text).body if hasattr(node, "name")}
    bound = {name for module in (_core, _core.effects) for name, one in vars(module).items() if callable(one)}
    assert {name for name in bound if not name.startswith("_")} <= named


def test_everything_public_is_documented():
    undocumented = [
        name
        for name in cogging.__all__
        if callable(getattr(cogging, name)) and not inspect.getdoc(getattr(cogging, name))
    ]
    assert undocumented == []


def test_parameter_structs_are_read_only_and_say_their_units():
    structs = [kind for kind in vars(_core).values() if inspect.isclass(kind) and hasattr(kind, "FIELDS")]
    structs += list(cogging.EFFECTS.values())
    assert len(structs) > 15
    for struct in structs:
        made = struct()
        for name, (_unit, meaning) in struct.FIELDS.items():
            assert meaning, f"{struct.__name__}.{name} has no meaning"
            try:
                setattr(made, name, 1.0)
            except AttributeError:
                continue
            raise AssertionError(f"{struct.__name__}.{name} can be changed")
