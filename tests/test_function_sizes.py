"""No function is longer than a screen: at most 40 lines of code, without docstring, blank and comment lines.

That none has more than 12 branches is a rule of the linter (PLR0912).
"""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
MOST = 40
#: Still to be split: beginnings of paths.
EXEMPT = ()
EXEMPT_IN_C = ("cpp/bindings/",)  # registrations: a statement and a docstring for each name

NOT_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"\(.*?\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|^\s*#[^\n]*', re.S | re.M
)
BLOCKS = re.compile(r"(?:else|do|try|namespace|extern|if|for|while|switch|catch)\b")
PARAMETERS = re.compile(r"\([^()]*\)")
TYPES = re.compile(r"(?<=\w)<[^<>]*>|(?<=template )<[^<>]*>")


def python_functions(text):
    """Name and number of code lines of each function of a Python text, those within others included."""
    lines = text.splitlines()
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        first = node.body[0]
        told = set()
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str):
            told = set(range(first.lineno, first.end_lineno + 1))
        numbers = set(range(node.lineno, node.end_lineno + 1)) - told
        yield node.name, sum(1 for n in numbers if lines[n - 1].strip() and not lines[n - 1].strip().startswith("#"))


def c_functions(text):
    """The same of a C++ text, by its braces: what has parameters before a body; a lambda counts with its function."""
    code = NOT_CODE.sub(lambda found: re.sub(r"[^\n]", " ", found.group()), text)
    blocks, begin, brackets = [], 0, 0
    for place, letter in enumerate(code):
        brackets += (letter == "(") - (letter == ")")
        if brackets:  # a lambda or a list that is passed
            continue
        if letter == "{" and code[place - 1].isspace():
            blocks.append((begin, head_of(code[begin:place]) if not any(head for _, head in blocks) else ""))
        elif letter == "{":  # a value's own
            blocks.append((None, ""))
        elif letter == "}":
            start, head = blocks.pop()
            if head:
                yield head, sum(1 for line in code[start : place + 1].strip().splitlines() if line.strip())
            if start is None:
                continue
        if letter in "{};":
            begin = place + 1


def head_of(text):
    """What stands before the body of a function, its parameters as @; nothing before another block."""
    head = " ".join(text.split())
    bare = re.sub(r"operator\W+", "operator ", head)
    while bare != (bare := PARAMETERS.sub("@", TYPES.sub("", bare))):  # whatever stands in them
        pass
    return bare if "@" in bare and "=" not in bare and not BLOCKS.match(head) else ""


def too_long(functions, paths, exempt):
    """What is longer, by file."""
    for path in paths:
        name = path.relative_to(ROOT).as_posix()
        if not name.startswith(exempt):
            yield from (
                f"{name}: {function}: {lines}" for function, lines in functions(path.read_text()) if lines > MOST
            )


def test_functions_of_python_are_short():
    paths = sorted((ROOT / "python").rglob("*.py"))
    assert len(paths) > 100
    assert list(too_long(python_functions, paths, EXEMPT)) == []


def test_functions_of_the_core_are_short():
    paths = sorted(path for path in (ROOT / "cpp").rglob("*") if path.suffix in (".hpp", ".cpp"))
    assert len(paths) > 50
    assert list(too_long(c_functions, paths, EXEMPT_IN_C)) == []


def test_the_lines_that_count():
    text = '''
class A:
    def f(self):
        """A.

        B.
        """

        # why
        def g():
            return 1

        return g
'''
    assert dict(python_functions(text)) == {"f": 4, "g": 2}
    text = """
namespace a {  // one
struct B {
    /* of
       two lines */
    template <class T>
    double f(const T& x, std::span<const double> y = {}) const {

        // why
        const auto g = [&](double z) {
            if (z > 0.0) {
                return "{";
            }
            return z;
        };
        return g(x);
    }
    B(int a, int b) : a_{a}, b_(b) { check(); }
};
}
"""
    assert [lines for _, lines in c_functions(text)] == [10, 1]
