"""The scan of all effects."""

from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.residual.shapes import shapes
from cogging.effects.effect import VOCABULARY


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
