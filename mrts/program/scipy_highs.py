# SPDX-License-Identifier: MIT
"""SciPy's HiGHS for linear programs, one at a time: slow and hard to defeat."""

import numpy as np
from scipy.optimize import linprog

from mrts.base.arrays import Array
from mrts.program.convex_program import HIGHS_TOLERANCE


class ScipyHighsSolver:
    """Linear programs through `scipy.optimize.linprog`; quadratic ones get no answer."""

    @staticmethod
    def solve(
        H: Array | None,
        g: Array,
        A: Array,
        lower: Array,
        upper: Array,
        x_lower: Array,
        x_upper: Array,
    ) -> tuple[Array, Array, Array]:
        """Solve a batch; see `mrts.program.convex_program.ConvexPrograms` for the shapes."""
        x, row_dual, bound_dual = np.zeros_like(g), np.zeros_like(lower), np.zeros_like(g)
        if H is not None:
            return x, row_dual, bound_dual
        for sample in range(len(g)):
            has_upper, has_lower = np.isfinite(upper[sample]), np.isfinite(lower[sample])
            solved = linprog(
                g[sample],
                A_ub=np.concatenate([A[sample, has_upper], -A[sample, has_lower]]),
                b_ub=np.concatenate([upper[sample, has_upper], -lower[sample, has_lower]]),
                bounds=list(zip(x_lower[sample].tolist(), x_upper[sample].tolist(), strict=True)),
                method="highs-ds",
                options={
                    "primal_feasibility_tolerance": HIGHS_TOLERANCE,
                    "dual_feasibility_tolerance": HIGHS_TOLERANCE,
                },
            )
            if solved.status != 0:
                continue
            x[sample] = solved.x
            count = int(np.sum(has_upper))
            row_dual[sample, has_upper] -= solved.ineqlin.marginals[:count]
            row_dual[sample, has_lower] += solved.ineqlin.marginals[count:]
            bound_dual[sample] = -(solved.lower.marginals + solved.upper.marginals)
        return x, row_dual, bound_dual
