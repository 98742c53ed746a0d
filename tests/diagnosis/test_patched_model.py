"""Paths and intervals of effects in a patched model."""

import pytest

from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import Evidence
from cogging.diagnosis.patched_model import paths_without, with_intervals
from cogging.effects.effect import VOCABULARY
from tests.fixtures.pid_axis import MODEL, run


def test_intervals_stay_with_their_effects_where_one_between_them_is_left_out():
    sizes = {0.05: 0.02, 0.031: 0.03, 0.019: 0.04}  # V by period (m)
    waves = [VOCABULARY["cogging_harmonic"].replace(period=p, sine=s, cosine=0.0) for p, s in sizes.items()]
    spring = VOCABULARY["cable_spring"].replace(stiffness=0.5, center=0.1)
    log = run(*waves, spring, seed=4)
    balance = DifferencedBalance(log, quantum=MODEL.encoder.resolution)
    evidence = Evidence([balance], MODEL, MODEL.replace(effects=(*waves, spring))).prepare(2, listen=True)
    whole = evidence.model
    first, gone, last = (f"effects.cogging_harmonic[{place}]" for place in range(3))
    names = paths_without(whole, {gone})
    assert names == {first: first, last: gone, "effects.cable_spring": "effects.cable_spring"}
    everything = with_intervals(whole, evidence, whole, {path: path for path in [first, gone, last, *names]})
    patched = whole.replace(effects=(whole.effects[0], *whole.effects[2:]))
    found = with_intervals(patched, evidence, whole, names)
    for new, old in ((first, first), (gone, last), ("effects.cable_spring", "effects.cable_spring")):
        for field in ("stiffness",) if "spring" in new else ("period", "sine", "cosine"):
            assert found.intervals[f"{new}.{field}"] == pytest.approx(everything.intervals[f"{old}.{field}"], rel=1e-12)
    assert found.intervals[f"{gone}.sine"][0] > 0.03
