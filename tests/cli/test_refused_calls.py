"""Calls that are refused: each in one line that says what was meant, and nothing is written."""

import pytest

from cogging.cli.main import COMMANDS, main
from cogging.outputs import to_toml
from tests.fixtures.command_files import LIMITS, REFERENCE

EXPERIMENT = "experiment --model model.toml --limits limits.toml --result result.json --out next.toml"
SIMULATE = "simulate model.toml --reference ref.toml --out"
#: A call, what the line says, and files that are other than usual.
CALLS = [
    # mistyped names
    ("dignose log.csv", "did you mean 'diagnose'?"),
    ("help dignose", "did you mean 'diagnose'?"),
    ("audit log.csv --cloumns x", "(did you mean '--columns'?)"),
    (f"{SIMULATE} x --sed 1", "(did you mean '--seed'?)"),
    ("audit log.csv --columns positon=x", "(did you mean 'position'?)"),
    ("audit log.csv --scale comand=2", "(did you mean 'command'?)"),
    ("audit log.csv --columns position=postion", "(did you mean 'position'?)"),
    ("audit log.csv --scale log.cvs:command=2", "(did you mean 'log.csv'?)"),
    ("identify log.csv --model model.toml --free axis.mas", "(did you mean 'axis.mass'?)"),
    (f"{SIMULATE} x.csv", "did you mean velocity?", {"ref.toml": to_toml(REFERENCE | {"velocty": 1.0})}),
    (EXPERIMENT, "did you mean acceleration?", {"limits.toml": to_toml(LIMITS | {"acceleraton": 1.0})}),
    ("sweep sweep.toml --out x.parquet", "did you mean vary?", {"sweep.toml": 'vari = "bounds"\n'}),
    # limits and results
    (EXPERIMENT, "line 1: velocity: must be a number above 0", {"limits.toml": to_toml(LIMITS | {"velocity": -1})}),
    (EXPERIMENT, "travel: must be inside the model's", {"limits.toml": to_toml(LIMITS | {"travel": [0.0, 9.0]})}),
    (EXPERIMENT, "result.json: must be the result of diagnose --json (JSON): ", {"result.json": "{"}),
    (EXPERIMENT, "must be the result of diagnose --json, got no verdict and effects", {"result.json": "{}"}),
    # options of a log
    ("audit log.csv --scale d.csv:command=2", "'d.csv': must be a file of this call, log.csv"),
    ("audit log.csv --rows d.csv:0:10", "must be a file of this call"),
    ("audit log.csv --zero velocity=2", "'velocity': must be a column of log.csv, time, position, command"),
    ("audit log.csv --rows log.csv:1", "rows"),
    ("audit log.csv --rows 7", "rows"),
    ("audit log.csv --zero position=inf", "zero"),
    ("map scan.csv --pitch 0.05 --zero other.csv:position=1", "must be a file of this call, scan.csv"),
    # numbers out of their range
    ("sweep sweep.toml --threads 2000", "argument --threads: must be a whole number from 0 to 1024, got '2000'"),
    ("tune tune.toml --threads -1", "argument --threads: must be a whole number from 0 to 1024, got '-1'"),
    (
        "predict model.toml --reference ref.toml --samples 1",
        "--samples: must be a whole number from 2 to 1000000, got '1'",
    ),
    (f"{SIMULATE} x.csv --seed -1", "--seed: must be a whole number from 0 to 18446744073709551615, got '-1'"),
    (f"{SIMULATE} x.csv --steps-per-sample x", "--steps-per-sample: must be a whole number from 1 to 10000, got 'x'"),
    # what is written beside an output
    (f"{SIMULATE} model", "its sidecar: model.toml: must not be"),
    (f"{SIMULATE} ref", "its sidecar: ref.toml: must not be"),
    ("map scan.csv --pitch 0.05 --out o.png", "--out, its figure: must be different files"),
    ("map log.png --pitch 0.05 --out log.toml", "its figure: log.png: must not be a file that", {"log.png": "x,F\n"}),
    ("reproduce lu2008 --out scan.csv/deep", "cannot be made"),
]


@pytest.mark.parametrize("case", CALLS, ids=lambda case: f"{case[0][:60]}: {case[1][:40]}")
def test_a_refused_call_is_one_line_and_writes_nothing(case, folder, refused):
    words, message, *changed = case
    for name, text in (changed[0] if changed else {}).items():
        (folder / name).write_text(text)
    refused(words.split(), message)


def test_the_commands_are_listed_by_help_and_without_a_command(capsys):
    assert main(["help"]) == 0
    whole = capsys.readouterr().out
    assert all(f"    {command} " in whole for command in COMMANDS)
    with pytest.raises(SystemExit) as ended:
        main([])
    printed = capsys.readouterr()
    assert (ended.value.code, printed.out) == (2, whole)
    assert printed.err == "cogging: a command must be given, got none; see cogging --help\n"
