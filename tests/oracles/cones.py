# SPDX-License-Identifier: MIT
"""Rows of a cone program, block after block, and Clarabel that solves it."""

from dataclasses import dataclass, field
from typing import Any

import clarabel
import numpy as np
from scipy import sparse

from mrts.base.arrays import Array

GAP = 1e-9
"""Gap and residuals at which Clarabel stops."""

REGULAR = 1e-8
"""What Clarabel adds to its pivots by default."""

SOLVED = {"Solved", "AlmostSolved"}
"""Statuses with an answer; whether it is one is for the caller to check."""


def entries(shape: tuple[int, int], *parts: tuple[Any, Any, Array]) -> sparse.csr_array:
    """A sparse matrix of rows, columns and values, each of any shape that fits the values'.

    Args:
        shape: Of the matrix.
        *parts: Rows, columns, values; entries at one place add up.
    """
    found = [[np.broadcast_to(one, np.shape(part[2])).ravel() for one in part] for part in parts]
    rows, columns, values = (np.concatenate([one[place] for one in found]) for place in range(3))
    return sparse.csr_array((values, (rows.astype(int), columns.astype(int))), shape=shape)


@dataclass
class Cones:
    """The rows of a program over z."""

    _matrices: list[sparse.csr_array] = field(default_factory=list)
    _limits: list[Array] = field(default_factory=list)
    _cones: list[Any] = field(default_factory=list)

    def equal(self, A: sparse.csr_array, b: Array) -> None:
        """Rows A z = b."""
        self._add(A, b, [clarabel.ZeroConeT(len(b))])

    def most(self, A: sparse.csr_array, b: Array) -> None:
        """Rows A z <= b, those without a limit left out."""
        kept = np.flatnonzero(np.isfinite(b))
        if kept.size:
            self._add(A[kept], b[kept], [clarabel.NonnegativeConeT(len(kept))])

    def products(
        self, first: sparse.csr_array, second: sparse.csr_array, roots: list[tuple[sparse.csr_array, Array]]
    ) -> None:
        """Rows (first z) (second z) >= the sum of (root z + constant)² over the roots.

        Args:
            first: Shape (k, unknowns).
            second: Likewise.
            roots: Matrices and constants, Shape (k, unknowns) and (k,).
        """
        count, size = first.shape[0], 2 + len(roots)
        stacked = sparse.vstack([first + second, first - second, *(2 * root for root, _ in roots)]).tocsr()
        constants = np.concatenate([np.zeros(2 * count), *(2 * constant for _, constant in roots)])
        order = np.arange(count * size).reshape(size, count).T.ravel()
        self._add(-stacked[order], constants[order], [clarabel.SecondOrderConeT(size)] * count)

    def roots(self, squares: sparse.csr_array, roots: sparse.csr_array) -> None:
        """Rows (squares z) >= (roots z)².

        Args:
            squares: Shape (k, unknowns).
            roots: Likewise.
        """
        count = squares.shape[0]
        order = np.arange(3 * count).reshape(3, count).T.ravel()
        stacked = sparse.vstack([squares, squares, 2 * roots]).tocsr()
        constants = np.concatenate([np.ones(count), -np.ones(count), np.zeros(count)])
        self._add(-stacked[order], constants[order], [clarabel.SecondOrderConeT(3)] * count)

    def solved(self, P: sparse.csc_array, q: Array, regular: float = REGULAR) -> Array | None:
        """The z of the least ½ zᵀPz + qᵀz, Shape (unknowns,); None if none was found.

        Args:
            P: Shape (unknowns, unknowns).
            q: Shape (unknowns,).
            regular: What Clarabel adds to its pivots.
        """
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = GAP
        settings.static_regularization_constant = regular
        A = sparse.csc_matrix(sparse.vstack(self._matrices))
        limits = np.concatenate(self._limits)
        answer = clarabel.DefaultSolver(sparse.csc_matrix(P), q, A, limits, self._cones, settings).solve()
        return np.asarray(answer.x) if str(answer.status) in SOLVED else None

    def _add(self, A: sparse.csr_array, b: Array, cones: list[Any]) -> None:
        self._matrices.append(A)
        self._limits.append(b)
        self._cones.extend(cones)
