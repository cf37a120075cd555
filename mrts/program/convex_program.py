# SPDX-License-Identifier: MIT
"""Batches of small convex programs and the verification that makes their answers trustworthy."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mrts.base.arrays import Array

OPTIMALITY_TOLERANCE = 1e-9
"""Residuals of feasibility, stationarity and complementarity, each relative to the terms that it sums."""

GRADIENT_TOLERANCE = 1e-12
"""The same for the gradient of a quadratic cost, so that torques of small weight are right as well."""

HIGHS_TOLERANCE = 1e-10
"""Asked of HiGHS, whose default of 1e-7 is coarser than what an answer must pass."""

Mask = np.typing.NDArray[np.bool_]


@dataclass(frozen=True)
class ConvexPrograms:
    """N programs: minimise ½ xᵀHx + gᵀx subject to lower <= A x <= upper and x_lower <= x <= x_upper.

    Attributes:
        H: Symmetric, positive semidefinite, Shape (N, k, k); None for linear programs.
        g: Shape (N, k).
        A: Shape (N, r, k).
        lower: Shape (N, r), minus infinity where unbounded.
        upper: Shape (N, r), infinity where unbounded.
        x_lower: Shape (N, k).
        x_upper: Shape (N, k).
    """

    H: Array | None
    g: Array
    A: Array
    lower: Array
    upper: Array
    x_lower: Array
    x_upper: Array

    def at(self, samples: Mask) -> "ConvexPrograms":
        """Some of the programs."""
        given: dict[str, Any] = {name: None if of is None else of[samples] for name, of in vars(self).items()}
        return ConvexPrograms(**given)

    def scaled(self) -> "tuple[ConvexPrograms, Array, Array]":
        """The same programs with unknowns of the size of the limits: the largest coefficient of each unknown is 1.

        Inequality rows keep their own scale, which is that of their limits; equations are scaled to coefficients of 1.

        Returns:
            The programs, the factors x = column * x_scaled, Shape (N, k), and the factors of the rows, Shape (N, r).
        """
        column, row = scales(self.A, self.lower == self.upper)
        g = self.g * column
        H = None if self.H is None else self.H * column[:, :, None] * column[:, None, :]
        weight = np.max(np.abs(g), axis=1) if H is None else np.max(np.abs(H), axis=(1, 2))
        weight = 1 / np.where(weight > 0, weight, 1.0)
        programs = ConvexPrograms(
            H=None if H is None else H * weight[:, None, None],
            g=g * weight[:, None],
            A=self.A * column[:, None, :] * row[:, :, None],
            lower=self.lower * row,
            upper=self.upper * row,
            x_lower=self.x_lower / column,
            x_upper=self.x_upper / column,
        )
        return programs, column, row


def scales(A: Array, equation: Mask) -> tuple[Array, Array]:
    """By what unknowns, Shape (N, k), and rows, Shape (N, r), are multiplied for coefficients of the size of limits.

    Args:
        A: Shape (N, r, k).
        equation: Rows whose limits are one number, Shape (N, r); others keep their own scale.
    """
    size = np.abs(A)
    largest = np.max(np.where(equation[:, :, None], 0.0, size), axis=1, initial=0.0)
    largest = np.where(largest > 0, largest, np.max(size, axis=1, initial=0.0))
    column = 1 / np.where(largest > 0, largest, 1.0)
    in_row = np.max(size * column[:, None, :], axis=2)
    return column, np.where(equation & (in_row > 0), 1 / np.where(in_row > 0, in_row, 1.0), 1.0)


def optimality_error(programs: ConvexPrograms, x: Array, row_dual: Array, bound_dual: Array) -> Array:
    """Largest residual of the Karush-Kuhn-Tucker conditions of each scaled program, Shape (N,).

    A limit is measured against 1 (its own size) and the terms of its row, the gradient against its largest term: the
    scaled unknowns have the size of the limits, so this bounds the loss of the objective.
    """
    value = np.concatenate([np.einsum("nrk,nk->nr", programs.A, x), x], axis=1)
    size = np.concatenate([1 + np.einsum("nrk,nk->nr", np.abs(programs.A), np.abs(x)), 1 + np.abs(x)], axis=1)
    lower = np.concatenate([programs.lower, programs.x_lower], axis=1)
    upper = np.concatenate([programs.upper, programs.x_upper], axis=1)
    dual = np.concatenate([row_dual, bound_dual], axis=1)
    infeasible = np.max(np.maximum(lower - value, value - upper) / size, axis=1, initial=0.0)

    gradient = programs.g + np.einsum("nrk,nr->nk", programs.A, row_dual) + bound_dual
    terms = np.abs(programs.g) + np.einsum("nrk,nr->nk", np.abs(programs.A), np.abs(row_dual)) + np.abs(bound_dual)
    if programs.H is not None:
        gradient = gradient + np.einsum("nkl,nl->nk", programs.H, x)
        terms = terms + np.einsum("nkl,nl->nk", np.abs(programs.H), np.abs(x))
    largest = np.max(terms, axis=1)
    stationary = np.max(np.abs(gradient), axis=1) / np.where(largest > 0, largest, 1.0)
    if programs.H is not None:
        stationary = stationary * (OPTIMALITY_TOLERANCE / GRADIENT_TOLERANCE)
    # a multiplier needs its limit; one that is rounding counts nothing
    significant = np.abs(dual) > OPTIMALITY_TOLERANCE * np.max(np.abs(dual), axis=1, keepdims=True, initial=0.0)
    distance = np.abs(np.where(dual > 0, upper - value, value - lower))
    complementary = np.max(np.where(significant, distance, 0.0) / size, axis=1, initial=0.0)
    error: Array = np.maximum(np.maximum(infeasible, stationary), complementary)
    return np.where(np.isfinite(error), error, np.inf)
