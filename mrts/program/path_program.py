# SPDX-License-Identifier: MIT
"""The rows of a cell along a path, from the rows of its samples."""

from collections.abc import Sequence
from itertools import chain

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import circle, joint_rows, polygons, wrench_rows
from mrts.program.motion_rows import motor_terms
from mrts.program.rate_limits import RateLimits
from mrts.program.sample_problem import SampleProblem
from mrts.program.smooth_program import SmoothProgram

FROM_REST = 1.5
"""|σ̈| of the first two nodes of a path from rest, as a multiple of σ̇² over the length of the path in σ: a constant jerk
needs 1 there, and more only overstepped limits inside the first segment, whose ends do not show it."""

START = "constant jerk from rest"

BETWEEN_NODES = "speed between nodes"

SAME_ROW = 1e-12
"""Share by which the row of a limit may differ from that of a torque whose rate is limited: rounding."""


def path_program(
    cell: Cell,
    path: CoordinatedMotion,
    problems: Sequence[SampleProblem],
    rates: RateLimits,
    weights: Array | None = None,
    ends: tuple[float | None, float | None] = (None, None),
    end_free: tuple[Array | None, Array | None] = (None, None),
    third: Array | None = None,
    sizes: Array | None = None,
) -> SmoothProgram:
    """One program over all nodes of a path, for all loads at once: x and u in common, wrenches for each.

    Rates are those of torques without dry friction, which steps where a joint turns back or leaves rest: no timing
    changes that, and as a change from node to node it would allow the less speed the more nodes there are.

    Args:
        cell: The cell.
        path: q, q', q'' at n nodes, with σ for time.
        problems: Rows of [F, u, x] at the nodes, one a load.
        rates: Limits of torque rates, wrench rates and jerk.
        weights: W of the effort, Shape (m, m); None where no effort is asked for.
        ends: x at the first and the last node where it is given.
        end_free: [F] of all loads there, likewise. There the cell is at rest, so that rows have one value: whether it
            keeps its limits is the caller's question.
        third: q''' at both ends of every segment, Shape (n - 1, 2, m); None takes it from q' and q'' at the nodes.
        sizes: `counted_sizes` of the rows of a problem that are no sides of polygons, Shape (2, r); None where nothing
            is to be kept in reserve.
    """
    gram, bound, circles = _circles(problems[0])  # they are the same for all loads
    problems = [without_polygons(problem) for problem in problems]
    parts = [_load_rows(cell, path, problem, rates, weights, sizes) for problem in problems]
    for (rows, _), problem in zip(parts[1:], problems[1:], strict=True):  # they bound x alone, whatever the load
        caps = np.flatnonzero(problem.is_cap)
        rows["lower"][:, caps], rows["upper"][:, caps] = -np.inf, np.inf
    parts.append(_path_rows(path.object.time, problems[0], (ends[0] is None, ends[1] is None)))
    unknowns, start = sum(rows["free"].shape[2] for rows, _ in parts), 0
    for rows, _ in parts:
        end = start + rows["free"].shape[2]
        rows["free"], start = np.pad(rows["free"], ((0, 0), (0, 0), (start, unknowns - end))), end
    joined = {name: np.concatenate([rows[name] for rows, _ in parts], axis=1) for name in parts[0][0]}
    for place, held in zip((0, -1), end_free, strict=True):
        if held is not None:
            joined["lower"][place], joined["upper"][place], bound[place, :, 2] = -np.inf, np.inf, np.inf
    limited, step = np.flatnonzero(np.isfinite(rates.jerk)), np.diff(path.object.time)
    return SmoothProgram(
        step=step,
        **joined | {name: joined[name][0] for name in ("change", "weight")},
        q1=path.dq[:, limited],
        q2=path.ddq[:, limited],
        q3=(third_derivatives(step, path.dq, path.ddq) if third is None else third)[..., limited],
        jerk=rates.jerk[limited],
        gram=gram,
        bound=bound,
        names=(*chain.from_iterable(names for _, names in parts), *circles),
        joints=tuple(np.array(cell.joint_names)[limited].tolist()),
        ends=ends,
        end_free=end_free,
    )


