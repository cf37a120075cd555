# SPDX-License-Identifier: MIT
"""The rows of a cell along a path, from the rows of its samples."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import circle, polygons
from mrts.program.motion_rows import motor_terms
from mrts.program.rate_limits import RateLimits
from mrts.program.sample_problem import SampleProblem
from mrts.program.smooth_program import SmoothProgram

FROM_REST = 1.5
"""|σ̈| of the first two nodes of a path from rest, as a multiple of σ̇² over the length of the path in σ: a constant jerk
needs 1 there, and more only overstepped limits inside the first segment, whose ends do not show it."""

START = "constant jerk from rest"

BETWEEN_NODES = "speed between nodes"

OF_PATH = (START, BETWEEN_NODES)
"""Names of rows of the speed along the path, which stand once, behind those of the first load."""

SAME_ROW = 1e-12
"""Share by which the row of a limit may differ from that of a torque whose rate is limited: rounding."""


class _Rows:
    """Rows of one load, some of them limited in how fast they change, as they are put together for `SmoothProgram`."""

    def __init__(self, problem: SampleProblem, sizes: Array | None) -> None:
        n, r = problem.lower.shape
        self.map, self.unit = problem.A, problem.unit
        self.root = np.zeros((n, r)) if problem.speed is None else problem.speed
        self.lower, self.upper, self.offset = problem.lower.copy(), problem.upper.copy(), np.zeros((n, r))
        self.change, self.weight = np.full(r, np.inf), np.zeros(r)
        self.sizes = np.zeros((2, r)) if sizes is None else sizes
        self.names = [str(name) for name in problem.names]

    def _place_of(self, column: Array) -> int | None:
        """The row that is one torque or wrench component in its unit, told by its map, Shape (n, f + 2)."""
        size = float(np.max(np.abs(column)))
        near = np.max(np.abs(self.map[0] * self.unit[:, None] - column[0]), axis=1) <= SAME_ROW * size
        for row in np.flatnonzero(near).tolist():
            if np.max(np.abs(self.map[:, row] * self.unit[row] - column)) <= SAME_ROW * size:
                return int(row)
        return None

    def limited(self, terms: tuple[Array, Array | None, Array], place: int, size: float, name: str) -> int:
        """The row of a torque or a wrench component, with its offset; one without limits is added if there is none.

        One is added too where another offset would change how fast a row with a limited rate changes. Terms are map,
        root and offset of all torques or wrench components.
        """
        column, offset = terms[0][:, place], terms[2][:, place]
        root = np.zeros(len(column)) if terms[1] is None else terms[1][:, place]
        row = self._place_of(column)
        if row is not None and np.isfinite(self.change[row]):
            apart = offset / self.unit[row] - self.offset[:, row]
            row = row if np.ptp(apart) <= SAME_ROW * float(np.max(np.abs(apart))) else None
        if row is None:
            row = self.map.shape[1]
            self._add(column / size, np.full(len(column), np.inf), name, size, root / size)
        moved = offset / self.unit[row] - self.offset[:, row]
        self.offset[:, row] += moved
        self.lower[:, row] += moved
        self.upper[:, row] += moved
        return row

    def _add(self, column: Array, upper: Array, name: str, unit: float = 1.0, root: Array | None = None) -> None:
        """Add a row without lower limit: its map, Shape (n, f + 2), upper limit and root, Shape (n,)."""
        nothing = np.zeros(len(column))
        self.map = np.concatenate([self.map, column[:, None]], axis=1)
        self.root = np.column_stack([self.root, nothing if root is None else root])
        self.offset = np.column_stack([self.offset, nothing])
        self.lower, self.upper = np.column_stack([self.lower, nothing - np.inf]), np.column_stack([self.upper, upper])
        self.unit, self.change = np.append(self.unit, unit), np.append(self.change, np.inf)
        self.weight, self.sizes = np.append(self.weight, 0.0), np.pad(self.sizes, ((0, 0), (0, 1)))
        self.names.append(name)

    def stay_below(self, step: Array, problem: SampleProblem) -> None:
        """Add that the control points of x, a quadratic spline, keep the limits of speed: then so does all of x.

        Without it x could stand at its limit at the nodes and u jump to and fro between them at no cost.
        """
        share = problem.cap_share
        if not share.shape[1]:
            return
        middle = np.max((share[:-1] + share[1:]) / 2, axis=1)
        column, upper = np.zeros((len(share), self.map.shape[2])), np.ones(len(share))
        column[:-1, -2], column[:-1, -1], upper[-1] = middle * step, middle, np.inf
        self._add(column, upper, BETWEEN_NODES)

    def start_gently(self, sigma: Array, rests: tuple[bool, bool]) -> None:
        """Add |σ̈| <= FROM_REST σ̇² / length at the first two and the last two nodes, where the path is at rest there.

        At such an end no torque depends on σ̇: its rows leave σ̇ free, and a profile that falls within the first segment
        would gain time by a jerk that rows at nodes do not see.

        Elsewhere add σ̇² + h σ̈ >= 0 with the step h that follows. That is the middle one of the three Bernstein
        coefficients of σ̇² on a segment, its ends are the others, and a polynomial is positive where they are.
        """
        n, near = len(sigma), np.repeat(rests, 2)
        nodes = np.array([0, 1, n - 2, n - 1])[near]
        for sign in (1.0, -1.0):
            column, upper = np.zeros((n, self.map.shape[2])), np.full(n, np.inf)
            if sign < 0:
                column[:-1, -2], column[:-1, -1], upper[:-1] = -np.diff(sigma), -1.0, 0.0
            column[nodes, -2], column[nodes, -1], upper[nodes] = sign * sigma[-1] / FROM_REST, -1.0, 0.0
            self._add(column, upper, START)


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
        sizes: `counted_sizes` of the rows of a problem, Shape (2, r); None where nothing is to be kept in reserve.
    """
    parts = [_rows(cell, path, problem, rates, weights, sizes) for problem in problems]
    parts[0].start_gently(path.object.time, (ends[0] is None, ends[1] is None))
    parts[0].stay_below(np.diff(path.object.time), problems[0])
    for rows, problem in zip(parts[1:], problems[1:], strict=True):  # they bound x alone, whatever the load
        rows.lower[:, : len(problem.is_cap)][:, problem.is_cap] = -np.inf
        rows.upper[:, : len(problem.is_cap)][:, problem.is_cap] = np.inf
    frees = [rows.map.shape[2] - 2 for rows in parts]
    counts = [rows.map.shape[1] for rows in parts]
    first = np.cumsum([0, *frees])
    free = np.zeros((path.samples, sum(counts), first[-1]))
    for rows, start, place in zip(parts, first.tolist(), np.cumsum([0, *counts]).tolist(), strict=False):
        own = rows.map[:, :, :-2]
        free[:, place : place + own.shape[1], start : start + own.shape[2]] = own

    def joined(name: str) -> Array:
        return np.concatenate([getattr(rows, name) for rows in parts], axis=-1)

    lower, upper = joined("lower"), joined("upper")
    for place, held in zip((0, -1), end_free, strict=True):
        if held is not None:
            lower[place], upper[place] = -np.inf, np.inf
    limited, step = np.flatnonzero(np.isfinite(rates.jerk)), np.diff(path.object.time)
    return SmoothProgram(
        step=step,
        square=np.concatenate([rows.map[:, :, -1] for rows in parts], axis=1),
        rate=np.concatenate([rows.map[:, :, -2] for rows in parts], axis=1),
        root=joined("root"),
        offset=joined("offset"),
        free=free,
        lower=lower,
        upper=upper,
        change=joined("change"),
        weight=joined("weight"),
        sizes=joined("sizes"),
        q1=path.dq[:, limited],
        q2=path.ddq[:, limited],
        q3=(third_derivatives(step, path.dq, path.ddq) if third is None else third)[..., limited],
        jerk=rates.jerk[limited],
        names=tuple(chain.from_iterable(rows.names for rows in parts)),
        joints=tuple(np.array(cell.joint_names)[limited].tolist()),
        ends=ends,
        end_free=end_free,
    )


