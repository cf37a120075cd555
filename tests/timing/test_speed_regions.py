"""Regions of speeds along a path, each started from the one before, against HiGHS, cold starts and single chunks."""

import numpy as np
import pytest
from random_programs import cell_programs

from mrts.kernel.programs import INFEASIBLE, OPTIMAL, projections

ARMS = ((2, 3), (3, 3), (2, 6), (3, 6))
DIRECTIONS = 24
SAME = 3e-9
"""Of a limit: each polygon lies inside the true one by less than 1e-9, beside corners of its own size."""

LARGEST = 50.0
"""u and x end where they move some row by this many limits."""


def along_a_path(rng, count, arms, size, *, alone=False):
    """Rows over [F, u, x] that change slowly: A, lower, upper, scale, bounds.

    With `alone` wrenches that are unknowns have limits of their own, as those of a cell; u moves all rows without.
    """
    A, lower, upper = cell_programs(rng, count, arms, size)
    wave = np.sin(np.linspace(0, 3, count))[:, None]
    of_u = rng.normal(size=A.shape[1]) + rng.normal(size=A.shape[1]) * wave
    of_u[:, alone & bounds_one(A)] = 0
    A = np.concatenate([A[:, :, :-1], of_u[:, :, None], A[:, :, -1:]], axis=2)
    scale = 1 / np.max(np.abs(A), axis=1)
    bound = np.full((count, 2), LARGEST)
    return A, lower, upper, scale, (np.where([True, False], -bound, 0.0), bound)


def bounds_one(A):
    """Rows that bound one unknown at every sample, Shape (r,)."""
    return np.all(np.count_nonzero(A, axis=2) == 1, axis=0)


def at(given, samples):
    A, lower, upper, scale, bounds = given
    return A[samples], lower[samples], upper[samples], scale[samples], tuple(bound[samples] for bound in bounds)


def polygons(number, corners):
    return np.split(corners, np.cumsum(number)[:-1])


def directions():
    angles = np.linspace(0, 2 * np.pi, DIRECTIONS, endpoint=False) + 0.1
    return np.stack([np.cos(angles), np.sin(angles)])


@pytest.mark.quick
@pytest.mark.parametrize(("arms", "size"), ARMS)
@pytest.mark.parametrize("seed", range(4))
def test_a_projection_does_not_depend_on_the_one_before(arms, size, seed):
    given = along_a_path(np.random.default_rng([18, arms, size, seed]), 300, arms, size, alone=seed % 2 == 1)
    number, corners, status = projections(*given)
    assert np.all((status == OPTIMAL) == (number > 0))
    compared = 0
    for sample, polygon in enumerate(polygons(number, corners)):
        cold_number, cold, cold_status = projections(*at(given, [sample]))
        assert (cold_status[0] == OPTIMAL) == (status[sample] == OPTIMAL)
        if cold_number[0]:
            ours, theirs = (np.max(points @ directions(), axis=0) for points in (polygon, cold))
            np.testing.assert_allclose(ours, theirs, rtol=SAME, atol=SAME)
            compared += 1
    assert compared > 100 or np.mean(status == INFEASIBLE) > 0.5


@pytest.mark.quick
def test_a_sample_without_a_projection_leaves_those_beside_it_as_they_are():
    """No number where a row is said to bound one unknown, and sides that cross, each in the middle of four samples."""
    given = along_a_path(np.random.default_rng(184), 1000, 2, 6, alone=True)
    number, corners, status = projections(*given)
    assert np.all(status == OPTIMAL)
    A, lower, upper, *rest = given
    row = np.flatnonzero(bounds_one(A))[0]
    unknown = int(np.argmax(A[0, row] == 0))
    bad = np.arange(9, 1000, 9)  # in each of the four places
    no_number, crossed = bad[::2], bad[1::2]
    A, upper = A.copy(), upper.copy()
    A[no_number, row, unknown] = np.nan
    upper[crossed, row] = lower[crossed, row] - 1
    found, places, answers = projections(A, lower, upper, *rest)
    np.testing.assert_array_equal(np.flatnonzero(found == 0), bad)
    assert np.all(answers[crossed] == INFEASIBLE)
    assert not np.any(np.isin(answers[no_number], [OPTIMAL, INFEASIBLE]))
    for ours, clean in zip(polygons(found, places), polygons(number, corners), strict=True):
        if len(ours):
            reaches = [np.max(points @ directions(), axis=0) for points in (ours, clean)]
            np.testing.assert_allclose(*reaches, rtol=SAME, atol=SAME)


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
    number, corners, status = projections(A, lower, upper, scale, (-bound, bound))
    assert np.all(status == OPTIMAL)
    assert np.all(number == 2)
    assert np.all(np.abs(np.sum(corners * np.repeat(A[:, 0, 3:], 2, axis=0), axis=1)) < 1e-9)
