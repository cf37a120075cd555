# SPDX-License-Identifier: MIT
"""What a small change of a layout does to c²⁺, as a linear program.

c²⁺ of a layout θ is the largest c² for which wrenches x_k keep the rows A_k(θ) x_k + a_k(θ) c² + b_k(θ) c <= u_k(θ) of
all samples. With rows that are linear in a change of θ it is found together with the best change inside a box: a step
of sequential linear programming (Griffith and Stewart, 1961). How rows change is read off at layouts beside this one,
so that whatever limits a cell is searched with.
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import OptimizeResult, linprog
from scipy.sparse import block_diag, csr_array, hstack

from mrts.base.arrays import Array, apply
from mrts.base.errors import SolverError
from mrts.program.sample_problem import SampleProblem


class LayoutProgram:
    """The program of one layout, for P numbers that may change.

    Args:
        here: Its rows at N samples, a problem for each load that must be carried.
        beside: The same problems of layouts in each of which one number is larger.
        steps: By how much, Shape (P,); below 0 it is smaller.
        c2: c²⁺ here.

    Raises:
        SolverError: If HiGHS does not solve it.
    """

    def __init__(
        self, here: Sequence[SampleProblem], beside: Sequence[Sequence[SampleProblem]], steps: Array, c2: float
    ) -> None:
        A, speed, limit = _one_sided(here)
        kept, c = np.isfinite(limit), np.sqrt(c2)
        wrenches = block_diag([of[rows, :-1] for of, rows in zip(A, kept, strict=True)])
        square = A[:, :, -1] + speed / (2 * c)  # c is linear in c² near c²⁺
        self._matrix = hstack([csr_array(square[kept][:, None]), wrenches], format="csr")
        self._limit = (limit - speed * c / 2)[kept]
        found = self._solved(np.zeros((len(self._limit), 0)), np.zeros((0, 2)))
        x = np.append(found.x[1:].reshape(len(A), -1), np.full((len(A), 1), c2), axis=1)

        def beyond(problems: Sequence[SampleProblem]) -> Array:
            A, speed, limit = _one_sided(problems)
            over: Array = apply(A, x) + speed * c - limit
            return over[kept]

        changes = [beyond(problems) - beyond(here) for problems in beside]
        self._by_layout = np.stack(changes, axis=1) / steps
        self._c2 = c2

    def best_change(self, lower: Array, upper: Array) -> tuple[Array, float, Array]:
        """The best change of the layout between bounds, each Shape (P,), c²⁺ that the program has there, and its slope.

        The slope is ∂ ln c²⁺/∂θ by its multipliers, Shape (P,): of several rows that bind alike, those are weighed so
        that it vanishes for what is at no bound.

        Raises:
            SolverError: If HiGHS does not solve it.
        """
        found = self._solved(self._by_layout, np.stack([lower, upper], axis=1))
        return found.x[-len(lower) :], float(found.x[0]), found.ineqlin.marginals @ self._by_layout / self._c2

    def _solved(self, by_layout: Array, bounds: Array) -> OptimizeResult:
        free = [(None, None)] * self._matrix.shape[1]
        found = linprog(
            -np.eye(1, len(free) + len(bounds))[0],
            A_ub=hstack([self._matrix, csr_array(by_layout)], format="csr"),
            b_ub=self._limit,
            bounds=[*free, *bounds.tolist()],
        )
        if found.x is None:
            raise SolverError(f"HiGHS finds no change of the layout: {found.message}")
        return found


def _one_sided(problems: Sequence[SampleProblem]) -> tuple[Array, Array, Array]:
    """Both sides of the rows of all problems as A x + b c <= u: A, Shape (S, 2 r, k), b and u, Shape (S, 2 r)."""
    sides = [
        (np.concatenate([of.A, -of.A], axis=1), np.zeros_like(of.lower) if of.speed is None else of.speed,
         np.concatenate([of.upper, -of.lower], axis=1))
        for of in problems
    ]  # fmt: skip
    A, speed, limit = (np.concatenate(parts) for parts in zip(*sides, strict=True))
    return A, np.concatenate([speed, -speed], axis=1), limit
