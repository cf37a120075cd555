"""The convex programs of smooth timing by cvxpy and Clarabel, which solves them as second-order cones."""

import warnings
from dataclasses import replace

import cvxpy as cp
import numpy as np
from scipy import sparse

from mrts.program.smooth_program import Goal, SmoothProfile, SmoothProgram, segment_times

STOPS = {"tol_gap_abs": 1e-9, "tol_gap_rel": 1e-9, "tol_feas": 1e-9}

THIN = {"static_regularization_constant": 1e-12}
"""What Clarabel adds to its pivots for torques: rates leave sets so thin that its default would be felt."""


def in_units_of(program: SmoothProgram, unit: float) -> SmoothProgram:
    """The same program with x and u in multiples of a unit [1/s²], and times in multiples of 1/√unit."""
    root, z = float(np.sqrt(unit)), np.array([unit, unit, 1.0])
    first, last = (None if x is None else x / unit for x in program.ends)
    return replace(
        program,
        square=program.square * unit,
        rate=program.rate * unit,
        root=program.root * root,
        change=program.change / root,
        jerk=program.jerk / (unit * root),
        gram=program.gram * np.outer(z, z),
        bound=program.bound * z,
        ends=(first, last),
    )


def goal_in_units_of(goal: Goal, unit: float) -> Goal:
    """The same goal for a program in other units."""
    root = float(np.sqrt(unit))
    longest = None if goal.longest is None else goal.longest * root
    return Goal(goal.time / root, goal.effort / root, longest, goal.uneven * unit**2)


def solved(cost, rows, **settings):
    """Whether Clarabel finds the least cost, as exactly as it can."""
    problem = cp.Problem(cp.Minimize(cost), rows)
    for stops in (STOPS, {}):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # less accurate: what answers are compared with says it
                problem.solve(solver=cp.CLARABEL, **stops, **settings)
        except cp.SolverError:
            continue
        if problem.status in {cp.OPTIMAL, cp.OPTIMAL_INACCURATE}:
            return True
    return False


def column(values):
    return cp.reshape(values, (values.size, 1), order="C")


class ConicSolver:
    """As `KernelSolver`."""

    @staticmethod
    def step(program, around, goal):
        unit = float(np.exp(np.mean(np.log(around))))
        found = best(in_units_of(program, unit), around / unit, goal_in_units_of(goal, unit))
        return None if found is None else SmoothProfile(unit * found[0].x, unit * found[0].u, found[0].free)

    @staticmethod
    def nearest(program, around):
        unit = float(np.exp(np.mean(np.log(around))))
        found = best(in_units_of(program, unit), around / unit, None)
        return found and (SmoothProfile(unit * found[0].x, unit * found[0].u, found[0].free), found[1])

    @staticmethod
    def torques(program, x, u):
        n, _, f = program.free.shape
        times = segment_times(program.step, x)[:, None]
        free, limited = cp.Variable((n, f)), np.isfinite(program.change)
        values = program.values(x, u, np.zeros((n, f))) + from_free(program, free)
        rows = within(values, program.lower, program.upper) + given_free(program, free)
        rows.append(cp.abs(values[1:, limited] - values[:-1, limited]) / (times * program.change[limited]) <= 1)
        weight = program.spacing[:, None] / np.sqrt(x)[:, None] * program.weight
        root = np.sqrt(weight / np.max(weight, initial=1e-300))
        return free.value if solved(cp.sum_squares(cp.multiply(root, values)), rows, **THIN) else None


def from_free(program, free):
    """What F adds to the rows, Shape (n, r)."""
    n, r, f = program.free.shape
    if f == 0:
        return np.zeros((n, r))
    matrix = sparse.block_diag(list(program.free), format="csr")
    return cp.reshape(matrix @ cp.reshape(free, n * f, order="C"), (n, r), order="C")


def within(values, lower, upper):
    """Rows within those of their limits that are finite."""
    return [(sign * values)[kept] <= limit[kept] for sign, limit in ((1, upper), (-1, -lower))
            if np.any(kept := np.isfinite(limit))]  # fmt: skip


def in_cones(program, z):
    """Cones over z = (u, x, 1), Shape (n, 3)."""
    rows = []
    for gram, bound in zip(program.gram.swapaxes(0, 1), program.bound.swapaxes(0, 1), strict=True):
        sizes, axes = np.linalg.eigh(gram)
        left = np.sqrt(sizes.clip(0))[:, None] * axes
        sides = [cp.sum(cp.multiply(left[:, :, side], z), axis=1) for side in range(3)]
        rows.append(cp.norm(cp.vstack(sides), axis=0) <= cp.sum(cp.multiply(bound, z), axis=1))
    return rows


