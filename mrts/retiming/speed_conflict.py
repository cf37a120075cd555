# SPDX-License-Identifier: MIT
"""Which limits leave no speed at a sample, or none that leads on to the next."""

from dataclasses import replace

import numpy as np

from mrts.base.arrays import Array
from mrts.limits.rows import RowName
from mrts.samples.infeasibility import Conflict, find_conflicts
from mrts.samples.sample_problem import SampleProblem
from mrts.solvers import DEFAULT_SOLVER


def sample_conflict(problem: SampleProblem, time: Array, sample: int, x: float | None = None) -> Conflict | None:
    """The limits that no wrenches, u and x keep at one sample; None if some do.

    Args:
        problem: Rows of [F, u, x] at N samples.
        time: Shape (N,) [s].
        sample: Index.
        x: The speed squared that is asked for; None leaves it free.
    """
    here = problem.at(np.array([sample]))
    if x is not None:
        column = np.zeros(problem.unknowns)
        column[-1] = 1.0
        here = _with_law(here, RowName("speed", element="here"), column, x, x)
    found = find_conflicts(here, time[[sample]], np.array([0]), DEFAULT_SOLVER)[0]
    return None if found is None else replace(found, sample=sample)


def segment_conflict(
    problem: SampleProblem,
    time: Array,
    sample: int,
    step: float,
    reach: tuple[float, float],
    x: float | None = None,
) -> Conflict | None:
    """The limits of both ends of a segment that no u and x keep, if x at its end is to be in the reach.

    Args:
        problem: Rows of [F, u, x] at N samples.
        time: Shape (N,) [s].
        sample: Start of the segment.
        step: Its length.
        reach: Least and largest x at its end.
        x: The speed squared that is asked for at its start; None leaves it free.
    """
    here, there = problem.at(np.array([sample])), problem.at(np.array([sample + 1]))
    rows, unknowns = problem.A.shape[1:]
    free = unknowns - 2
    A = np.zeros((1, 2 * rows, 2 * free + 2))
    A[0, :rows, :free], A[0, :rows, -2:] = here.A[0, :, :free], here.A[0, :, -2:]
    A[0, rows:, free:-2], A[0, rows:, -1] = there.A[0, :, :free], there.square[0]
    A[0, rows:, -2] = there.rate[0] + 2 * step * there.square[0]
    nothing = {"torque_map": np.zeros((1, 0, 2 * free + 2)), "torque_offset": np.zeros((1, 0))}
    nothing |= {"wrench_map": nothing["torque_map"], "wrench_offset": nothing["torque_offset"]}
    both = SampleProblem(
        **nothing,
        names=(*problem.names, *problem.names),
        unit=np.tile(problem.unit, 2),
        is_limit=np.tile(problem.is_limit, 2),
        is_cap=np.zeros(2 * rows, dtype=bool),  # at the end of the segment u moves them, too
        A=A,
        lower=np.concatenate([here.lower, there.lower], axis=1),
        upper=np.concatenate([here.upper, there.upper], axis=1),
        limit_lower=np.tile(problem.limit_lower, 2),
        limit_upper=np.tile(problem.limit_upper, 2),
    )
    column = np.zeros(2 * free + 2)
    column[-1] = 1.0
    if x is not None:
        both = _with_law(both, RowName("speed", element="here"), column, x, x)
    column[-2] = 2 * step
    both = _with_law(both, RowName("speed", element="at the next sample"), column, *reach)
    found = find_conflicts(both, time[[sample]], np.array([0]), DEFAULT_SOLVER)[0]
    return None if found is None else replace(found, sample=sample)


def _with_law(problem: SampleProblem, name: RowName, column: Array, lower: float, upper: float) -> SampleProblem:
    """One sample's rows with one more, which is no limit that could move outward."""
    size = max(abs(lower), abs(upper)) or 1.0
    no = np.zeros(1, dtype=bool)
    return problem.with_rows(
        [name],
        unit=np.array([size]),
        is_limit=no,
        is_cap=no,
        A=column[None, None] / size,
        lower=np.array([[lower / size]]),
        upper=np.array([[upper / size]]),
        limit_lower=np.array([lower]),
        limit_upper=np.array([upper]),
    )
