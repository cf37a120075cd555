"""Smooth timing of one arm with limited jerk against copp's third-order solver: published robots, random paths."""

import numpy as np
import pytest
from copp_timing import by_copp, dense, dense_of_ours
from jerk_paths import jerk_path

import mrts

NODES = 200
PATHS = 3  # of each robot
LONGER = 1e-3
"""Share of copp's duration by which ours may be longer."""

POINTS = 20  # of each segment
BETWEEN = 2e-4
"""Share of velocity and torque limits that may be overstepped between nodes: what we look for is half of it."""

JERK_BETWEEN = 3e-3
"""Likewise of jerk: q''' is that of polynomials through places an eighth of a step apart."""


@pytest.mark.parametrize("robot", ["ur5", pytest.param("panda", marks=pytest.mark.slow)])
def test_never_longer_than_copp(robot, tmp_path):
    """Same velocity, torque and jerk limits, same number of nodes; copp has its two linearisations."""
    for seed in range(PATHS):
        path = jerk_path(robot, seed, tmp_path)
        *_, theirs = by_copp(path, NODES)
        ours = mrts.retime(path.cell, path.motion(NODES), rates=True, between=None).duration
        assert ours < (1 + LONGER) * theirs, (seed, ours, theirs)


@pytest.mark.parametrize(
    ("robot", "seed"), [("ur5", 9), *(pytest.param("panda", seed, marks=pytest.mark.slow) for seed in (1, 2))]
)
def test_limits_between_the_nodes_are_kept_better(robot, seed, tmp_path):
    """Both densely along the exact path: where torque binds we overstep it less. Of jerk see `JERK_BETWEEN`."""
    path = jerk_path(robot, seed, tmp_path)
    ours = mrts.retime(path.cell, path.motion(NODES), rates=True)
    velocity, torque, jerk = dense_of_ours(ours, path, POINTS).excess(path)
    theirs = dense(*by_copp(path, NODES), POINTS).excess(path)
    assert max(velocity, torque) < BETWEEN
    assert torque < max(theirs[1], 0.0) or theirs[1] < 0
    assert jerk < JERK_BETWEEN


@pytest.mark.parametrize("robot", ["ur5", pytest.param("panda", marks=pytest.mark.slow)])
def test_a_path_starts_and_ends_with_constant_jerk(robot, tmp_path):
    """Inside the end segments too, where no row at a node sees x fall: jerk would be 4 times its limit there."""
    path = jerk_path(robot, 0, tmp_path)
    found = mrts.retime(path.cell, path.motion(NODES), rates=True, between=None)
    profile, (*_, most) = dense_of_ours(found, path, POINTS), path.limits
    first, second, third = (path.at(profile.s, order) for order in (1, 2, 3))
    speed, x = np.sqrt(profile.square)[:, None], profile.square[:, None]
    jerk = first * profile.jerk[:, None] + 3 * second * profile.rate[:, None] * speed + third * x * speed
    share = np.max(np.abs(jerk) / most, axis=1).reshape(-1, POINTS)
    assert np.max(share[[0, 1, -2, -1]]) < 1.01
    assert np.min(share[[0, -1]]) > 0.95


def test_the_exact_profile_of_a_path_is_right(tmp_path):
    """What both profiles are judged by: the path's derivatives by time against differences."""
    path, step = jerk_path("ur5", 0, tmp_path), 1e-4
    time = np.linspace(0.2, 0.8, 7)
    _, v, a, j = path.course(time)
    s = [path.s_at(time + k * step) for k in (-2, -1, 0, 1, 2)]
    np.testing.assert_allclose((s[3] - s[1]) / (2 * step), v, rtol=1e-6)
    np.testing.assert_allclose((s[3] - 2 * s[2] + s[1]) / step**2, a, atol=1e-3 * np.max(np.abs(a)))
    np.testing.assert_allclose((s[4] - 2 * s[3] + 2 * s[1] - s[0]) / (2 * step**3), j, atol=0.02 * np.max(np.abs(j)))