def given_free(program, free):
    return [free[place] == given for place, given in zip((0, -1), program.end_free, strict=True) if given is not None]


def best(program, around, goal):
    """The best profile for a goal, and 0; for None the one that relaxes limits of rates least, and by what share."""
    n, _, f = program.free.shape
    h, speed = program.step, np.sqrt(around)
    x, u, y, times = cp.Variable(n), cp.Variable(n), cp.Variable(n), cp.Variable(n - 1)
    free, share = cp.Variable((n, f)) if f else None, cp.Variable(nonneg=True)
    above = column(speed / 2 + cp.multiply(0.5 / speed, x))  # √x by its tangent
    moved = cp.multiply(program.square, column(x)) + cp.multiply(program.rate, column(u))
    linear = moved + program.offset + from_free(program, free)

    def rooted(root):
        """root √x where it is to be small."""
        return cp.multiply(np.maximum(root, 0), above) + cp.multiply(np.minimum(root, 0), column(y))

    rows = [x[1:] - x[:-1] == cp.multiply(h, u[1:] + u[:-1]), cp.square(y) <= x]
    rows.append(times >= cp.multiply(2 * h, cp.inv_pos(y[1:] + y[:-1])))
    rows += [x[place] == given for place, given in zip((0, -1), program.ends, strict=True) if given is not None]
    rows += given_free(program, free)
    for sign, limit in ((1, program.upper), (-1, -program.lower)):
        kept = np.isfinite(limit)
        if np.any(kept):
            rows.append((sign * linear + rooted(sign * program.root))[kept] <= limit[kept])
    rows += in_cones(program, cp.hstack([column(u), column(x), np.ones((n, 1))]))
    limited = np.flatnonzero(np.isfinite(program.change))
    if limited.size:
        total = speed[:-1] + speed[1:]
        before, after = -h / (speed[:-1] * total**2), -h / (speed[1:] * total**2)
        shortest = 2 * h / total + cp.multiply(before, x[:-1] - around[:-1]) + cp.multiply(after, x[1:] - around[1:])
        allowed = column(shortest) + share * (2 * h / total)[:, None]
        for sign in (1, -1):
            up, down = (rooted(side * program.root)[:, limited] for side in (sign, -sign))
            change = sign * (linear[1:, limited] - linear[:-1, limited]) + up[1:] + down[:-1]
            rows.append(change <= cp.multiply(np.ones((n - 1, 1)) * program.change[limited], allowed))
    for end in (slice(None, -1), slice(1, None)) if len(program.jerk) else ():
        slope, third = column(u[1:] - u[:-1]), program.q3[:, 0 if end.start is None else 1]
        jerk = cp.multiply(program.q1[end] / h[:, None], slope) + cp.multiply(3 * program.q2[end], column(u[end]))
        jerk = jerk + cp.multiply(third, column(x[end]))
        least = 1.5 / speed[end] - cp.multiply(0.5 / speed[end] ** 3, x[end]) + share / speed[end]
        most = cp.multiply(np.ones((n - 1, 1)) * program.jerk, column(least))
        rows += [jerk <= most, -jerk <= most]
    cost = share if goal is None else goal.time * cp.sum(times) + goal.effort * effort(program, linear, above, y)
    if goal is not None:
        rows.append(share == 0)
        cost = cost + goal.uneven * cp.sum(cp.multiply(1 / h, cp.square(u[1:] - u[:-1])))
        if goal.longest is not None:
            rows.append(cp.sum(times) <= goal.longest)
    if not solved(cost, rows):
        return None
    found = np.zeros((n, 0)) if free is None else free.value
    return SmoothProfile(x.value, u.value, found), float(share.value)


def effort(program, linear, above, y):
    """Σ ω weight (linear + root √x)² / √x, with root² √x by its tangent."""
    by = np.sqrt(program.weight)
    squares = [cp.quad_over_lin(cp.multiply(by, linear[k]), y[k]) for k in range(len(program.square))]
    spacing = program.spacing[:, None]
    crossed = cp.sum(cp.multiply(2 * spacing * program.weight * program.root, linear))
    rest = cp.sum(cp.multiply(spacing * (program.root**2 @ program.weight)[:, None], above))
    return program.spacing @ cp.hstack(squares) + crossed + rest