def without_polygons(problem: SampleProblem) -> SampleProblem:
    """A problem without the rows that are sides of polygons."""
    kept = np.flatnonzero([not name.sides for name in problem.names])
    return problem if len(kept) == len(problem.names) else problem.only(kept)


def _circles(problem: SampleProblem) -> tuple[Array, Array, list[str]]:
    """The cones of the polygons of a problem, as attributes of `SmoothProgram`, and their names."""
    of_polygons, n = polygons(problem.names), problem.samples
    gram, bound = np.zeros((n, len(of_polygons), 3, 3)), np.zeros((n, len(of_polygons), 3))
    for place, (name, own) in enumerate(of_polygons.items()):
        terms = np.stack([problem.rate[:, own], problem.square[:, own]], axis=2)
        sides = [
            np.concatenate([sign * terms, -sign * limit[:, own, None]], axis=2)
            for sign, limit in ((1, problem.upper), (-1, problem.lower))
            if np.all(np.isfinite(limit[:, own]))
        ]
        gram[:, place], bound[:, place] = circle(np.concatenate(sides, axis=1), name.sides)
    return gram, bound, [str(name) for name in of_polygons]


def third_derivatives(step: Array, dq: Array, ddq: Array) -> Array:
    """Third derivatives at both ends of every segment of `velocity_polynomials`, Shape (n - 1, 2, m)."""
    h = step[:, None]
    rise, start, end = 6 * np.diff(dq, axis=0) / h**2, ddq[:-1] / h, ddq[1:] / h
    return np.stack([rise - 4 * start - 2 * end, -rise + 2 * start + 4 * end], axis=1)


def _load_rows(
    cell: Cell,
    path: CoordinatedMotion,
    problem: SampleProblem,
    rates: RateLimits,
    weights: Array | None,
    sizes: Array | None,
) -> tuple[dict[str, Array], list[str]]:
    """Rows of one load as attributes of `SmoothProgram`, with limits of rates and weights of squares, and their names.

    A torque or wrench component whose rate or square counts is the row of its own limits, moved by its offset. Where it
    has none, and where another offset would change how fast a row with a limited rate changes, it is one row more.
    """
    names, r, m = [str(name) for name in problem.names], len(problem.unit), len(rates.torque)
    at_end = (0, 2 * m + len(rates.wrench))  # room for what is no row yet
    A, unit = np.pad(problem.A, ((0, 0), at_end, (0, 0))), np.pad(problem.unit, at_end, constant_values=1.0)
    lower = np.pad(problem.lower, ((0, 0), at_end), constant_values=-np.inf)
    upper = np.pad(problem.upper, ((0, 0), at_end), constant_values=np.inf)
    root, offset = np.zeros((2, *lower.shape))
    root[:, :r] = 0.0 if problem.speed is None else problem.speed
    change, weight = np.full(len(unit), np.inf), np.zeros(len(unit))

    def counts(
        name: str, column: Array, own_root: Array, own: Array, most: float = np.inf, square: float = 0.0
    ) -> None:
        row = names.index(name) if name in names else 0
        moved = own / unit[row] - offset[:, row]
        alike = np.max(np.abs(A[:, row] * unit[row] - column)) <= SAME_ROW * np.max(np.abs(column))
        steady = np.isinf(change[row]) or np.ptp(moved) <= SAME_ROW * np.max(np.abs(moved))
        if name not in names or not alike or not steady:
            row = len(names)
            names.append(name)
            unit[row] = most if np.isfinite(most) else 1.0
            A[:, row], root[:, row], moved = column / unit[row], own_root / unit[row], own / unit[row]
        for of in (lower, upper, offset):
            of[:, row] += moved
        change[row] = min(change[row], most / unit[row])
        weight[row] += square * unit[row] ** 2

    torque, torque_offset, nothing = problem.torque_map, problem.torque_offset, np.zeros(path.samples)
    torque_root = np.zeros_like(torque_offset) if problem.torque_speed is None else problem.torque_speed
    joints, components = joint_rows(cell, "torque", "torque_units"), wrench_rows(cell, "wrench")
    motors = motor_terms(cell, path)
    without_dry = torque_offset if motors is None else torque_offset - motors.dry
    for j in np.flatnonzero(np.isfinite(rates.torque)):
        counts(str(joints[j]), torque[:, j], torque_root[:, j], without_dry[:, j], rates.torque[j])
    for j in np.flatnonzero(np.isfinite(rates.wrench)):
        counts(str(components[j]), problem.wrench_map[:, j], nothing, problem.wrench_offset[:, j], rates.wrench[j])
    if weights is not None:  # τᵀWτ, of the torques themselves if W is diagonal, else of Lᵀτ with W = L Lᵀ
        diagonal = np.diag(weights)
        if np.count_nonzero(weights - np.diag(diagonal)):
            turn, diagonal, joints = np.linalg.cholesky(weights).T, np.ones(m), ()
            torque, torque_root, torque_offset = turn @ torque, torque_root @ turn.T, torque_offset @ turn.T
        for place, square in enumerate(diagonal):
            name = str(joints[place]) if joints else ""
            counts(name, torque[:, place], torque_root[:, place], torque_offset[:, place], square=square)
    rows = {"square": A[:, :, -1], "rate": A[:, :, -2], "free": A[:, :, :-2], "root": root, "offset": offset}
    rows |= {"lower": lower, "upper": upper, "change": change[None], "weight": weight[None]}
    rows["sizes"] = np.pad(np.zeros((2, r)) if sizes is None else sizes, ((0, 0), at_end))
    return {name: of[:, : len(names)] for name, of in rows.items()}, names


