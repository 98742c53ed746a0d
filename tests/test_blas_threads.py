"""Linear algebra runs on one thread while the package computes: answers do not depend on how many there are."""

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import cogging
from tests.fixtures.examples import LOG, MODEL


def blas_threads():
    return {one["filepath"]: one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


def test_one_thread_within_a_call_and_what_was_there_afterwards():
    within = []
    with threadpool_limits(2, user_api="blas"):
        before = blas_threads()
        cogging.identify(LOG, MODEL, free=["axis.mass"], progress=lambda step: within.append(blas_threads()))
        assert blas_threads().items() >= before.items()
        with pytest.raises(ZeroDivisionError):
            cogging.identify(LOG, MODEL, free=["axis.mass"], progress=lambda step: 1 / 0)
        assert blas_threads().items() >= before.items()
    assert 2 in before.values()
    assert set(within[0].values()) == {1}
