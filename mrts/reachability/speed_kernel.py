# SPDX-License-Identifier: MIT
"""What retiming asks of our kernel, and the same with CasADi and numpy where there is no C compiler."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import CompilerError
from mrts.kernel.programs import CORNERS, INFEASIBLE, OPTIMAL, HalfPlanes, default_programs
from mrts.solvers.convex_program import ConvexPrograms, solve_programs

SOLVER = "qpsol:qpoases"
"""Of the linear programs where there is no kernel."""

OUTSIDE = 1e-9
"""An edge is final if nothing lies further out than this; `MRTS_OUTSIDE` of reachability/corners.h."""

ON_LIMIT = 2e-10
"""Rounding of a speed on a limit; `MRTS_ON_LIMIT` of batch.c."""

AXES = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""Directions of the first corners."""


class SpeedKernel(Protocol):
    """Projections and reachability, in C or here; see `mrts.kernel.programs.Programs` for the shapes."""

    def projections(
        self,
        A: Array,
        lower: Array,
        upper: Array,
        scale: Array,
        bounds: tuple[Array, Array],
        rows: NDArray[np.int32] | None = None,
    ) -> tuple[NDArray[np.int32], Array, NDArray[np.uint8]]:
        """Project every polytope of a batch onto its last two unknowns."""

    def half_planes(
        self, number: NDArray[np.int32], corners: Array, unit: Array, cap: Array, box: float, near: float
    ) -> HalfPlanes:
        """The half-planes of polygons over u and x."""

    def effects(self, A: Array, rows: NDArray[np.int32]) -> Array:
        """The largest coefficient of each unknown in some rows, without its sign."""

    def backward(
        self, step: Array, rise: Array, start: NDArray[np.int64], planes: Array, lower: Array, upper: Array
    ) -> int:
        """Shrink bounds of x to the controllable sets."""

    def forward(
        self,
        step: Array,
        rise: Array,
        start: NDArray[np.int64],
        planes: Array,
        lower: Array,
        upper: Array,
        first: float,
    ) -> Array:
        """The largest controllable x at every sample."""


def speed_kernel() -> SpeedKernel:
    """Our kernel; without a C compiler that works, the same answers more slowly."""
    try:
        return default_programs()
    except CompilerError:
        return KernelWithoutCompiler()