def _path_rows(sigma: Array, problem: SampleProblem, rests: tuple[bool, bool]) -> tuple[dict[str, Array], list[str]]:
    """Rows of the speed along the path alone, as `_load_rows`.

    At rest |σ̈| <= FROM_REST σ̇² / length at the first two and the last two nodes: at such an end no torque depends on
    σ̇: its rows leave σ̇ free, and a profile that falls within the first segment would gain time by a jerk that rows at
    nodes do not see. Elsewhere σ̇² + h σ̈ >= 0 with the step h that follows. That is the middle one of the three
    Bernstein coefficients of σ̇² on a segment, its ends are the others, and a polynomial is positive where they are.

    The control points of x, a quadratic spline, keep the limits of speed: then so does all of x. Without it x could
    stand at its limit at the nodes and u jump to and fro between them at no cost.
    """
    n, step, share = len(sigma), np.diff(sigma), problem.cap_share
    rate, square, nothing, upper = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3)), np.full((n, 3), np.inf)
    rate[:-1, 1], square[:-1, 1], upper[:-1, 1] = -step, -1.0, 0.0
    nodes = np.array([0, 1, n - 2, n - 1])[np.repeat(rests, 2)]
    rate[nodes, :2] = np.array([1.0, -1.0]) * sigma[-1] / FROM_REST
    square[nodes, :2], upper[nodes, :2] = -1.0, 0.0
    if share.shape[1]:
        square[:-1, 2] = np.max((share[:-1] + share[1:]) / 2, axis=1)
        rate[:-1, 2], upper[:-1, 2] = square[:-1, 2] * step, 1.0
    rows = {"square": square, "rate": rate, "free": np.zeros((n, 3, 0)), "root": nothing, "offset": nothing}
    rows |= {"lower": np.full((n, 3), -np.inf), "upper": upper, "change": np.full((1, 3), np.inf)}
    return rows | {"weight": np.zeros((1, 3)), "sizes": np.zeros((2, 3))}, [START, START, BETWEEN_NODES]
