"""The regression of one joint: bounded least squares against all choices of bounds, errors against repeated draws."""

from itertools import product

import numpy as np
import pytest

from mrts.identification.identify import fit_joint

SAME = 1e-9
"""Relative to the largest number of a fit: rounding of normal equations of four well scaled unknowns."""


def motion(rng, count=300):
    """q̈, sign(q̇), q̇ of blocks."""
    velocity = rng.uniform(0.2, 2, count) * rng.choice([-1, 1], count)
    return np.column_stack([rng.uniform(-6, 6, count), np.sign(velocity), velocity])


def fitted(columns, left_over, used=None):
    used = np.ones(len(columns), bool) if used is None else used
    return fit_joint(columns, left_over, used, fastest=3.0, torque_limit=1e9)


def best_of_all_bounds(columns, left_over):
    """The least sum of squares of all sets of parameters that are held at 0."""
    X = np.column_stack([columns, np.ones(len(columns))])
    best = (np.inf, np.zeros(4))
    for free in product([False, True], repeat=3):
        chosen = np.flatnonzero([*free, True])
        theta = np.zeros(4)
        theta[chosen] = np.linalg.lstsq(X[:, chosen], left_over)[0]
        if np.all(theta[:3] >= 0):
            best = min(best, (float(np.sum((left_over - X @ theta) ** 2)), theta), key=lambda pair: pair[0])
    return best[1]


@pytest.mark.quick
def test_bounded_least_squares_are_the_best_of_all_choices():
    rng = np.random.default_rng(30)
    held = 0
    for _ in range(200):
        columns = motion(rng, 40)
        left_over = columns @ rng.uniform(-0.5, 1, 3) * 3 + rng.normal(0, 0.1, 40) + 1
        fit, offset, *_ = fitted(columns, left_over)
        expected = best_of_all_bounds(columns, left_over)
        np.testing.assert_allclose([*fit["value"], offset], expected, atol=SAME * np.max(np.abs(expected)))
        np.testing.assert_array_equal(fit["bounded"], expected[:3] == 0)
        held += int(np.count_nonzero(fit["bounded"]))
    assert held > 100
