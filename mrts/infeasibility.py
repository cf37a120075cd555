# SPDX-License-Identifier: MIT
"""Why a sample is infeasible: a verified Farkas certificate and the limits that it names."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.convex_program import ConvexPrograms, require_verified, solve_programs
from mrts.limit_rows import ActiveRow
from mrts.rigid_transform import Array
from mrts.sample_problem import SampleProblem

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
    (Farkas' lemma); `verified_conflict` checks it by substitution.

    Attributes:
        sample: Index of the sample.
        time: [s].
        rows: The conflicting rows and sides.
        multipliers: y of these rows, per unit of the row; positive at an upper limit.
        widening: Every limit must grow by at least this share for the sample to become feasible.
    """

    sample: int
    time: float
    rows: tuple[ActiveRow, ...]
    multipliers: tuple[float, ...]
    widening: float

    def __str__(self) -> str:
        names = "; ".join(str(row) for row in self.rows)
        return (
            f"at t = {self.time:.4g} s (sample {self.sample}) no torques carry the object at any speed: these limits "
            f"conflict: {names}. Every limit of the cell would have to grow by at least {100 * self.widening:.3g} %"
        )


def limit_scale(problem: SampleProblem) -> Array:
    """What 100 % of a limit is: its larger side, or 1 where both sides are zero, Shape (r,).

    Rows of the object's balance are laws, not limits: 0.
    """
    sides = np.stack([np.abs(problem.limit_lower), np.abs(problem.limit_upper)])
    largest = np.max(np.where(np.isfinite(sides), sides, 0.0), axis=0)
    scale = np.where(largest > 0, largest, 1.0)
    laws = np.array([name.kind == "balance" for name in problem.names])
    return np.where(laws, 0.0, scale)


def find_conflicts(
    problem: SampleProblem, time: Array, samples: NDArray[np.int_], solver: str
) -> list[Conflict | None]:
    """Decide feasibility of some samples and explain the infeasible ones.

    The elastic program min s, lower - s·scale <= A x <= upper + s·scale always has a solution; s > 0 exactly where
    the sample is infeasible, and its multipliers are the Farkas certificate.

    Args:
        problem: Rows of all samples.
        time: Shape (N,) [s].
        samples: Indices of the samples in question.
        solver: Name in the registry.

    Returns:
        For each of `samples` the conflict, or None where the limits hold together.

    Raises:
        SolverError: If no solver answers.
    """
    part = problem.at(samples)
    count, rows, unknowns = part.A.shape
    scale = limit_scale(part)
    widened = np.broadcast_to(scale[None, :, None], (count, rows, 1))
    free = np.full((count, rows), np.inf)
    A = np.concatenate([np.concatenate([part.A, -widened], axis=2), np.concatenate([part.A, widened], axis=2)], axis=1)
    g = np.zeros((count, unknowns + 1))
    g[:, -1] = 1
    x_lower = np.full((count, unknowns + 1), -np.inf)
    x_lower[:, -2:] = 0
    programs = ConvexPrograms(
        None,
        g,
        A,
        np.concatenate([-free, part.lower], axis=1),
        np.concatenate([part.upper, free], axis=1),
        x_lower,
        np.full_like(x_lower, np.inf),
    )
    answers = solve_programs(programs, solver)
    require_verified(answers, "whether the limits hold together")
    y = answers.row_dual[:, :rows] + answers.row_dual[:, rows:]
    conflicts: list[Conflict | None] = []
    for index, sample in enumerate(samples):
        rows_of_sample = _certified_rows(part, index, y[index], scale)
        if rows_of_sample is None:
            conflicts.append(None)
            continue
        active, multipliers = rows_of_sample
        widening = float(answers.x[index, -1])
        conflicts.append(Conflict(int(sample), float(time[sample]), active, multipliers, widening))
    return conflicts


def separation(problem: SampleProblem, index: int, y: Array) -> tuple[float, float]:
    """Check a Farkas certificate by substitution.

    For every x with c² >= 0 the rows give yᵀA x <= Σ_{y>0} y upper + Σ_{y<0} y lower. If yᵀA is zero on the free
    unknowns and >= 0 on c², the left side is >= 0; a negative right side then proves infeasibility.

    Args:
        problem: Rows.
        index: Sample.
        y: Multipliers, Shape (r,).

    Returns:
        The right side, and the largest error of the left side's conditions.
    """
    combined = y @ problem.A[index]
    error = max(float(np.max(np.abs(combined[:-1]), initial=0.0)), 0.0, -float(combined[-1]))
    limit = np.where(y > 0, problem.upper[index], np.where(y < 0, problem.lower[index], 0.0))
    return float(np.sum(y * limit)), error


def _certified_rows(
    problem: SampleProblem, index: int, y: Array, scale: Array
) -> tuple[tuple[ActiveRow, ...], tuple[float, ...]] | None:
    weight = np.abs(y) * (np.max(np.abs(problem.A[index]), axis=1) + scale)
    keep = weight > NEGLIGIBLE_MULTIPLIER * np.max(weight, initial=0.0)
    y = np.where(keep, y, 0.0)
    size = float(np.sum(np.abs(y) * scale))
    if size == 0:
        return None
    value, error = separation(problem, index, y)
    if value >= -CERTIFICATE_TOLERANCE * size or error > COMBINATION_TOLERANCE * float(np.max(weight)):
        return None
    active, multipliers = [], []
    for row in np.flatnonzero(y):
        upper = y[row] > 0
        limit = problem.limit_upper[row] if upper else problem.limit_lower[row]
        active.append(ActiveRow(problem.names[row], "upper" if upper else "lower", float(limit)))
        multipliers.append(float(y[row]))
    return tuple(active), tuple(multipliers)
