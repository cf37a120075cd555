"""The rows that set an end of the range: all of them, whichever solver found it and in whichever form."""

from dataclasses import replace

import numpy as np
import pytest
from given_ranges import ranges_of
from random_programs import cell_programs
from scipy.optimize import linprog

import mrts
from mrts.kernel.programs import OPTIMAL
from mrts.limits.rows import STANDSTILL
from mrts.program import sample_ranges
from mrts.program.sample_problem import SampleProblem
from mrts.program.sample_ranges import TIE, ends_of_problem, rows_at_end
from mrts.scaling.range import intersect

SOLVERS = ("kernel", "qpsol:qpoases")

TIGHT = 1e-7
"""Distance of a row from its limit at a solution, as a share of it, that is rounding."""

CLEAR = 1e-3
"""Multipliers below this share of the largest are left out of a comparison: from where they count is a tolerance."""


def problem_of(A, lower, upper):
    count, rows, unknowns = A.shape
    names = tuple(mrts.RowName("torque", "arm", str(row), "N m") for row in range(rows))
    limits = np.ones(rows, dtype=bool)
    return SampleProblem(
        torque_map=np.zeros((count, 0, unknowns)),
        torque_offset=np.zeros((count, 0)),
        wrench_map=np.zeros((count, 0, unknowns)),
        wrench_offset=np.zeros((count, 0)),
        names=names,
        unit=np.ones(rows),
        is_limit=limits,
        is_cap=~limits,
        A=A,
        lower=lower,
        upper=upper,
        limit_lower=lower[0],
        limit_upper=upper[0],
    )


def binding_at_the_top(problem):
    """Rows with a multiplier at the largest c², each with its side, 1 at the upper limit; None if there is no end."""
    found = ends_of_problem(replace(problem, solver="qpsol:qpoases"), np.inf)
    if found["status"][0] != OPTIMAL or not np.isfinite(found["upper"][0]):
        return None
    return [(row, np.sign(found["duals"][0, 1, row])) for row in np.flatnonzero(found["duals"][0, 1])]


def degenerate_problem(rng):
    """One sample where sums of the limits that bind at its upper end are limits as well, so that more rows meet there
    than there are unknowns. None if it has no upper end.
    """
    A, lower, upper = cell_programs(rng, 1, int(rng.integers(2, 4)), 3)
    binding = binding_at_the_top(problem_of(A, lower, upper))
    if binding is None:
        return None
    rows, side = (np.array(values) for values in zip(*binding, strict=True))
    rows = rows.astype(int)
    sums = rng.uniform(0.2, 1, (3, len(rows))) * (rng.random((3, len(rows))) < 0.6)
    sums = np.concatenate([sums[np.any(sums > 0, axis=1)], np.eye(len(rows))[:1]])
    limit = np.where(side > 0, upper[0, rows], -lower[0, rows])
    A = np.concatenate([A, [sums @ (side[:, None] * A[0, rows])]], axis=1)
    upper = np.concatenate([upper, [sums @ limit]], axis=1)
    lower = np.concatenate([lower, np.full((1, len(sums)), -np.inf)], axis=1)
    order = rng.permutation(A.shape[1])
    return problem_of(A[:, order], lower[:, order], upper[:, order])


def largest_multipliers(problem):
    """By row and side, the largest multiplier in any solution of the dual program of max c²."""
    A, lower, upper = problem.A[0], problem.lower[0], problem.upper[0]
    c2 = np.zeros(A.shape[1])
    c2[-1] = 1.0
    sides = np.concatenate([A[np.isfinite(upper)], -A[np.isfinite(lower)]])
    limits = np.concatenate([upper[np.isfinite(upper)], -lower[np.isfinite(lower)]])
    names = [(row, "upper") for row in np.flatnonzero(np.isfinite(upper))]
    names += [(row, "lower") for row in np.flatnonzero(np.isfinite(lower))]
    best = linprog(-c2, A_ub=sides, b_ub=limits, bounds=[(None, None)] * (len(c2) - 1) + [(0, None)])
    near = np.flatnonzero(limits - sides @ best.x <= TIGHT)
    found = {}
    for place in near:
        g = np.where(near == place, -1.0, 0.0)
        dual = linprog(g, A_eq=sides[near].T, b_eq=c2, bounds=[(0, 1e3)] * len(near))
        found[names[place]] = -dual.fun
    return found


@pytest.mark.quick
def test_all_rows_with_a_multiplier_in_some_dual_solution_are_named_for_every_solver():
    rng = np.random.default_rng(7)
    checked = differing = 0
    for _ in range(40):
        problem = degenerate_problem(rng)
        if problem is None:
            continue
        named, by_solver = set(), set()
        for solver in SOLVERS:
            found = sample_ranges.sample_ranges(replace(problem, solver=solver), np.zeros(1))
            rows = rows_at_end(problem, float(found.upper[0]), "upper")
            assert set(found.binding(0, "upper")) <= set(rows)
            named.add(rows)
            by_solver.add(frozenset(found.binding(0, "upper")))
        assert len(named) == 1
        multipliers = largest_multipliers(problem)
        largest = max(multipliers.values())
        clear = {key for key, size in multipliers.items() if size > CLEAR * largest}
        named = {(int(row.name.element), row.side) for row in named.pop()}
        assert clear <= named
        assert named <= {key for key, size in multipliers.items() if size > CLEAR**2 * largest}
        checked += 1
        differing += len(by_solver) > 1
    assert checked > 25
    assert differing > 0, "no solver's own rows differ: nothing was tested"


def test_at_rest_the_end_is_standing_still():
    A, lower, upper = np.array([[[1.0, 1.0], [0.5, -1.0]]]), np.full((1, 2), -1.0), np.full((1, 2), 1.0)
    problem = problem_of(A, lower, upper)
    assert [row.name for row in rows_at_end(problem, 0.0, "lower")] == [STANDSTILL]


def test_of_samples_that_differ_by_rounding_the_first_sets_the_end():
    low, high = np.array([0.0, 0.5, 0.5, 0.5]), np.array([3.0, 2.0, 4.0, 2.0])
    for shift in (0, TIE / 2, -TIE / 2):
        lower, upper = low.copy(), high.copy()
        lower[2] *= 1 + shift
        upper[3] *= 1 + shift
        found = intersect(ranges_of(lower, upper))
        assert (found.lower.sample, found.upper.sample) == (1, 1)
        assert (found.lower.c2, found.upper.c2) == (np.max(lower), np.min(upper))