def without_polygons(problem: SampleProblem) -> SampleProblem:
    """A problem without the rows that are sides of polygons."""
    kept = np.flatnonzero([not name.sides for name in problem.names])
    return problem if len(kept) == len(problem.names) else problem.only(kept)


def with_circles(program: SmoothProgram, problem: SampleProblem) -> SmoothProgram:
    """A program with circles for the polygons of a problem, whose rows it lacks."""
    cones, of_polygons = [], polygons(problem.names)
    if not of_polygons:
        return program
    for name, own in of_polygons.items():
        terms = np.stack([problem.rate[:, own], problem.square[:, own]], axis=2)
        sides = [
            np.concatenate([sign * terms, -sign * limit[:, own, None]], axis=2)
            for sign, limit in ((1, problem.upper), (-1, problem.lower))
            if np.all(np.isfinite(limit[:, own]))
        ]
        cones.append(circle(np.concatenate(sides, axis=1), name.sides))
    gram, bound = (np.stack(of, axis=1) for of in zip(*cones, strict=True))
    for place, held in zip((0, -1), program.end_free, strict=True):
        if held is not None:
            bound[place, :, 2] = np.inf
    return replace(program, gram=gram, bound=bound, names=(*program.names, *map(str, of_polygons)))


def third_derivatives(step: Array, dq: Array, ddq: Array) -> Array:
    """Third derivatives at both ends of every segment of `velocity_polynomials`, Shape (n - 1, 2, m)."""
    h = step[:, None]
    rise, start, end = 6 * np.diff(dq, axis=0) / h**2, ddq[:-1] / h, ddq[1:] / h
    return np.stack([rise - 4 * start - 2 * end, -rise + 2 * start + 4 * end], axis=1)


