# SPDX-License-Identifier: MIT
"""The range of c² at every sample where the distribution of the load is free: two linear programs."""

import numpy as np

from mrts.base.arrays import Array
from mrts.program.convex_program import ConvexPrograms
from mrts.program.motion_rows import binds
from mrts.program.range_ends import BINDING_TOLERANCE, RangeEnds, codes_of_duals, rows_of_problem
from mrts.program.sample_problem import SampleProblem
from mrts.program.solvers import Answers, solve_programs

UNBOUNDED = 1e9
"""Effect of the speed on some row, as a multiple of its limit, beyond which a range has no upper end."""

AT_UNBOUNDED = 1e-9
"""Rounding of an answer at that bound."""

NO_EFFECT = 1e-300
"""What moves no row by more than this share of a limit moves none: its reciprocal is not finite. As in numbers.h."""


def ends_by_linear_programs(problem: SampleProblem, solver: str) -> RangeEnds:
    """Eqs. (26), (29): least and largest c² >= 0 within all limits; c² is scaled to the size of the other unknowns.

    Caps go in as a bound of c²: rows of a motion near rest would spoil its scale.
    """
    count, _, unknowns = problem.A.shape
    effect = effect_of_speed(problem)
    unit = 1 / np.where(effect > 0, effect, 1.0)  # c² = unit · y, where y = 1 moves some row by a whole limit
    caps, most = problem.is_cap, problem.cap()
    A, lower, upper = problem.A[:, ~caps], problem.lower[:, ~caps], problem.upper[:, ~caps]
    A[:, :, -1] *= unit[:, None]
    x_lower = np.full((count, unknowns), -np.inf)
    x_lower[:, -1] = 0.0
    x_upper = np.full((count, unknowns), np.inf)
    x_upper[:, -1] = np.where(effect > 0, np.minimum(UNBOUNDED, most / unit), 0.0)

    def solve(direction: float) -> Answers:
        g = np.zeros((count, unknowns))
        g[:, -1] = direction
        programs = ConvexPrograms(H=None, g=g, A=A, lower=lower, upper=upper, x_lower=x_lower, x_upper=x_upper)
        return solve_programs(programs, solver)

    least, largest = solve(1.0), solve(-1.0)
    ends = np.maximum(least.x[:, -1], 0.0) * unit, largest.x[:, -1] * unit
    free = (largest.x[:, -1] >= UNBOUNDED * (1 - AT_UNBOUNDED)) | (effect == 0)
    at_most = np.sign(problem.square[:, caps]) * binds(problem.cap_share) * np.maximum(largest.bound_dual[:, -1:], 0.0)
    duals = [np.zeros(problem.A.shape[:2]) for _ in range(2)]
    duals[0][:, ~caps], duals[1][:, ~caps], duals[1][:, caps] = least.row_dual, largest.row_dual, at_most
    duals[1][free] = 0.0
    weight = np.maximum(np.max(np.abs(duals[0]), axis=1, initial=0.0), still := np.abs(least.bound_dual[:, -1]))
    duals[0][np.abs(duals[0]) <= BINDING_TOLERANCE * weight[:, None]] = 0.0
    codes = [codes_of_duals(problem, duals[0], still > BINDING_TOLERANCE * weight), codes_of_duals(problem, duals[1])]
    undecided = ~(least.verified & largest.verified)
    rows, fallbacks = rows_of_problem(problem, np.stack(codes)), least.fallbacks + largest.fallbacks
    return RangeEnds(ends[0], np.where(free, np.inf, ends[1]), rows, undecided, fallbacks)


def effect_of_speed(problem: SampleProblem) -> Array:
    """Largest effect of c² = 1 on a limit, or on a balance that other unknowns of the size of their limits keep."""
    size = np.abs(problem.A)
    limits = size[:, problem.is_limit]
    effect: Array = np.max(limits[:, :, -1], axis=1, initial=0.0)
    laws = size[:, ~problem.is_limit]
    if laws.shape[1] == 0:
        return np.where(effect > NO_EFFECT, effect, 0.0)
    reach = np.max(limits[:, :, :-1], axis=1, initial=0.0)  # 1 / size of each unknown at its limits
    terms = np.max(laws[:, :, :-1] / np.where(reach > 0, reach, 1.0)[:, None, :], axis=2)
    in_laws: Array = np.max(laws[:, :, -1] / np.where(terms > 0, terms, 1.0), axis=1)
    effect = np.maximum(effect, in_laws)
    return np.where(effect > NO_EFFECT, effect, 0.0)
