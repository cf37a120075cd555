# SPDX-License-Identifier: MIT
"""How far limits are from holding together: the least widening, and a verified Farkas certificate of what conflicts."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.load_box import LoadPoint
from mrts.kernel.programs import OPTIMAL, STOPPED
from mrts.limits.rows import ActiveRow, rows_text
from mrts.program.motion_rows import MotionRows
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.solvers import DEFAULT_SOLVER, ConvexPrograms, require_verified, solve_programs

CERTIFICATE_TOLERANCE = 1e-9
"""A certificate must separate the limits by more than this share of their size, or nothing is proved."""

NEGLIGIBLE_MULTIPLIER = 1e-9
"""Multipliers below this share of the largest are rounding: a vertex leaves exact zeros."""

COMBINATION_TOLERANCE = 1e-8
"""Largest error of yᵀA = 0, relative to its terms: what rounding and the dropped multipliers leave."""


@dataclass(frozen=True)
class Conflict:
    """Limits that cannot hold together at one sample, whatever c² >= 0.

    With the multipliers y of these rows, Σ yᵢ (row i) is a combination of limits that no torque satisfies
    (Farkas' lemma); `separation` checks it by substitution.

    Attributes:
        sample: Index of the sample.
        time: [s].
        rows: The conflicting rows and sides.
        multipliers: y of these rows, per N or N m; positive at an upper limit.
        widening: All limits must move outward by at least this share of their larger side to make the sample feasible.
        moves: The same for each of these rows in its own unit.
        load: The load that cannot be carried, if the load is uncertain.
        c2: Where the speed has a term beside its square and the rows conflict at each speed for other reasons: the c²
            that comes closest, at which these rows conflict; None where they conflict whatever c² is.
    """

    sample: int
    time: float
    rows: tuple[ActiveRow, ...]
    multipliers: tuple[float, ...]
    widening: float
    moves: tuple[float, ...]
    load: LoadPoint | None = None
    c2: float | None = None

    @property
    def with_load(self) -> str:
        """The load in words, after a blank; empty if it is known."""
        return "" if self.load is None else f" with {self.load}"

    def to_json(self) -> dict[str, Any]:
        """Entry of "conflicts" in the JSON result."""
        return {
            "sample": self.sample,
            "time": self.time,
            "c2": self.c2,
            "load": self.load.to_json() if self.load else None,
            "rows": [row.to_json() for row in self.rows],
            "multipliers": list(self.multipliers),
            "widening": self.widening,
            "moves": list(self.moves),
        }

    def __str__(self) -> str:
        of_load = any(row.name.of_load for row in self.rows)
        carried = f"no torques carry the object{self.with_load} at any speed"
        none = carried if of_load else "limits of the motion alone admit no speed"
        nearest = "" if self.c2 is None else f"even at c² = {self.c2:.4g}, which comes closest, "
        moves = ", ".join(
            f"{row.name.short} by {move:.3g} {row.name.unit}".rstrip()
            for row, move in zip(self.rows, self.moves, strict=True)
        )
        return (
            f"at t = {self.time:.4g} s (sample {self.sample}) {none}: {nearest}these limits conflict: "
            f"{rows_text(self.rows, '; ')}. It takes moving all limits outward by {100 * self.widening:.3g} % of their "
            f"size ({moves})"
        )


def linear_conflicts(problem: SampleProblem, time: Array) -> list[Conflict | None]:
    """What conflicts at N samples with times of Shape (N,), without terms in ṙ; None where the limits hold together.

    The elastic program min s, lower - s <= A x <= upper + s (in rows of limits) always has a solution; s > 0 exactly
    where the sample is infeasible, and its multipliers are the Farkas certificate.
    """
    limits, unit = (problem.A, problem.lower, problem.upper, problem.is_limit), problem.unit
    widening, dual = least_widening(*limits, solver=problem.solver, least_last=0.0)
    conflicts: list[Conflict | None] = []
    for sample in range(problem.samples):
        sides = _certified(problem, sample, dual[:, sample])
        if not sides:
            conflicts.append(None)
            continue
        conflicts.append(
            Conflict(
                sample,
                float(time[sample]),
                tuple(problem.active_row(row, upper=multiplier > 0) for row, multiplier in sides),
                tuple(float(multiplier / unit[row]) for row, multiplier in sides),
                float(widening[sample]),
                tuple(float(widening[sample] * unit[row]) for row, _ in sides),
            )
        )
    return conflicts


def conflicts_at(problem: SampleProblem, c2: Array, time: Array) -> list[Conflict | None]:
    """`linear_conflicts` at a chosen c² of each sample, where everything is linear."""
    lower, upper = problem.limits_at(c2[:, None])
    A = np.concatenate([problem.free, np.zeros((*problem.square.shape, 1))], axis=2)
    return linear_conflicts(replace(problem, A=A, lower=lower, upper=upper, speed=None), time)


def separation(problem: SampleProblem, index: int, y: Array) -> tuple[float, float]:
    """Check a Farkas certificate, multipliers y of a sample's rows, Shape (r,) or (2, r), by substitution.

    For every x with c² >= 0 the rows give yᵀA x <= Σ_{y>0} y upper + Σ_{y<0} y lower. If yᵀA is zero on the free
    unknowns and >= 0 on c², the left side is >= 0; a negative right side then proves infeasibility. A row has two
    where its own sides cross, as a reserve, or friction in both directions, leaves less than nothing between them.

    Returns:
        The right side, relative to Σ |y|, and the largest error of the left side, each column relative to Σ |y|
        times its largest coefficient.
    """
    terms = np.sum(np.abs(y)) * np.max(np.abs(problem.A[index]), axis=0)
    combined = (np.atleast_2d(y).sum(axis=0) @ problem.A[index]) / np.where(terms > 0, terms, 1.0)
    error = max(float(np.max(np.abs(combined[:-1]), initial=0.0)), 0.0, -float(combined[-1]))
    limit = np.where(y > 0, problem.upper[index], np.where(y < 0, problem.lower[index], 0.0))
    size = float(np.sum(np.abs(y) * problem.is_limit))
    return float(np.sum(y * limit)) / (size or 1.0), error


def _certified(problem: SampleProblem, index: int, y: Array) -> list[tuple[int, float]]:
    """Rows with multipliers, Shape (2, r), without rounding, if they prove infeasibility; nothing if they do not."""
    weight = np.abs(y) * np.maximum(np.max(np.abs(problem.A[index]), axis=1), problem.is_limit)
    y = np.where(weight > NEGLIGIBLE_MULTIPLIER * np.max(weight, initial=0.0), y, 0.0)
    value, error = separation(problem, index, y)
    if not (value < -CERTIFICATE_TOLERANCE and error <= COMBINATION_TOLERANCE):
        return []
    return [(row, float(y[side, row])) for row, side in np.argwhere(y.T).tolist()]


def least_widening(
    A: Array,
    lower: Array,
    upper: Array,
    sizes: NDArray[Any] | float = 1.0,
    *,
    solver: str = DEFAULT_SOLVER,
    least: float = 0.0,
    least_last: float = -np.inf,
) -> tuple[Array, Array]:
    """Solve min s, lower - s l <= A x <= upper + s u for limits, lower <= A x <= upper for laws; it has a solution.

    A has Shape (N, r, k), its limits (N, r). `sizes` are l and u, one for all or as Shape (2, r): 0 of laws. The last
    unknown is at least `least_last`, and s at least `least`: below 0 limits move inward.

    Returns:
        Least s, Shape (N,), and multipliers of the rows at their lower and upper limits, Shape (2, N, r); below 0 at
        lower ones.

    Raises:
        SolverError: If no solver answers.
    """
    count, rows, unknowns = A.shape
    below, above = np.broadcast_to(np.asarray(sizes, dtype=np.float64), (2, rows))
    limits, laws = np.flatnonzero(below > 0), np.flatnonzero(below <= 0)
    # each limit twice, its upper and its lower side, as s moves them in opposite senses; laws once, as they are
    order, sides = np.concatenate([limits, limits, laws]), [len(limits), 2 * len(limits)]
    at_upper, at_lower = slice(sides[0]), slice(*sides)
    A, g, free = np.pad(A[:, order], ((0, 0), (0, 0), (0, 1))), *np.zeros((2, count, unknowns + 1))
    A[:, at_upper, -1], A[:, at_lower, -1], g[:, -1], free[:] = -above[limits], below[limits], 1.0, np.inf
    lower, upper = np.hstack([lower[:, order], -free]), np.hstack([upper[:, order], free])
    lower[:, at_upper], upper[:, at_lower] = -np.inf, np.inf
    of_unknowns = lower[:, len(order) :]
    of_unknowns[:, unknowns - 1 : unknowns], of_unknowns[:, -1] = least_last, least
    programs = ConvexPrograms(H=None, g=g, A=A, lower=lower, upper=upper)
    answers = solve_programs(programs, solver)
    require_verified(answers)
    of_upper, of_lower, of_laws = np.split(answers.dual[:, : len(order)], sides, axis=1)
    dual = np.zeros((2, count, rows))
    dual[:, :, limits] = of_lower, of_upper
    dual[:, :, laws] = np.minimum(of_laws, 0), np.maximum(of_laws, 0)
    return answers.x[:, -1], dual


def widening_at(problem: SampleProblem, c2: float | Array) -> Array:
    """Least s that admits a c², one for all samples or Shape (N, 1), Shape (N,); of one unknown, the largest excess."""
    lower, upper = problem.limits_at(c2)
    if problem.unknowns == 1:
        return np.asarray(np.max(np.maximum(lower, -upper), axis=1, initial=0.0), dtype=np.float64)
    return least_widening(problem.free, lower, upper, problem.is_limit, solver=problem.solver)[0]


def motion_widening(
    rows: MotionRows, c2: Array, load: Array | None = None, samples: NDArray[np.intp] | None = None
) -> Array:
    """By how much all limits must move outward before a motion keeps them, in shares of each: Shape (k,).

    c² is that of each of k samples, Shape (k,), all or some; a load is one for all, Shape (10,), or Shape (k, 10).
    """
    places = np.arange(rows.motion.samples) if samples is None else samples
    if not len(places):
        return np.zeros(0)
    share, left = np.zeros(len(places)), np.arange(len(places))
    if rows.compiled:
        speed = np.sqrt(c2[:, None]) if rows.has_speed_terms else 1.0
        status, units = np.full(len(places), STOPPED, dtype=np.uint8), rows.given.limits.units[~rows.is_cap]
        outputs = share, status
        rows.over_samples("mrts_widenings", [c2], outputs, (units,), load=load, speed=speed, samples=samples)
        share, left = np.maximum(share, rows.passed_caps(c2, places)), (status != OPTIMAL).nonzero()[0]
    if left.size:
        carried = load if load is None or load.ndim == 1 else load[left]
        problem = build_sample_problem(rows, load=carried, samples=places[left])
        share[left] = widening_at(problem, c2[left, None])
    return share
