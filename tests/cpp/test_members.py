"""Switches and pointers in structs of the core have a value from the start: none is read before it is written."""

import re
from pathlib import Path

CPP = Path(__file__).resolve().parents[2] / "cpp"
SOURCES = sorted(path for ending in ("*.hpp", "*.cpp") for path in CPP.rglob(ending))
#: A bool that is neither and a pointer to nowhere are worse than a wrong number: to read them is undefined.
NOT_SET = re.compile(r"^(?:const )?(?:bool\s|[\w:<>]+\s?\*\s?)(?:const )?\w+(?:,\s*\w+)*;$")


def bare_members(text):
    """Switches and pointers without a value among the members of structs."""
    text = re.sub(r"//[^\n]*|\"(?:[^\"\\]|\\.)*\"|(?<![0-9])'(?:[^'\\]|\\.)*'", "", text)
    found, open_braces, statement = [], [], ""
    for letter in text:
        if letter == "{":
            record = re.search(r"\bstruct (?:alignas\(.*?\) )?(\w+)[^;()]*$", statement)
            open_braces.append((record[1] if record else "", []))
            statement = ""
        elif letter == "}":
            name, members = open_braces.pop()
            found += [f"{name}: {member}" for member in members]
            statement = ""
        elif letter == ";":
            line = " ".join(f"{statement};".split())
            if open_braces and open_braces[-1][0] and NOT_SET.match(line):
                open_braces[-1][1].append(line)
            statement = ""
        else:
            statement += letter
    return found


def test_what_has_no_value_is_seen():
    text = """
    struct A {
      bool on;  // a comment; with { marks
      bool off = false, other{};
      double *at, n;
      void f() const { bool local; }
      struct B : C { const T<double>* x; int y; };
    };
    class D { bool made_by_its_constructor; };
    """
    assert bare_members(text) == ["B: const T<double>* x;", "A: bool on;", "A: double *at, n;"]


def test_switches_and_pointers_have_a_value_from_the_start():
    assert len(SOURCES) > 100
    found = {str(path.relative_to(CPP)): bare_members(path.read_text()) for path in SOURCES}
    assert {path: members for path, members in found.items() if members} == {}
