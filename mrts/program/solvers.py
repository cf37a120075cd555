# SPDX-License-Identifier: MIT
"""Verified batches of linear and quadratic programs. A new solver is a function and a line in `SOLVERS`.

A solver's own word is never taken: an answer counts when it passes `optimality_error`, else another solver is asked.
"""

import contextlib
import io
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mrts.base.argument_types import check_type
from mrts.base.arrays import Array
from mrts.base.errors import InputError, SolverError
from mrts.kernel.programs import default_programs
from mrts.program.convex_program import (
    HIGHS_TOLERANCE,
    OPTIMALITY_TOLERANCE,
    ConvexPrograms,
    Mask,
    optimality_error,
)
from mrts.program.motion_rows import MotionRows

DEFAULT_SOLVER = "kernel"

Found = tuple[Array, Array, Array]
"""Minimisers, row multipliers and bound multipliers of a batch; anything at all where a solver fails."""


def kernel(programs: ConvexPrograms) -> Found:
    """Our own dense kernel, dual simplex and dual active set methods; see mrts/kernel/c/linear_programs.h."""
    solved, rows = default_programs(), programs.A.shape[1]
    low = np.concatenate([programs.lower, programs.x_lower], axis=1)
    high = np.concatenate([programs.upper, programs.x_upper], axis=1)
    if programs.H is None:
        x, dual, _ = solved.linear_programs(programs.g, programs.A, low, high)
    else:
        x, dual, _ = solved.quadratic_programs(programs.H, programs.g, programs.A, low, high)
    return x, dual[:, :rows], dual[:, rows:]


def qpoases(programs: ConvexPrograms) -> Found:
    """QpOASES by CasADi's `qpsol`."""
    return _qpsol("qpoases", {"printLevel": "none", "error_on_fail": False}, programs)


def daqp(programs: ConvexPrograms) -> Found:
    """DAQP by CasADi's `qpsol`, of quadratic programs alone."""
    return _qpsol("daqp", {"error_on_fail": False}, programs)


def _qpsol(plugin: str, options: dict[str, Any], programs: ConvexPrograms) -> Found:
    import casadi as ca  # noqa: PLC0415 (not needed otherwise)

    count, rows, unknowns = programs.A.shape
    given = {
        "g": programs.g.T,
        "a": programs.A.transpose(1, 0, 2).reshape(rows, count * unknowns),
        "lba": programs.lower.T,
        "uba": programs.upper.T,
        "lbx": programs.x_lower.T,
        "ubx": programs.x_upper.T,
    }
    hessian = ca.Sparsity(unknowns, unknowns)
    if programs.H is not None:
        given["h"] = programs.H.transpose(1, 0, 2).reshape(unknowns, count * unknowns)
        hessian = ca.Sparsity.dense(unknowns, unknowns)
    structure = {"a": ca.Sparsity.dense(rows, unknowns), "h": hessian}
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # qpOASES greets whatever its print level
            solver = ca.conic("program", plugin, structure, options)
            solved = solver.map(count)(**{name: ca.DM(value) for name, value in given.items()})
    except RuntimeError:
        # one failure fails the whole map, and qpOASES does not recover from it: each sample gets a new solver
        if count == 1:
            return np.zeros((1, unknowns)), np.zeros((1, rows)), np.zeros((1, unknowns))
        alone = [_qpsol(plugin, options, programs.at(np.arange(count) == sample)) for sample in range(count)]
        x, row_dual, bound_dual = (np.concatenate(part) for part in zip(*alone, strict=True))
        return x, row_dual, bound_dual
    return solved["x"].full().T, solved["lam_a"].full().T, solved["lam_x"].full().T


