"""The regression of one joint: bounded least squares against all choices of bounds, errors against repeated draws."""

from itertools import product

import numpy as np
import pytest
from scipy import stats

from mrts.identification.motor_regression import fit_joint

SAME = 1e-9
"""Relative to the largest number of a fit: rounding of normal equations of four well scaled unknowns."""
DRAWS = 400
SPREAD_BY_CHANCE = 0.2
"""Of a standard deviation of so many draws 1 / √(2 DRAWS) = 0.035 is chance; a covariance in time is found short."""


def motion(rng, count=300):
    """q̈, q̇, sign(q̇) of blocks."""
    velocity = rng.uniform(0.2, 2, count) * rng.choice([-1, 1], count)
    return np.column_stack([rng.uniform(-6, 6, count), velocity, np.sign(velocity)])


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
        np.testing.assert_allclose([*fit.value, offset], expected, atol=SAME * np.max(np.abs(expected)))
        np.testing.assert_array_equal(fit.bounded, expected[:3] == 0)
        held += int(np.count_nonzero(fit.bounded))
    assert held > 100


@pytest.mark.parametrize("memory", [0.0, 0.6])
def test_standard_errors_are_those_of_repeated_draws(memory):
    """Of white noise, and of noise whose blocks depend on each other while the motion is slow, with blocks left out."""
    rng = np.random.default_rng(31)
    time = np.arange(600)
    velocity = np.sin(2 * np.pi * time / 40) + 0.5 * np.sin(2 * np.pi * time / 23)
    columns = np.column_stack([np.gradient(velocity) * 10, velocity, np.sign(velocity)])
    used = np.abs(velocity) > 0.1
    values, claimed = [], []
    for _ in range(DRAWS):
        noise = rng.normal(0, 1, len(time))
        for block in range(1, len(time)):
            noise[block] += memory * noise[block - 1]
        fit, *_ = fitted(columns, columns @ [2.0, 5.0, 4.0] + noise, used)
        assert not any(fit.bounded)
        values.append(fit.value)
        claimed.append(fit.half_width / stats.t.ppf(0.975, np.count_nonzero(used) - 4))
    spread, said = np.std(values, axis=0), np.mean(claimed, axis=0)
    print("standard errors claimed", said, "of repeated draws", spread)
    np.testing.assert_allclose(said, spread, rtol=SPREAD_BY_CHANCE)


def test_blocks_that_do_not_count_change_nothing():
    rng = np.random.default_rng(32)
    columns = motion(rng)
    left_over = columns @ [0.5, 2.0, 3.0]
    used = rng.random(len(columns)) < 0.7
    spoilt = np.where(used, left_over, 1e6)
    np.testing.assert_allclose(fitted(columns, spoilt, used)[0].value, [0.5, 2.0, 3.0], rtol=1e-12)
    unknown, *_ = fitted(columns, left_over, np.arange(len(columns)) < 4)
    assert unknown.reasons == ("it hardly moves in the recording",) * 3
    assert np.all(unknown.half_width == np.inf)
