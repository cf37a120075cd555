# SPDX-License-Identifier: MIT
"""By how much limits must move outward at a sample before a given c² is admissible there."""

import numpy as np

from mrts.base.arrays import Array
from mrts.program.elastic_program import least_widening
from mrts.program.sample_problem import SampleProblem


def widening_at(problem: SampleProblem, c2: float | Array, solver: str, what: str) -> Array:
    """Least s that admits a given c², Shape (N,); where c² is the only unknown, the largest excess.

    Args:
        problem: Rows of some samples.
        c2: c², one for all samples, or one a sample, Shape (N, 1).
        solver: Name in the registry.
        what: What is found, for the message.

    Raises:
        SolverError: If no solver answers.
    """
    lower, upper = problem.limits_at(c2)
    if problem.unknowns == 1:
        return np.asarray(np.max(np.maximum(lower, -upper), axis=1, initial=0.0), dtype=np.float64)
    free = np.full(problem.unknowns - 1, -np.inf)
    return least_widening(problem.free, lower, upper, problem.is_limit, free, solver, what).share
