"""Polygons over u and x, their half-planes, and passes through them: by the kernel and in numpy."""

import numpy as np
import pytest
import speed_passes

from mrts.kernel.programs import OPTIMAL, default_programs

SAME = 1e-9
"""Of a speed: the corners of nearly parallel half-planes are right to so much."""


@pytest.mark.quick
def test_a_projection_without_area_is_two_corners():
    """What lies between them on their line bounds nothing, and hides that they bound u along itself."""
    rng = np.random.default_rng(10)
    count, rows, unknowns = 60, 9, 5
    A = rng.normal(size=(count, rows, unknowns))
    lower, upper = -rng.uniform(0.1, 1, (count, rows)), rng.uniform(0.1, 1, (count, rows))
    A[:, 0, :3] = 0.0  # a line in u and x
    A[: count // 3, 0, 3] = 0.0  # along u
    lower[:, 0] = upper[:, 0] = 0.0
    A[:, 1:4, :3] = np.eye(3)
    scale, bound = np.ones((count, unknowns)), np.full((count, 2), 3.0)
    number, corners, status = default_programs().projections(A, lower, upper, scale, (-bound, bound))
    assert np.all(status == OPTIMAL)
    assert np.all(number == 2)
    assert np.all(np.abs(np.sum(corners * np.repeat(A[:, 0, 3:], 2, axis=0), axis=1)) < 1e-9)


@pytest.mark.parametrize("largest", [2.0, 1e15])
def test_speeds_are_those_of_the_oracle(largest):
    rng = np.random.default_rng(9)
    outcomes = set()
    for _ in range(40):
        n = 12
        counts = rng.integers(3, 8, n)
        start = np.concatenate([[0], np.cumsum(counts)])
        planes = np.column_stack([rng.normal(size=(start[-1], 2)), rng.uniform(-0.05, 1, start[-1])])
        step = rng.uniform(0.05, 0.2, n - 1)
        rise = rng.uniform(-0.1, 0.1, n - 1)
        found = []
        for kernel in (default_programs(), speed_passes):
            low, high = np.zeros(n), np.full(n, largest)
            low[-1] = high[-1] = 0.0
            failed = kernel.backward(step, rise, start, planes, low, high)
            x = kernel.forward(step, rise, start, planes, low, high, high[0]) if failed < 0 else np.zeros(n)
            found.append((failed, low[failed + 1 :], high[failed + 1 :], x))
        (failed, *arrays), (other, *others) = found
        assert failed == other
        outcomes.add(failed < 0)
        for ours, theirs in zip(arrays, others, strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=SAME, atol=SAME)
    assert outcomes == {True, False}
