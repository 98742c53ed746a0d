"""The scan of all effects."""

from dataclasses import replace

import pytest

from cogging import EFFECTS
from cogging.diagnosis.candidates.findings import judge
from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.residual.shapes import shapes
from cogging.effects.effect import VOCABULARY
from tests.fixtures.moving_axis import machine, record


def test_nothing_is_found_where_nothing_is_hidden(quiet_evidence):
    assert all(finding.log_p_value > -9.5 for finding in scan(quiet_evidence, VOCABULARY.values()))
    assert all(shape.log_p_value > -12.0 for shape in shapes(quiet_evidence))


def test_a_scan_on_many_threads_finds_what_one_finds(quiet_evidence, monkeypatch):
    names = ["cable_spring", "command_delay", "flexible_mode", "force_constant_ripple", "coulomb_asymmetry"]
    found = []
    for threads in (1, 4):
        monkeypatch.setattr("os.cpu_count", lambda threads=threads: threads)
        quiet_evidence.memory.clear()
        found.append(
            [
                (f.candidate, f.score, list(f.amplitudes))
                for f in scan(quiet_evidence, [VOCABULARY[name] for name in names])
            ]
        )
    assert len(found[0]) > 1
    assert found[0] == found[1]


@pytest.mark.parametrize("disturbed", [1e-8, -1e-8])
def test_what_only_the_processor_tells_apart_keeps_the_order_of_the_list(disturbed):
    """As other kernels of linear algebra make it: the second of two alike does not come first by its last bits."""
    truth, nominal = machine([EFFECTS["cable_spring"](stiffness=1.5)]), machine()
    evidence = fit_null([record(truth, 11)], nominal)[1]
    (spring,) = scan(evidence, [VOCABULARY["cable_spring"]])
    test = replace(spring.test, statistic=spring.test.statistic * (1.0 + disturbed))
    twin = judge(evidence, spring.candidate, test, spring.trials)
    again = judge(evidence, spring.candidate, spring.test, spring.trials)
    assert twin.test.statistic != again.test.statistic
    for pair in ([again, twin], [twin, again]):
        assert [id(one) for one in sorted(pair, key=lambda one: -one.score)] == [id(one) for one in pair]