def _rows(
    cell: Cell,
    path: CoordinatedMotion,
    problem: SampleProblem,
    rates: RateLimits,
    weights: Array | None,
    sizes: Array | None,
) -> _Rows:
    rows = _Rows(problem, sizes)
    torques = (problem.torque_map, problem.torque_speed, problem.torque_offset)
    motors = motor_terms(cell, path)
    without_dry = torques if motors is None else (*torques[:2], torques[2] - motors.dry)
    wrenches = (problem.wrench_map, None, problem.wrench_offset)
    components = [f"{robot.name}/{part}" for robot in cell.robots for part in cell.wrench_components]
    for terms, limits, names in (
        (without_dry, rates.torque, [f"{joint} torque" for joint in cell.joint_names]),
        (wrenches, rates.wrench, [f"{component} contact wrench" for component in components]),
    ):
        for place in np.flatnonzero(np.isfinite(limits)).tolist():
            row = rows.limited(terms, place, float(limits[place]), names[place])
            rows.change[row] = limits[place] / rows.unit[row]
    if weights is not None:
        _weigh(rows, torques, weights)
    return rows


def _weigh(rows: _Rows, torques: tuple[Array, Array | None, Array], weights: Array) -> None:
    """Put τᵀWτ into the weights of rows: of the torques themselves if W is diagonal, else of Lᵀτ with W = L Lᵀ."""
    if np.count_nonzero(weights - np.diag(np.diag(weights))):
        turn = np.linalg.cholesky(weights).T
        torques = (
            np.einsum("ij,njk->nik", turn, torques[0]),
            None if torques[1] is None else torques[1] @ turn.T,
            torques[2] @ turn.T,
        )
        weights = np.eye(len(turn))
    for place, weight in enumerate(np.diag(weights).tolist()):
        row = rows.limited(torques, place, 1.0, "")
        rows.weight[row] = weight * rows.unit[row] ** 2
