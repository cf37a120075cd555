# SPDX-License-Identifier: MIT
"""Our own dense kernel for any batch of programs; see mrts/kernel/c/linear_programs.h."""

import numpy as np

from mrts.base.arrays import Array
from mrts.kernel.programs import default_programs


class KernelSolver:
    """Linear programs by the bounded dual simplex method, quadratic ones by a dual active set method."""

    def __init__(self) -> None:
        self._programs = default_programs()

    def solve(
        self,
        H: Array | None,
        g: Array,
        A: Array,
        lower: Array,
        upper: Array,
        x_lower: Array,
        x_upper: Array,
    ) -> tuple[Array, Array, Array]:
        """Solve a batch; see `mrts.program.convex_program.ConvexPrograms` for the shapes."""
        rows = A.shape[1]
        low, high = np.concatenate([lower, x_lower], axis=1), np.concatenate([upper, x_upper], axis=1)
        if H is None:
            x, dual, _ = self._programs.linear_programs(g, A, low, high)
        else:
            x, dual, _ = self._programs.quadratic_programs(H, g, A, low, high)
        return x, dual[:, :rows], dual[:, rows:]
