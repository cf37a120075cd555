# SPDX-License-Identifier: MIT
"""qpOASES and DAQP by CasADi's `qpsol`, through `conic`: its interface for programs given by matrices."""

import contextlib
import io
from typing import Any

import casadi as ca
import numpy as np

from mrts.base.arrays import Array

OPTIONS: dict[str, dict[str, Any]] = {
    "qpoases": {"printLevel": "none", "error_on_fail": False},
    "daqp": {"error_on_fail": False},
}
"""By plugin: qpoases solves both kinds of program, daqp quadratic ones only."""


class QpsolSolver:
    """One plugin; a whole batch is one call of a mapped solver.

    Args:
        plugin: Key of `OPTIONS`.
    """

    def __init__(self, plugin: str) -> None:
        self.plugin = plugin

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
        count, rows, unknowns = A.shape
        arguments: dict[str, Array] = {
            "g": g.T,
            "a": A.transpose(1, 0, 2).reshape(rows, count * unknowns),
            "lba": lower.T,
            "uba": upper.T,
            "lbx": x_lower.T,
            "ubx": x_upper.T,
        }
        if H is not None:
            arguments["h"] = H.transpose(1, 0, 2).reshape(unknowns, count * unknowns)
        try:
            solved = self._call(count, rows, unknowns, arguments, quadratic=H is not None)
        except RuntimeError:
            # one failure fails the whole map, and qpOASES does not recover from it: each sample gets a new solver
            if count == 1:
                return np.zeros((1, unknowns)), np.zeros((1, rows)), np.zeros((1, unknowns))
            return self._one_by_one(H, g, A, lower, upper, x_lower, x_upper)
        return solved["x"].full().T, solved["lam_a"].full().T, solved["lam_x"].full().T

    def _call(
        self, count: int, rows: int, unknowns: int, arguments: dict[str, Array], *, quadratic: bool
    ) -> dict[str, Any]:
        hessian = ca.Sparsity.dense(unknowns, unknowns) if quadratic else ca.Sparsity(unknowns, unknowns)
        structure = {"a": ca.Sparsity.dense(rows, unknowns), "h": hessian}
        # qpOASES greets on standard output whatever its print level
        with contextlib.redirect_stdout(io.StringIO()):
            solver = ca.conic("program", self.plugin, structure, OPTIONS[self.plugin])
            solved: dict[str, Any] = solver.map(count)(
                **{name: ca.DM(argument) for name, argument in arguments.items()}
            )
        return solved

    def _one_by_one(self, H: Array | None, *batch: Array) -> tuple[Array, Array, Array]:
        pieces = [
            self.solve(None if H is None else H[i : i + 1], *(value[i : i + 1] for value in batch))
            for i in range(batch[0].shape[0])
        ]
        x, row_dual, bound_dual = zip(*pieces, strict=True)
        return np.concatenate(x), np.concatenate(row_dual), np.concatenate(bound_dual)
