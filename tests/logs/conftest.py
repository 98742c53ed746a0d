"""What the tests of logs share."""

import numpy as np
import pytest

from cogging.logs.readers import isolate


@pytest.fixture
def read_here(monkeypatch):
    """Read binary formats in this process: what a reader makes of a file, and not how it is kept apart."""

    def read(kind, request):
        return {name: np.array(column, dtype=float) for name, column in isolate._read(kind, request).items()}

    monkeypatch.setattr("cogging.logs.columns.read_isolated", read)
