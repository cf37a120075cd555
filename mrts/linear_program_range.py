# SPDX-License-Identifier: MIT
"""The range of c² at every sample where the distribution of the load is free: two linear programs."""

import numpy as np

from mrts.convex_program import Answers, ConvexPrograms, solve_programs
from mrts.range_ends import RangeEnds, active_rows
from mrts.rigid_transform import Array
from mrts.sample_problem import SampleProblem

UNBOUNDED = 1e9
"""Effect of the speed on some row, as a multiple of its limit, beyond which a range has no upper end."""

UNBOUNDED_SLACK = 1e-9
"""Rounding of an answer at that bound."""


def ends_by_linear_programs(problem: SampleProblem, solver: str) -> RangeEnds:
    """Eqs. (26), (29): least and largest c² >= 0 within all limits; c² is scaled to the size of the other unknowns."""
    count, _, unknowns = problem.A.shape
    effect = effect_of_speed(problem)
    unit = 1 / np.where(effect > 0, effect, 1.0)  # c² = unit · y, where y = 1 moves some row by a whole limit
    A = problem.A.copy()
    A[:, :, -1] *= unit[:, None]
    x_lower = np.full((count, unknowns), -np.inf)
    x_lower[:, -1] = 0.0
    x_upper = np.full((count, unknowns), np.inf)
    x_upper[:, -1] = np.where(effect > 0, UNBOUNDED, 0.0)

    def solve(direction: float) -> Answers:
        g = np.zeros((count, unknowns))
        g[:, -1] = direction
        programs = ConvexPrograms(None, g, A, problem.lower, problem.upper, x_lower, x_upper)
        return solve_programs(programs, solver)

    least, most = solve(1.0), solve(-1.0)
    low, high = np.maximum(least.x[:, -1], 0.0) * unit, most.x[:, -1] * unit
    free = (most.x[:, -1] >= UNBOUNDED * (1 - UNBOUNDED_SLACK)) | (effect == 0)
    high = np.where(free, np.inf, high)
    low_rows = [
        active_rows(problem, least.row_dual[sample], float(least.bound_dual[sample, -1])) for sample in range(count)
    ]
    high_rows = [active_rows(problem, most.row_dual[sample], 0.0) for sample in range(count)]
    undecided = ~(least.verified & most.verified)
    return RangeEnds(low, high, low_rows, high_rows, undecided, least.fallbacks + most.fallbacks)


def effect_of_speed(problem: SampleProblem) -> Array:
    """Largest effect of c² = 1 on a limit, or on a balance that other unknowns of the size of their limits keep."""
    size = np.abs(problem.A)
    limits = size[:, problem.is_limit]
    effect: Array = np.max(limits[:, :, -1], axis=1)
    laws = size[:, ~problem.is_limit]
    if laws.shape[1] == 0:
        return effect
    reach = np.max(limits[:, :, :-1], axis=1)  # 1 / size of each unknown at its limits
    terms = np.max(laws[:, :, :-1] / np.where(reach > 0, reach, 1.0)[:, None, :], axis=2)
    in_laws: Array = np.max(laws[:, :, -1] / np.where(terms > 0, terms, 1.0), axis=1)
    return np.maximum(effect, in_laws)
