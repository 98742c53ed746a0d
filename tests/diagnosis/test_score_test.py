"""The geometry of rows that a score test rests on."""

import numpy as np

from cogging.diagnosis.evidence.score_test import orthonormal


def test_orthonormal_spans_and_is_orthonormal():
    rows = np.random.default_rng(1).normal(size=(4, 50))
    rows = np.vstack([rows, rows[0] + rows[1]])
    basis = orthonormal(rows)
    assert len(basis) == 4
    np.testing.assert_allclose(basis @ basis.T, np.eye(4), atol=1e-8)
    np.testing.assert_allclose((rows @ basis.T) @ basis, rows, atol=1e-6)