class KernelWithoutCompiler:
    """The projections and passes of mrts/kernel/c, with a solver that needs no compiler."""

    @staticmethod
    def projections(
        A: Array,
        lower: Array,
        upper: Array,
        scale: Array,
        bounds: tuple[Array, Array],
        rows: NDArray[np.int32] | None = None,
    ) -> tuple[NDArray[np.int32], Array, NDArray[np.uint8]]:
        """Corners by linear programs: outward of every edge, until nothing lies outside."""
        taken = slice(None) if rows is None else rows
        free = np.full((len(A), A.shape[2] - 2), np.inf)
        ends = np.concatenate([-free, bounds[0]], axis=1), np.concatenate([free, bounds[1]], axis=1)
        parts = (A[:, taken] * scale[:, None, :], lower[:, taken], upper[:, taken], *ends)
        everyone = np.arange(len(A))
        polygons: list[list[Array]] = [[] for _ in A]
        status = np.full(len(A), OPTIMAL, dtype=np.uint8)
        for direction in AXES:
            corners, found = _furthest(parts, everyone, np.tile(direction, (len(A), 1)))
            status[~found] = INFEASIBLE
            for polygon, corner in zip(polygons, corners, strict=True):
                if not any(_same(corner, other) for other in polygon):
                    polygon.append(corner)
        final: list[set[tuple[float, ...]]] = [set() for _ in A]
        while True:
            samples, starts = _open_edges(polygons, final, status)
            if samples.size == 0:
                break
            places = zip(samples, starts, strict=True)
            edges = [(polygons[k][i], polygons[k][(i + 1) % len(polygons[k])]) for k, i in places]
            normals = np.array([[q[1] - p[1], p[0] - q[0]] for p, q in edges])
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            corners, found = _furthest(parts, samples, normals)
            status[samples[~found]] = INFEASIBLE
            for place in range(len(samples))[::-1]:  # from the last edge of a polygon, so that places stay true
                (p, q), corner = edges[place], corners[place]
                further = float(normals[place] @ (corner - p)) > OUTSIDE * (1 + np.sum(np.abs(p)))
                if further and not _same(corner, p) and not _same(corner, q):
                    polygons[samples[place]].insert(int(starts[place]) + 1, corner)
                else:
                    final[samples[place]].add((*p, *q))
        polygons = [_turning(polygon)[:CORNERS] if how == OPTIMAL else []
                    for polygon, how in zip(polygons, status, strict=True)]  # fmt: skip
        corners = np.array([corner for polygon in polygons for corner in polygon]).reshape(-1, 2)
        return np.array([len(polygon) for polygon in polygons], dtype=np.int32), corners, status

    @staticmethod
    def half_planes(
        number: NDArray[np.int32], corners: Array, unit: Array, cap: Array, box: float, near: float
    ) -> HalfPlanes:
        """Of one polygon after the other."""
        ends = np.cumsum(number).tolist()
        polygons = [corners[end - size : end] for end, size in zip(ends, number.tolist(), strict=True)]
        given = zip(polygons, unit, cap.tolist(), strict=True)
        found = [_edges(polygon, size, (box, most), near) for polygon, size, most in given]
        low, high = (np.array([of(p[:, 1]) if len(p) else 0.0 for p in polygons]) for of in (np.min, np.max))
        return HalfPlanes(np.cumsum([0, *map(len, found)], dtype=np.int64), np.concatenate(found), low, high)

    @staticmethod
    def effects(A: Array, rows: NDArray[np.int32]) -> Array:
        """Of all samples at once."""
        return np.asarray(np.max(np.abs(A[:, rows]), axis=1, initial=0.0))

    @staticmethod
    def backward(step: Array, rise: Array, start: NDArray[np.int64], planes: Array, lower: Array, upper: Array) -> int:
        """Controllable sets, one segment after the other."""
        for i in range(len(step) - 1, -1, -1):
            A, limit = _segment(step, rise, start, planes, lower, upper, i)
            flat = A[:, 0] == 0
            with np.errstate(divide="ignore", invalid="ignore"):
                bound = limit / A[:, 1]
            upper[i] = np.min(bound[flat & (A[:, 1] > 0)], initial=upper[i])
            lower[i] = np.max(bound[flat & (A[:, 1] < 0)], initial=lower[i])
            least, most = _nearest(A, limit, lower[i], upper[i]), _nearest(A, limit, upper[i], lower[i])
            if lower[i] > upper[i] or least is None or most is None:
                return i
            lower[i], upper[i] = least, max(least, most)
        return -1

    @staticmethod
    def forward(
        step: Array, rise: Array, start: NDArray[np.int64], planes: Array, lower: Array, upper: Array, first: float
    ) -> Array:
        """The greedy pass."""
        x = np.zeros(len(step) + 1)
        x[0] = first
        for i in range(len(step)):
            u = _rates(*_segment(step, rise, start, planes, lower, upper, i), x[i])
            rate = u.most if u.most >= u.least else (u.most + u.least) / 2
            x[i + 1] = min(max(x[i] + 2 * step[i] * rate, lower[i + 1]), upper[i + 1])
        return x


def _edges(polygon: Array, unit: Array, bounds: tuple[float, float], near: float) -> Array:
    """Half-planes of the edges of a polygon that are not those of bounds of |u| and x, Shape (e, 3)."""
    after = np.roll(polygon, -1, axis=0)
    (u, x), (along_u, along_x) = polygon.T, (after - polygon).T
    length = np.sqrt(along_u * along_u + along_x * along_x)  # as the kernel: of what underflows nothing is left
    on_box = np.minimum(np.abs(u), np.abs(after[:, 0])) >= near * bounds[0]
    on_bound = (np.minimum(x, after[:, 1]) >= near * bounds[1]) | (np.maximum(x, after[:, 1]) <= 1 / bounds[0] ** 2)
    edge = (length > 0) & ~on_box & ~on_bound
    normal = np.column_stack([along_x, -along_u])[edge] / length[edge, None]
    planes = np.column_stack([normal / unit, np.sum(normal * polygon[edge], axis=1)])
    if len(polygon) not in {1, 2} or np.isinf(unit[0]):
        return planes
    across = [[1 / unit[0], 0.0, np.max(u)], [-1 / unit[0], 0.0, -np.min(u)]]  # a point or a segment along itself
    return np.concatenate([planes, across])


