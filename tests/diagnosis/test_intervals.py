"""Effects that act in an interval of time."""

from cogging import EFFECTS
from cogging.diagnosis.candidates.findings import judged
from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.evidence.null import fit_null
from cogging.effects.effect import VOCABULARY
from tests.fixtures.moving_axis import machine, record


def test_an_interval_is_found_at_its_edges():
    step = EFFECTS["disturbance_step"](force=0.06, start=3.217, stop=4.391)
    evidence = fit_null([record(machine([step]), 13)], machine())[1]
    (found,) = scan(evidence, [VOCABULARY["disturbance_step"]])
    true = Candidate(
        VOCABULARY["disturbance_step"], {"start": 3.217, "stop": 4.391}, found.candidate.amplitudes, (1e-3,)
    )
    (there,) = judged(evidence, [true], 1.0)
    assert found.test.statistic > 0.98 * there.test.statistic > 10.0
