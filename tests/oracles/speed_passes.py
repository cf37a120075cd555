"""Half-planes of polygons over u and x, and passes through them by all corners there are, in numpy."""

from itertools import combinations

import numpy as np

ON_LIMIT = 2e-10
"""Rounding of a speed on a limit, as the kernel lets pass."""

INSIDE = 1e-11
"""Of the terms of a half-plane: corners that miss it by no more are on it."""


def half_planes(number, corners, unit, cap, box, near):
    """As `mrts.kernel.programs.Programs.half_planes`, one polygon after the other."""
    polygons = np.split(corners, np.cumsum(number)[:-1])
    found = [_edges(*given, box, near) for given in zip(polygons, unit, cap.tolist(), strict=True)]
    low, high = (np.array([of(p[:, 1]) if len(p) else 0.0 for p in polygons]) for of in (np.min, np.max))
    return np.cumsum([0, *map(len, found)], dtype=np.int64), np.concatenate(found), low, high


def _edges(polygon, unit, cap, box, near):
    """Half-planes of the edges that are not those of bounds of |u| and x, Shape (e, 3)."""
    after = np.roll(polygon, -1, axis=0)
    (u, x), (along_u, along_x) = polygon.T, (after - polygon).T
    length = np.sqrt(along_u * along_u + along_x * along_x)  # as the kernel: of what underflows nothing is left
    on_box = np.minimum(np.abs(u), np.abs(after[:, 0])) >= near * box
    on_bound = (np.minimum(x, after[:, 1]) >= near * cap) | (np.maximum(x, after[:, 1]) <= 1 / box**2)
    edge = (length > 0) & ~on_box & ~on_bound
    normal = np.column_stack([along_x, -along_u])[edge] / length[edge, None]
    planes = np.column_stack([normal / unit, np.sum(normal * polygon[edge], axis=1)])
    if len(polygon) not in {1, 2} or np.isinf(unit[0]):
        return planes
    across = [[1 / unit[0], 0.0, np.max(u)], [-1 / unit[0], 0.0, -np.min(u)]]  # a point or a segment along itself
    return np.concatenate([planes, across])


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