def _furthest(
    parts: tuple[Array, ...], samples: NDArray[np.int_], directions: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """The corners of some polytopes furthest in a direction of the last two unknowns, and where there is one."""
    g = np.zeros((len(samples), parts[0].shape[2]))
    g[:, -2:] = -directions
    answers = solve_programs(ConvexPrograms(None, g, *(part[samples] for part in parts)), SOLVER)
    return answers.x[:, -2:], answers.verified


def _open_edges(
    polygons: list[list[Array]], final: list[set[tuple[float, ...]]], status: NDArray[np.uint8]
) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Edges outside which something may lie, as samples and places of their first corners, in order."""
    found = [
        (sample, place)
        for sample, polygon in enumerate(polygons)
        if status[sample] == OPTIMAL and 1 < len(polygon) < CORNERS
        for place, corner in enumerate(polygon)
        if (*corner, *polygon[(place + 1) % len(polygon)]) not in final[sample]
    ]
    samples, places = np.array(found, dtype=int).reshape(-1, 2).T
    return samples, places


def _turning(polygon: list[Array]) -> list[Array]:
    """A polygon without the points between their neighbours on a line: of a segment the ends are left."""
    kept, place = list(polygon), 0
    while len(kept) > 2 and place < len(kept):  # noqa: PLR2004 (a segment)
        here = kept[place]
        before, after = here - kept[place - 1], kept[(place + 1) % len(kept)] - here
        across, along = before[0] * after[1] - before[1] * after[0], float(before @ after)
        if abs(across) <= OUTSIDE * along:
            del kept[place]
        else:
            place += 1
    return kept


def _same(p: Array, q: Array) -> bool:
    return bool(np.sum(np.abs(p - q)) <= OUTSIDE * (1 + np.sum(np.abs(p))))


def _segment(
    step: Array, rise: Array, start: NDArray[np.int64], planes: Array, lower: Array, upper: Array, i: int
) -> tuple[Array, Array]:
    """Half-planes A (u, x_i) <= limit of a segment: of its start, of its end, and of what its end is to reach."""
    here, there = planes[start[i] : start[i + 1]], planes[start[i + 1] : start[i + 2]]
    ends = np.array([[-2 * step[i], -1.0], [2 * step[i], 1.0]])
    moved = np.column_stack([there[:, 0] + 2 * step[i] * there[:, 1], there[:, 1]])
    limits = np.concatenate([here[:, 2], there[:, 2]])
    risen = rise[i] / 2 * np.concatenate([here[:, 0], -there[:, 0]])
    limit = np.concatenate([limits + ON_LIMIT * (1 + np.abs(limits)) + risen, [-lower[i + 1], upper[i + 1]]])
    return np.concatenate([here[:, :2], moved, ends]), limit


@dataclass(frozen=True)
class _Rates:
    """The interval of u at one x; its ends are on the lines start + slope x."""

    least: float
    most: float
    least_line: tuple[float, float]
    most_line: tuple[float, float]


def _rates(A: Array, limit: Array, x: float) -> _Rates:
    """The interval of u that half-planes leave at one x."""
    with np.errstate(divide="ignore", invalid="ignore"):
        start, slope = limit / A[:, 0], -A[:, 1] / A[:, 0]
        value = (limit - A[:, 1] * x) / A[:, 0]
    above, below = np.where(A[:, 0] > 0, value, np.inf), np.where(A[:, 0] < 0, value, -np.inf)
    most, least = int(np.argmin(above)), int(np.argmax(below))
    lines = np.column_stack([start, slope])[[least, most]].tolist()
    return _Rates(float(below[least]), float(above[most]), tuple(lines[0]), tuple(lines[1]))


def _nearest(A: Array, limit: Array, start: float, to: float) -> float | None:
    """The x nearest to `start` on the way to `to` that leaves some u, by Newton's method; None if there is none."""
    inward = 1 if to >= start else -1
    x = start
    for _ in range(len(A) + 1):
        u = _rates(A, limit, x)
        slope = u.most_line[1] - u.least_line[1]
        if u.most >= u.least:
            return x
        if slope * inward <= 0:
            return None
        # where the two lines meet, from their coefficients: `start` may be many orders of magnitude away
        ahead = (u.least_line[0] - u.most_line[0]) / slope
        if ahead == x:
            return x
        if x == to:
            return None
        x = to if (ahead - to) * inward > 0 else ahead
    return x
