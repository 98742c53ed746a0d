"""The benchmark compares like with like: all its controllers give the same commands."""

from tests.benchmarks import own_controllers


def test_every_way_is_measured_on_the_same_run():
    found = own_controllers.measure(1)  # asserts that the commands are the same
    assert {"core", "Python", "own calls", "their loop"} <= set(found)
    assert all(nanoseconds > 0.0 for nanoseconds in found.values())
