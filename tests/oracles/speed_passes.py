"""Passes through half-planes over u and x by all corners there are, in numpy."""

from itertools import combinations

import numpy as np

ON_LIMIT = 2e-10
"""Rounding of a speed on a limit, as the kernel lets pass."""

INSIDE = 1e-11
"""Of the terms of a half-plane: corners that miss it by no more are on it."""


def backward(step, rise, start, planes, lower, upper):
    """As `mrts.kernel.programs.Programs.backward`: the least and largest x of the corners of each segment's polygon."""
    for i in range(len(step) - 1, -1, -1):
        A, limit = _segment(step, rise, start, planes, lower, upper, i)
        A, limit = np.vstack([A, [[0, -1], [0, 1]]]), np.concatenate([limit, [-lower[i], upper[i]]])
        one, other = np.array(list(combinations(range(len(A)), 2))).T
        pairs, sides = np.stack([A[one], A[other]], axis=1), np.stack([limit[one], limit[other]], axis=1)
        meet = np.linalg.det(pairs) != 0
        corners = np.linalg.solve(pairs[meet], sides[meet][:, :, None])[:, :, 0]
        off = corners @ A.T - limit
        inside = np.all(off <= INSIDE * (np.abs(corners) @ np.abs(A.T) + np.abs(limit)), axis=1)
        if not np.any(inside):
            return i
        lower[i], upper[i] = np.min(corners[inside, 1]), np.max(corners[inside, 1])
    return -1


def forward(step, rise, start, planes, lower, upper, first):
    """As `mrts.kernel.programs.Programs.forward`."""
    x = np.full(len(step) + 1, first)
    for i in range(len(step)):
        A, limit = _segment(step, rise, start, planes, lower, upper, i)
        left = limit - A[:, 1] * x[i]
        most, least = (
            of(left[sign * A[:, 0] > 0] / A[sign * A[:, 0] > 0, 0]) for of, sign in ((np.min, 1), (np.max, -1))
        )
        rate = most if most >= least else (most + least) / 2
        x[i + 1] = np.clip(x[i] + 2 * step[i] * rate, lower[i + 1], upper[i + 1])
    return x


def _segment(step, rise, start, planes, lower, upper, i):
    """Half-planes A (u, x_i) <= limit of a segment: of its start, of its end, and of what its end is to reach."""
    here, there = planes[start[i] : start[i + 1]], planes[start[i + 1] : start[i + 2]]
    ends = np.array([[-2 * step[i], -1.0], [2 * step[i], 1.0]])
    moved = np.column_stack([there[:, 0] + 2 * step[i] * there[:, 1], there[:, 1]])
    limits = np.concatenate([here[:, 2], there[:, 2]])
    risen = rise[i] / 2 * np.concatenate([here[:, 0], -there[:, 0]])
    limit = np.concatenate([limits + ON_LIMIT * (1 + np.abs(limits)) + risen, [-lower[i + 1], upper[i + 1]]])
    return np.concatenate([here[:, :2], moved, ends]), limit
