# SPDX-License-Identifier: MIT
"""Which limits leave no speed at a sample, or none that leads on to the next."""

from dataclasses import replace

import numpy as np

from mrts.base.arrays import Array
from mrts.limits.rows import RowName
from mrts.program.infeasibility import Conflict, find_conflicts
from mrts.program.sample_problem import SampleProblem
from mrts.program.solvers import DEFAULT_SOLVER

SLOWEST = 1e-6
"""Least speed squared at which rows with terms in √x are looked at, of one that moves a row by its limit."""

FASTEST = 10.0
"""The largest, likewise."""

TRIED = 48
"""How many there are, beside standstill."""

REACHED = 3
"""Speeds at the next sample, from the least to the largest, that are looked at with each of them."""


def sample_conflict(problem: SampleProblem, time: Array, sample: int, x: float | None = None) -> Conflict | None:
    """The limits that no wrenches, u and x keep at one sample; None if some do.

    Args:
        problem: Rows of [F, u, x] at N samples.
        time: Shape (N,) [s].
        sample: Index.
        x: The speed squared that is asked for; None leaves it free.
    """
    if problem.speed is not None:
        tried = _tried(problem, sample) if x is None else np.array([x])
        here = _at_speeds(problem, sample, tried)
        return _least(
            find_conflicts(here, np.full(len(tried), time[sample]), np.arange(len(tried)), DEFAULT_SOLVER), sample
        )
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
    if problem.speed is not None:
        return _at_pairs(problem, time, sample, step, reach, x)
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


def _tried(problem: SampleProblem, sample: int) -> Array:
    """Speeds squared at which rows with a term in √x are looked at: from standstill to where they end, Shape (p,)."""
    root = np.zeros(1) if problem.speed is None else problem.speed[sample]
    size = [float(np.max(np.abs(problem.square[sample]))), float(np.max(np.abs(root))) ** 2]
    likely = [1 / one for one in size if one > 0]
    ladder = np.geomspace(SLOWEST * min(likely), FASTEST * max(likely), TRIED)
    return np.append(0.0, ladder[ladder <= problem.cap()[sample]])


def _at_speeds(problem: SampleProblem, sample: int, x: Array) -> SampleProblem:
    """One sample's rows where x, Shape (p,), is given; its unknown is left and has no effect."""
    here = problem.at(np.full(len(x), sample))
    lower, upper = here.limits_at(x[:, None])
    A = here.A.copy()
    A[:, :, -1] = 0.0
    return replace(here, A=A, lower=lower, upper=upper, speed=None)


def _least(found: list[Conflict | None], sample: int) -> Conflict | None:
    """The conflict for which limits must move least; None where there is none at some speed."""
    conflicts = [one for one in found if one is not None]
    if len(conflicts) < len(found):
        return None
    return replace(min(conflicts, key=lambda one: one.widening), sample=sample)


def _at_pairs(
    problem: SampleProblem, time: Array, sample: int, step: float, reach: tuple[float, float], x: float | None
) -> Conflict | None:
    """`segment_conflict` where rows have terms in √x: with x given at both ends, u is known, and each is by itself."""
    starts = _tried(problem, sample) if x is None else np.array([x])
    pairs = np.array([(start, end) for start in starts for end in np.linspace(*reach, REACHED)])
    u = (pairs[:, 1] - pairs[:, 0]) / (2 * step)
    ends = []
    for place in (0, 1):
        rows = _at_speeds(problem, sample + place, pairs[:, place])
        given, A = rows.rate * u[:, None], rows.A.copy()
        A[:, :, -2] = 0.0
        rows = replace(rows, A=A, lower=rows.lower - given, upper=rows.upper - given)
        ends.append(find_conflicts(rows, np.full(len(u), time[sample]), np.arange(len(u)), DEFAULT_SOLVER))
    worse = [max(filter(None, pair), key=lambda one: one.widening, default=None) for pair in zip(*ends, strict=True)]
    return _least(worse, sample)


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
