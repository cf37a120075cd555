# SPDX-License-Identifier: MIT
"""By how much limits must move outward at a sample before a given c² is admissible there."""

import numpy as np

from mrts.base.arrays import Array
from mrts.limits.rows import ActiveRow
from mrts.samples.sample_problem import SampleProblem
from mrts.solvers.elastic_program import Widening, least_widening


def widening_at(problem: SampleProblem, c2: float | Array, solver: str, what: str) -> Array:
    """Least s that admits a given c², Shape (N,); where c² is the only unknown, the largest excess.

    Args:
        problem: Rows of some samples.
        c2: c², one for all samples or one a sample, Shape (N, 1).
        solver: Name in the registry.
        what: What is found, for the message.

    Raises:
        SolverError: If no solver answers.
    """
    return _widening(problem, c2, solver, what).share


def overstepped_row(problem: SampleProblem, sample: int, c2: float, solver: str, what: str) -> ActiveRow | None:
    """The limit that stands most in the way of a given c² at one sample; None where none does.

    Args:
        problem: Rows of some samples.
        sample: Which of them.
        c2: c² there.
        solver: Name in the registry.
        what: What is found, for the message.

    Raises:
        SolverError: If no solver answers.
    """
    one = problem.at(np.array([sample]))
    dual = np.where(one.is_limit, _widening(one, c2, solver, what).row_dual[0], 0.0)
    strongest = int(np.argmax(np.abs(dual)))
    return one.active_row(strongest, upper=bool(dual[strongest] > 0)) if dual[strongest] else None


def _widening(problem: SampleProblem, c2: float | Array, solver: str, what: str) -> Widening:
    lower, upper = problem.limits_at(c2)
    if problem.unknowns > 1:
        free = np.full(problem.unknowns - 1, -np.inf)
        return least_widening(problem.free, lower, upper, problem.is_limit, free, solver, what)
    excess = np.maximum(lower, -upper)
    worst, every = np.argmax(excess, axis=1), np.arange(len(excess))
    share = np.maximum(0.0, excess[every, worst])
    dual = np.zeros(excess.shape)
    dual[every, worst] = np.where(share > 0, np.where(lower[every, worst] > -upper[every, worst], -1.0, 1.0), 0.0)
    return Widening(share, dual)
