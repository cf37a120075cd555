# SPDX-License-Identifier: MIT
"""The highest interval of speeds that a sample admits where its rows have a term in ṙ beside one in ṙ².

Rows are A F + b x + d y within limits with x = y², y = c. Of all (F, x, y) they leave a polytope; the admissible y are
where the parabola x = y² meets its projection onto (x, y), a convex polygon. The same algorithm as in
mrts/kernel/c/speed_intervals.c, for any solver: the least and the largest y with some x >= y² bound a convex set, found
by tangents of the parabola; from the largest downward the lower hull of the polygon is followed where it may lie above
the parabola, up to the first gap.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.program.convex_program import ConvexPrograms, solve_programs
from mrts.program.linear_programs import NO_EFFECT, UNBOUNDED
from mrts.program.sample_problem import SampleProblem

ON_CURVE = 1e-12
"""How far a point may be off the parabola, relative to it; `MRTS_ON_CURVE` of speed_intervals.c."""

ROUNDING = 1e-15
"""Of x in its unit, likewise; `MRTS_ROUNDING` of numbers.h."""

EDGES = 100
"""An edge is final if nothing lies further out than this many times what is rounding."""

SEPARATED = 1e-9
"""A gap in which no row misses its limit by more than this is none; `MRTS_SEPARATED` of numbers.h."""

TANGENTS = 60
"""Most tangents for one end: two or three are usual, as the next one touches where the last edge meets the parabola."""

TURNS = 1000
"""Most chords that are looked at for the lower hull of one sample."""

LARGEST_SPEED = float(np.sqrt(UNBOUNDED))
"""In units of each sample: beyond it nothing bounds the speed."""


@dataclass
class SpeedIntervals:
    """The highest interval of admissible speeds c of each of N samples.

    Attributes:
        lower: Its least c, infinity where there is none, Shape (N,).
        upper: Its largest, infinity where nothing bounds c, minus infinity where there is none, Shape (N,).
        gap: A c in the gap between it and a lower interval, 0 where there is no other, Shape (N,).
        dual: Multipliers of the rows that set the lower and the upper end, Shape (2, N, r); of caps there are none.
        undecided: Samples that have no interval, or whose programs no solver answered, Shape (N,).
        fallbacks: Programs that the chosen solver did not solve and another did.
    """

    lower: Array
    upper: Array
    gap: Array
    dual: Array
    undecided: NDArray[np.bool_]
    fallbacks: int

    def put(self, samples: NDArray[np.int_], other: "SpeedIntervals", which: NDArray[np.int_]) -> None:
        """Take some samples from some of another batch."""
        for name in ("lower", "upper", "gap", "undecided"):
            getattr(self, name)[samples] = getattr(other, name)[which]
        self.dual[:, samples] = other.dual[:, which]


def highest_intervals(problem: SampleProblem, solver: str, most: Array | None = None) -> SpeedIntervals:
    """The highest interval of speeds c that each sample admits.

    Args:
        problem: Rows with a column of ṙ.
        solver: Name in the registry.
        most: Largest c that is asked for, Shape (N,); None for any.

    Raises:
        InputError: If there is no such solver.
        SolverError: If no solver answers.
    """
    samples, rows = problem.lower.shape
    most = np.full(samples, np.inf) if most is None else most
    if problem.unknowns == 1:
        return _in_closed_form(problem, most)
    curve = _Curve(problem, solver, most)
    found = SpeedIntervals(
        np.full(samples, np.inf), np.full(samples, -np.inf), np.zeros(samples), np.zeros((2, samples, rows)),
        np.ones(samples, dtype=bool), 0,
    )  # fmt: skip
    for sample in range(samples):
        one = _highest(curve, sample)
        if one is not None:
            found.lower[sample], found.upper[sample], found.gap[sample], dual = one
            found.dual[:, sample, ~problem.is_cap] = dual
            found.undecided[sample] = False
    found.fallbacks = curve.fallbacks
    return found


def speed_unit(problem: SampleProblem) -> Array:
    """The c² of each sample that, with its own c, moves some row by about one limit; 0 at rest, Shape (N,)."""
    assert problem.speed is not None  # noqa: S101 (asked of rows with a column of ṙ)
    moving = ~problem.is_cap & problem.is_limit
    square = np.max(np.abs(problem.square[:, moving]), axis=1, initial=0.0)
    effect = np.maximum(square, np.max(np.abs(problem.speed[:, moving]), axis=1, initial=0.0) ** 2)
    with np.errstate(divide="ignore"):
        return np.where(effect > NO_EFFECT, 1 / effect, 0.0)


class _Curve:
    """Rows over F, x and y of every sample in its unit, and linear programs over them.

    Args:
        problem: Rows with a column of ṙ.
        solver: Name in the registry.
        most: Largest c that is asked for, Shape (N,).
    """

    def __init__(self, problem: SampleProblem, solver: str, most: Array) -> None:
        assert problem.speed is not None  # noqa: S101 (as in `speed_unit`)
        self.unit, self.solver, self.fallbacks = speed_unit(problem), solver, 0
        rows = ~problem.is_cap
        square = problem.square[:, rows, None] * self.unit[:, None, None]
        speed = problem.speed[:, rows, None] * np.sqrt(self.unit)[:, None, None]
        rounded = np.max(np.abs(speed), axis=1, initial=0.0) <= ON_CURVE
        speed[rounded[:, 0]] = 0.0  # else the programs would be scaled by it
        self.A = np.concatenate([problem.free[:, rows], square, speed], axis=2)
        self.lower, self.upper = problem.lower[:, rows], problem.upper[:, rows]
        moving = self.unit > 0
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.minimum(np.sqrt(problem.cap()), most) / np.sqrt(self.unit)
        self.reach = np.where(moving, np.minimum(reach, LARGEST_SPEED), 0.0)
        self.cap = np.minimum(np.sqrt(problem.cap()), most)
        self.dual = np.zeros(len(self.lower[0]))  # of the rows, in the last answer

    def outermost(
        self, sample: int, cost: tuple[float, float], box: Array, tangent: float | None = None
    ) -> tuple[float, float, float] | None:
        """The point (x, y) with the least cost, and the multiplier of the tangent; None if there is none.

        Args:
            sample: Index.
            cost: Of x and of y.
            box: Least and largest x, then y, Shape (2, 2).
            tangent: Where a tangent of the parabola touches that x must not lie below.
        """
        unknowns = self.A.shape[2]
        g, least, most = np.zeros(unknowns), np.full(unknowns, -np.inf), np.full(unknowns, np.inf)
        g[-2:], least[-2:], most[-2:] = cost, box[:, 0], box[:, 1]
        A, lower, upper = self.A[sample], self.lower[sample], self.upper[sample]
        size = 1.0
        if tangent is not None:
            size = max(1.0, 2 * tangent)
            row = np.zeros(unknowns)
            row[-2:] = 1 / size, -2 * tangent / size
            A = np.vstack([A, row])
            lower, upper = np.append(lower, -(tangent**2) / size), np.append(upper, np.inf)
        given = (g, A, lower, upper, least, most)
        answer = solve_programs(ConvexPrograms(None, *(part[None] for part in given)), self.solver)
        self.fallbacks += answer.fallbacks
        if not answer.verified[0]:
            return None
        x, y = answer.x[0, -2:].tolist()
        self.dual = answer.row_dual[0, : self.lower.shape[1]]
        return x, y, 0.0 if tangent is None else float(max(-answer.row_dual[0, -1], 0.0)) / size


def _near(y: float) -> float:
    """What is rounding of x beside the point of the parabola at y."""
    return ON_CURVE * y * y + ROUNDING


def _highest(curve: _Curve, sample: int) -> tuple[float, float, float, Array] | None:
    """Lower end, upper end, gap and the multipliers of both ends of one sample; None if it has none or no answer."""
    reach, unit = float(curve.reach[sample]), float(np.sqrt(curve.unit[sample]))
    dual = np.zeros((2, len(curve.dual)))
    still = curve.outermost(sample, (1.0, 0.0), np.zeros((2, 2)))
    if unit == 0:
        return None if still is None else (0.0, float(curve.cap[sample]), 0.0, dual)
    high = _outer_end(curve, sample, 1.0, min(1.0, reach))
    dual[1] = curve.dual
    low = (0.0, 0.0) if still is not None else _outer_end(curve, sample, -1.0, 0.0)
    if high is None or low is None:
        return None
    dual[0] = 0.0 if still is not None else curve.dual
    found = _down_to_a_gap(curve, sample, low, max(high, low, key=lambda point: point[1]), dual)
    if found is None:
        return None
    least, most, gap = found
    unbounded = LARGEST_SPEED * (1 - EDGES * ON_CURVE)
    return least * unit, most * unit if most < unbounded else np.inf, gap * unit, dual


def _outer_end(curve: _Curve, sample: int, side: float, tangent: float) -> tuple[float, float] | None:
    """The point with the largest (side 1) or the least (side -1) y that has some x >= y²."""
    reach = float(curve.reach[sample])
    box = np.array([[0.0, reach * reach], [0.0, reach]])
    for _ in range(TANGENTS):
        found = curve.outermost(sample, (0.0, -side), box, tangent)
        if found is None:
            return None
        x, y, m = found
        if y * y - x <= _near(y):
            return x, y
        tangent = max(_next_tangent(m, tangent, side, (x, y)), 0.0)
    return None


def _next_tangent(m: float, t: float, side: float, point: tuple[float, float]) -> float:
    """Where the parabola meets the edge m x + (side - 2 t m) y <= limit through a point, or comes closest to it."""
    slope = side - 2 * t * m
    limit = m * point[0] + slope * point[1]
    square = slope * slope + 4 * m * limit
    if m <= 0:
        return point[1]
    if square <= 0:
        return -slope / (2 * m)
    root = float(np.sqrt(square))
    if side > 0:
        return 2 * limit / (slope + root) if slope >= 0 else (root - slope) / (2 * m)
    return -2 * limit / (root - slope) if slope <= 0 else -(slope + root) / (2 * m)


def _down_to_a_gap(
    curve: _Curve, sample: int, low: tuple[float, float], high: tuple[float, float], dual: Array
) -> tuple[float, float, float] | None:
    """Ends of the highest interval below a point of the polygon, and a y in the gap below it; None if there is none.

    Args:
        curve: Rows.
        sample: Index.
        low: The point with the least y.
        high: The point.
        dual: Multipliers of both ends, which change where an edge of the lower hull sets an end, Shape (2, r).
    """
    below, b, is_open, top = [low], high, False, high[1]
    for _ in range(TURNS):
        if not below:
            return (b[1], top, 0.0) if is_open else None
        a = below[-1]
        above = _above_parabola(a, b)
        if above is None:
            b, is_open = below.pop(), True
            continue
        least, most, height = above
        slope = (b[0] - a[0]) / (b[1] - a[1]) if b[1] > a[1] else 0.0
        size = high[1] ** 2
        found = curve.outermost(sample, (1.0, -slope), np.array([[-size, max(size, a[0], b[0])], [a[1], b[1]]]))
        if found is None:
            return None
        x, y, _ = found
        if x - a[0] - slope * (y - a[1]) < -EDGES * _near(b[1]):
            if y <= a[1] + ON_CURVE * b[1]:
                below[-1] = x, a[1]
            elif y >= b[1] * (1 - ON_CURVE):
                b = x, b[1]
            else:
                below.append((x, y))
            continue
        opens = _is_below(a) or least > a[1]
        is_open = is_open or _is_below(b) or most < b[1]
        if is_open and not (opens and height <= SEPARATED * (1 + b[1] ** 2)):  # else no gap can be proved
            dual[0] = curve.dual
            return most, top, (least + most) / 2 if opens or len(below) > 1 else 0.0
        if opens and not is_open:
            top, is_open, dual[1] = least, True, curve.dual
        b = below.pop()
    return None


def _is_below(point: tuple[float, float]) -> bool:
    return point[0] - point[1] ** 2 <= EDGES * _near(point[1])


def _above_parabola(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float, float] | None:
    """Where a chord lies above the parabola, and how far in units of x; None if by no more than rounding."""
    slope = (b[0] - a[0]) / (b[1] - a[1]) if b[1] > a[1] else 0.0
    start = a[0] - slope * a[1]
    top = min(max(slope / 2, a[1]), b[1])
    height = start + slope * top - top * top
    if height <= EDGES * _near(b[1]):
        return None
    root = float(np.sqrt(slope * slope + 4 * start))
    far = (slope + root) / 2 if slope >= 0 else (slope - root) / 2
    near = -start / far if far != 0 else 0.0
    return max(min(far, near), a[1]), min(max(far, near), b[1]), height


def _in_closed_form(problem: SampleProblem, most: Array) -> SpeedIntervals:
    """Every row a c² + b c <= d bounds c >= 0 by itself: to an interval, or to what is outside of one."""
    assert problem.speed is not None  # noqa: S101 (as in `speed_unit`)
    a = np.concatenate([problem.square, -problem.square], axis=1)
    b = np.concatenate([problem.speed, -problem.speed], axis=1)
    d = np.concatenate([problem.upper, -problem.lower], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        half = b / 2
        square = half * half + a * d
        q = -(half + np.where(half >= 0, 1.0, -1.0) * np.sqrt(np.maximum(square, 0.0)))  # roots q / a and -d / q
        first = np.where(a != 0, q / a, np.where(b != 0, d / b, np.nan))
        second = np.where(q != 0, -d / q, first)
        small, large = np.fmin(first, second), np.fmax(first, second)
    held, bends = np.isfinite(d), a > 0
    helps = (a < 0) & (square > 0) & held & (large > 0)
    none = held & (bends & ((square < 0) | (large < 0)) | (a == 0) & ((b > 0) & (d < 0) | (b == 0) & (d < 0)))
    ends = np.where(held & bends, large, np.where(held & (a == 0) & (b > 0), first, np.inf))
    starts = np.where(held & bends, small, np.where(held & (a == 0) & (b < 0), first, 0.0))
    starts = np.where(helps & (small < 0), large, starts)
    is_gap = helps & (small >= 0)
    lower, upper = np.max(starts, axis=1, initial=0.0), np.minimum(np.min(ends, axis=1, initial=np.inf), most)
    gap, undecided = np.zeros(problem.samples), np.any(none, axis=1)
    for sample in np.flatnonzero(np.any(is_gap, axis=1)).tolist():
        of_sample = zip(large[sample, is_gap[sample]].tolist(), small[sample, is_gap[sample]].tolist(), strict=True)
        for end, begin in sorted(of_sample, reverse=True):
            if end <= lower[sample]:
                break
            if end > upper[sample]:
                upper[sample] = min(upper[sample], begin)
            else:
                gap[sample] = (begin + end) / 2 if begin >= lower[sample] else 0.0
                lower[sample] = end
    undecided |= lower > upper
    lower[undecided], upper[undecided], gap[undecided] = np.inf, -np.inf, 0.0
    return SpeedIntervals(lower, upper, gap, np.zeros((2, *problem.lower.shape)), undecided, 0)
