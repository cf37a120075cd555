# SPDX-License-Identifier: MIT
"""The range of c² where a fixed distribution leaves c² as the only unknown: every row bounds it by itself."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.program.range_ends import BINDING_TOLERANCE, RangeEnds, rows_of_problem
from mrts.program.sample_problem import SampleProblem


@dataclass(frozen=True)
class LoadSensitivity:
    """How rows move when a load's parameter goes from its least to its largest value; p parameters.

    In row units: a row reads A x + Σ_j s_j (c2[j] c² + offset[j]) with every s_j in [0, 1].

    Attributes:
        c2: Change of the coefficient of c², Shape (p, N, r).
        offset: Change of the value at c² = 0, Shape (p, N, r).
    """

    c2: Array
    offset: Array


def load_sensitivity(least: SampleProblem, others: list[SampleProblem]) -> LoadSensitivity:
    """Differences of the rows of p + 1 loads, exact as rows are affine in the load.

    Args:
        least: Rows with every parameter at its least value.
        others: Rows with one parameter at its largest value, one problem a parameter.
    """
    shape = (len(others), *least.A.shape[:2])
    c2 = np.array([other.square - least.square for other in others]).reshape(shape)
    upper = np.isfinite(least.upper)
    finite = np.where(upper, least.upper, least.lower)  # limits move opposite to the offset of their row
    offset = np.array([finite - np.where(upper, other.upper, other.lower) for other in others]).reshape(shape)
    return LoadSensitivity(c2, offset)


def ends_in_closed_form(problem: SampleProblem, sensitivity: LoadSensitivity | None = None) -> RangeEnds:
    """Eqs. (38), (39): every row bounds c² by itself; `intersect` adds the intersection over t.

    With an uncertain load a row's worst value over the box is a convex, piecewise linear function of c², as each
    parameter takes its worse end by itself; so a row still bounds c² to an interval, and no corner is enumerated.

    Args:
        problem: Rows in which c² is the only unknown; those of the least parameters if the load is uncertain.
        sensitivity: Effect of the uncertain parameters; None if the load is known.
    """
    slope = problem.square
    none = np.zeros((0, *slope.shape))
    c2, offset = (none, none) if sensitivity is None else (sensitivity.c2, sensitivity.offset)
    least_by_upper, most_by_upper = _worst_below_zero(slope, -problem.upper, c2, offset)
    least_by_lower, most_by_lower = _worst_below_zero(-slope, problem.lower, -c2, -offset)
    least, most = np.maximum(least_by_upper, least_by_lower), np.minimum(most_by_upper, most_by_lower)
    lower, upper = np.max(least, axis=1, initial=0.0), np.min(most, axis=1, initial=np.inf)
    sides = [
        tied_sides(least, lower, least_by_upper >= least_by_lower),
        tied_sides(most, upper, most_by_upper <= most_by_lower),
    ]
    rows = rows_of_problem(problem, tied_codes(np.stack(sides), lower))
    return RangeEnds(lower, upper, rows, lower > upper, 0)


def tied_codes(sides: NDArray[np.int8], lower: Array) -> NDArray[np.int32]:
    """Codes of `BindingRows`: of rows that tie, or of c² >= 0 alone where a sample may stand still.

    Args:
        sides: As from `tied_sides`, of both ends, Shape (2, N, r).
        lower: c²⁻(t), Shape (N,).
    """
    still = lower == 0
    sides[0, still] = 0
    first = np.zeros((*sides.shape[:2], 1), dtype=np.int32)
    first[0, still] = -1 - sides.shape[2]
    codes = sides * np.arange(1, sides.shape[2] + 1, dtype=np.int32)
    return np.concatenate([first, codes], axis=2)


def tied_sides(ends: Array, c2: Array, by_upper: NDArray[np.bool_]) -> NDArray[np.int8]:
    """Rows whose own end ties with that of their sample: 1 by its upper limit, -1 by its lower one, 0 for none.

    Args:
        ends: Of each row, Shape (N, r).
        c2: Of each sample, Shape (N,).
        by_upper: Whether a row's end is set by its upper limit, Shape (N, r).
    """
    given = np.where(np.isfinite(c2), c2, np.nan)[:, None]
    near = np.abs(ends - given) <= BINDING_TOLERANCE * np.abs(given)
    return np.where(near, np.where(by_upper, 1, -1), 0).astype(np.int8)


def worst_parameters(problem: SampleProblem, sensitivity: LoadSensitivity, c2: Array) -> NDArray[np.bool_]:
    """Which parameters are at their largest value in the load that comes closest to a limit, Shape (N, p).

    Args:
        problem: Rows of the least parameters.
        sensitivity: Effect of the parameters.
        c2: At this c² of each sample, Shape (N,).
    """
    effect = sensitivity.c2 * c2[:, None] + sensitivity.offset
    value = problem.square * c2[:, None]
    if not value.size:
        return np.zeros((len(c2), len(effect)), dtype=bool)  # no limit to come close to
    above = value + np.sum(np.maximum(effect, 0.0), axis=0) - problem.upper
    below = problem.lower - value - np.sum(np.minimum(effect, 0.0), axis=0)
    row, samples = np.argmax(np.maximum(above, below), axis=1), np.arange(len(c2))
    at_upper = (above >= below)[samples, row]
    there = effect[:, samples, row]
    return np.asarray(np.where(at_upper, there > 0, there < 0)).T


def _worst_below_zero(a: Array, b: Array, d: Array, e: Array) -> tuple[Array, Array]:
    """Where a c² + b + Σ_j max(0, d_j c² + e_j) <= 0 with c² >= 0: an interval, [∞, -∞] if nowhere.

    Args:
        a: Shape (N, r).
        b: Shape (N, r), minus infinity where there is no limit.
        d: Shape (p, N, r).
        e: Shape (p, N, r).
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        turns = np.where(d != 0, -e / d, 0.0)
    turns = np.sort(np.where(np.isfinite(turns) & (turns > 0), turns, 0.0), axis=0)
    corners = np.concatenate([np.zeros((1, *a.shape)), turns])
    values = a * corners + b + np.sum(np.maximum(0.0, d[:, None] * corners + e[:, None]), axis=0)
    lower, upper = np.full(a.shape, np.inf), np.full(a.shape, -np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for index in range(len(corners)):
            start, at_start = corners[index], values[index]
            if index + 1 < len(corners):
                stop, at_stop = corners[index + 1], values[index + 1]
                root = start + (stop - start) * (at_start / (at_start - at_stop))
            else:
                growth = a + np.sum(np.maximum(0.0, d), axis=0)
                stop, at_stop = np.full(a.shape, np.inf), np.where(growth == 0, at_start, growth)
                root = start - at_start / growth
            inside, ends_inside = at_start <= 0, at_stop <= 0
            lower = np.minimum(lower, np.where(inside, start, np.where(ends_inside, root, np.inf)))
            upper = np.maximum(upper, np.where(ends_inside, stop, np.where(inside, root, -np.inf)))
    return lower, upper
