"""What corner forces inside friction pyramids must press to produce a wrench: linear programs, by HiGHS."""

from itertools import product

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import block_diag, csr_matrix

MANY = 25
"""Wrenches in one program, which is one block each: HiGHS takes longer to start than to solve a block."""


def axes_of(normal):
    """a, b and n in tip axes, as docs/cell_file.md says it."""
    n = np.array(normal, dtype=float) / np.linalg.norm(normal)
    a = np.array([0.0, 1.0, 0.0] if abs(n[0]) == max(abs(n)) else [1.0, 0.0, 0.0])
    a -= (a @ n) * n
    a /= np.linalg.norm(a)
    return a, np.cross(n, a), n


def corners(normal, widths):
    """Corners of the surface about the tip's origin, Shape (4, 3)."""
    a, b, _ = axes_of(normal)
    return np.array([x * widths[0] * a + y * widths[1] * b for x, y in product((-1, 1), repeat=2)])


def pressing(normal, widths):
    """Wrenches in tip axes of unit forces at the corners: along n, a and b, Shape (6, 12)."""
    a, b, n = axes_of(normal)
    return np.column_stack(
        [np.concatenate([force, np.cross(p, force)]) for p in corners(normal, widths) for force in (n, a, b)]
    )


def least_pressing(wrenches, normal, widths, mu):
    """Least sum of normal forces whose corner forces make each wrench, its normal force left open, Shape (N,).

    A corner's friction along a and b is within mu times its normal force, each by itself.
    """
    a, b, n = axes_of(normal)
    G = pressing(normal, widths)
    kept = np.block([[np.array([a, b]), np.zeros((2, 3))], [np.zeros((3, 3)), np.array([a, b, n])]])
    cone = np.array([[-mu, 1, 0], [-mu, -1, 0], [-mu, 0, 1], [-mu, 0, -1]])
    bounds = [(0, None), (None, None), (None, None)] * 4
    return least(kept @ G, kept @ wrenches.T, np.kron(np.eye(4), cone), bounds, np.tile([1.0, 0, 0], 4))


def least_squeezing(wrenches, axis, widths, mu):
    """Least sum of the normal forces of both pads of a gripper whose corner forces make each wrench, Shape (N,)."""
    here, there = pressing(axis, widths), pressing(axis, widths)
    there[:, ::3] *= -1
    cone = np.kron(np.eye(8), np.array([[-mu, 1, 0], [-mu, -1, 0], [-mu, 0, 1], [-mu, 0, -1]]))
    bounds = [(0, None), (None, None), (None, None)] * 8
    return least(np.hstack([here, there]), wrenches.T, cone, bounds, np.tile([1.0, 0, 0], 8))


def least(A, given, cone, bounds, cost):
    """Least cost of x with A x = each column of `given` and cone x <= 0."""
    scale = np.max(np.abs(A), axis=1)
    A, given = A / scale[:, None], given / scale[:, None]
    found = []
    for start in range(0, given.shape[1], MANY):
        part = given[:, start : start + MANY]
        count = part.shape[1]
        answer = linprog(
            np.tile(cost, count),
            A_ub=block_diag([csr_matrix(cone)] * count, format="csr"),
            b_ub=np.zeros(count * len(cone)),
            A_eq=block_diag([csr_matrix(A)] * count, format="csr"),
            b_eq=part.T.ravel(),
            bounds=bounds * count,
            method="highs",
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        assert answer.success, answer.message
        found.append(answer.x.reshape(count, -1) @ cost)
    return np.concatenate(found)