def scipy_highs(programs: ConvexPrograms) -> Found:
    """SciPy's HiGHS for linear programs, one at a time: slow and hard to defeat; quadratic ones get no answer."""
    from scipy.optimize import linprog  # noqa: PLC0415 (not needed otherwise)

    g, A, lower, upper = programs.g, programs.A, programs.lower, programs.upper
    x, row_dual, bound_dual = np.zeros_like(g), np.zeros_like(lower), np.zeros_like(g)
    for sample in range(0 if programs.H is not None else len(g)):
        has_upper, has_lower = np.isfinite(upper[sample]), np.isfinite(lower[sample])
        solved = linprog(
            g[sample],
            A_ub=np.concatenate([A[sample, has_upper], -A[sample, has_lower]]),
            b_ub=np.concatenate([upper[sample, has_upper], -lower[sample, has_lower]]),
            bounds=np.column_stack([programs.x_lower[sample], programs.x_upper[sample]]).tolist(),
            method="highs-ds",
            options={"primal_feasibility_tolerance": HIGHS_TOLERANCE, "dual_feasibility_tolerance": HIGHS_TOLERANCE},
        )
        if solved.status != 0:
            continue
        x[sample] = solved.x
        count = int(np.sum(has_upper))
        row_dual[sample, has_upper] -= solved.ineqlin.marginals[:count]
        row_dual[sample, has_lower] += solved.ineqlin.marginals[count:]
        bound_dual[sample] = -(solved.lower.marginals + solved.upper.marginals)
    return x, row_dual, bound_dual


SOLVERS: dict[str, Callable[[ConvexPrograms], Found]] = {
    "kernel": kernel,
    "qpsol:qpoases": qpoases,
    "scipy:highs": scipy_highs,
}

FALLBACKS = (scipy_highs, qpoases, daqp)
"""Asked in this order for what the chosen solver does not get right; between them they solve both kinds. DAQP is no
choice by itself: it gets the quadratic programs that qpOASES leaves."""


def check_solver(name: str) -> None:
    """Check a registered name."""
    check_type("solver", name, str)
    if name not in SOLVERS:
        raise InputError("solver", f"there is no such solver; there are {', '.join(SOLVERS)}.", value=name)


MOST_ROWS = 32_767
"""The compiled path keeps the rows of each sample's answer as 16-bit numbers."""


def takes_kernel(rows: MotionRows, solver: str) -> bool:
    """Whether the programs of a motion are those that the compiled path has."""
    few = len(rows.kept.names) + rows.cell.library.unknowns <= MOST_ROWS
    free = rows.formulation == "wrench" and rows.sharing is None
    return solver == "kernel" and free and rows.sparse is not None and few


@dataclass(frozen=True)
class Answers:
    """Minimisers and multipliers of a batch.

    Signs follow Hx + g + Aᵀ row_dual + bound_dual = 0 up to a positive factor: a positive multiplier belongs to an
    upper limit.

    Attributes:
        x: Shape (N, k).
        row_dual: Shape (N, r).
        bound_dual: Shape (N, k).
        verified: Which answers passed `optimality_error`, Shape (N,).
        fallbacks: How many of them the first solver did not get.
    """

    x: Array
    row_dual: Array
    bound_dual: Array
    verified: Mask
    fallbacks: int


def solve_programs(programs: ConvexPrograms, solver: str, *, alone: bool = False) -> Answers:
    """Solve a batch; what the chosen solver does not get right the others are asked for, unless it is alone."""
    check_solver(solver)
    chosen = SOLVERS[solver]
    scaled, column, row = programs.scaled()
    count, rows, unknowns = programs.A.shape
    x, row_dual = np.zeros((count, unknowns)), np.zeros((count, rows))
    bound_dual, verified = np.zeros((count, unknowns)), np.zeros(count, dtype=bool)
    fallbacks = 0
    for solve in (chosen, *(other for other in FALLBACKS if other is not chosen and not alone)):
        todo = ~verified
        part = scaled.at(todo)
        found = solve(part)
        good = optimality_error(part, *found) <= OPTIMALITY_TOLERANCE
        where = np.flatnonzero(todo)[good]
        x[where], row_dual[where], bound_dual[where] = (value[good] for value in found)
        verified[where] = True
        fallbacks += 0 if solve is chosen else len(where)
        if np.all(verified):
            break
    # multipliers are those of the scaled objective: only their signs and proportions matter
    return Answers(x * column, row_dual * row, bound_dual / column, verified, fallbacks)


def require_verified(answers: Answers, what: str) -> None:
    """Raise where no solver could answer.

    Raises:
        SolverError: Names the first such sample.
    """
    if not np.all(answers.verified):
        sample = int(np.argmin(answers.verified))
        raise SolverError(
            f"no solver found {what} at sample {sample} to a precision of {OPTIMALITY_TOLERANCE:.0e}. This is a defect "
            "of mrts or of extremely scaled data: please report the cell and the motion."
        )
