"""What the package gave when values.json was written; `python -m tests.golden.small` rewrites that file.

Figures are compared within 1e-9, since another compiler may round another last bit.
"""

import json

import pytest

from tests.golden import small as golden_small

VALUES = json.loads(golden_small.FILE.read_text())


def test_the_logs_of_every_controller_and_effect():
    found = golden_small.logs()
    assert found.keys() == VALUES["logs"].keys()
    for name, values in VALUES["logs"].items():
        assert found[name] == pytest.approx(values, rel=1e-9, abs=1e-15), name


@pytest.mark.parametrize("hidden", golden_small.HIDDEN)
def test_the_verdict_on_a_log(hidden):
    assert golden_small.verdict(hidden) == VALUES["verdicts"][hidden]
