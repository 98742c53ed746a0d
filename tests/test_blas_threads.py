"""Linear algebra runs on one thread while the package computes: answers do not depend on how many there are."""

from threadpoolctl import threadpool_info, threadpool_limits

import cogging
from tests.fixtures.examples import LOG, MODEL


def blas_threads():
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


def test_one_thread_within_a_call_and_what_was_there_afterwards():
    within = []
    with threadpool_limits(2, user_api="blas"):
        cogging.identify(LOG, MODEL, free=["axis.mass"], progress=lambda step: within.append(blas_threads()))
        assert (within[0], blas_threads()) == ({1}, {2})
        try:
            cogging.identify(LOG, MODEL, free=["axis.mass"], progress=lambda step: 1 / 0)
        except ZeroDivisionError:
            assert blas_threads() == {2}
