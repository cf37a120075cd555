# SPDX-License-Identifier: MIT
"""Verified batches of small linear and quadratic programs. A new solver is a function and a line in `SOLVERS`.

A solver's own word is never taken: an answer counts when it passes `optimality_error`, else another solver is asked.
"""

import contextlib
import io
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from mrts.base.arrays import Array, apply, with_part
from mrts.base.errors import InputError, SolverError, check_type
from mrts.kernel.programs import solve_batch

DEFAULT_SOLVER = "kernel"

OPTIMALITY_TOLERANCE = 1e-9
"""Residuals of feasibility, stationarity and complementarity, each relative to the terms that it sums."""

GRADIENT_TOLERANCE = 1e-12
"""The same for the gradient of a quadratic cost, so that torques of small weight are right as well."""

Mask = np.typing.NDArray[np.bool_]


@dataclass(frozen=True)
class ConvexPrograms:
    """N programs: minimise ½ xᵀHx + gᵀx subject to lower <= [A x, x] <= upper.

    Attributes:
        H: Symmetric, positive semidefinite, Shape (N, k, k); None for linear programs.
        g: Shape (N, k).
        A: Shape (N, r, k).
        lower: Of the rows and then of the unknowns, Shape (N, r + k); minus infinity where unbounded.
        upper: Likewise; infinity where unbounded.
    """

    H: Array | None
    g: Array
    A: Array
    lower: Array
    upper: Array

    def at(self, samples: Mask) -> "ConvexPrograms":
        """Some of the programs."""
        return with_part(self, vars(self), samples)

    def scaled(self) -> "tuple[ConvexPrograms, Array, Array]":
        """The same programs with unknowns of the size of the limits: the largest coefficient of each unknown is 1.

        Inequality rows keep their own scale, which is that of their limits; equations are scaled to coefficients of 1.

        Returns:
            The programs, the factors x = column * x_scaled, Shape (N, k), and those of their limits, Shape (N, r + k).
        """
        column, row = scales(self.A, (self.lower == self.upper)[:, : self.A.shape[1]])
        of_limits = np.hstack([row, 1 / column])
        g = self.g * column
        H = None if self.H is None else self.H * column[:, :, None] * column[:, None, :]
        weight = np.max(np.abs(g), axis=1) if H is None else np.max(np.abs(H), axis=(1, 2))
        weight = 1 / np.where(weight > 0, weight, 1.0)
        programs = ConvexPrograms(
            None if H is None else H * weight[:, None, None],
            g * weight[:, None],
            self.A * column[:, None, :] * row[:, :, None],
            *(self.lower * of_limits, self.upper * of_limits),
        )
        return programs, column, of_limits


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


def optimality_error(programs: ConvexPrograms, x: Array, dual: Array) -> Array:
    """Largest residual of the Karush-Kuhn-Tucker conditions of each scaled program, Shape (N,).

    A limit is measured against 1 (its own size) and the terms of its row, the gradient against its largest term: the
    scaled unknowns have the size of the limits, so this bounds the loss of the objective.
    """
    lower, upper, bounds = programs.lower, programs.upper, np.broadcast_to(np.eye(x.shape[1]), (*x.shape, x.shape[1]))
    rows = np.concatenate([programs.A, bounds], axis=1)
    value, size = apply(rows, x), 1 + apply(np.abs(rows), np.abs(x))
    infeasible = np.max(np.maximum(lower - value, value - upper) / size, axis=1, initial=0.0)

    by_row = rows.transpose(0, 2, 1)
    gradient, terms = programs.g + apply(by_row, dual), np.abs(programs.g) + apply(np.abs(by_row), np.abs(dual))
    if programs.H is not None:
        gradient = gradient + apply(programs.H, x)
        terms = terms + apply(np.abs(programs.H), np.abs(x))
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


Found = tuple[Array, Array]
"""Minimisers, Shape (N, k), and multipliers of limits, Shape (N, r + k); anything at all where a solver fails."""


def kernel(programs: ConvexPrograms) -> Found:
    """Our own dense kernel, dual simplex and dual active set methods; see mrts/kernel/c/linear_programs.h."""
    x, dual, _ = solve_batch(programs.H, programs.g, programs.A, programs.lower, programs.upper)
    return x, dual


def qpsol(plugin: str, options: dict[str, Any], programs: ConvexPrograms) -> Found:
    """A solver of CasADi's `qpsol`."""
    import casadi as ca  # noqa: PLC0415 (not needed otherwise)

    count, rows, unknowns = programs.A.shape
    given = {
        "g": programs.g.T,
        "a": programs.A.transpose(1, 0, 2).reshape(rows, count * unknowns),
        "lba": programs.lower.T[:rows],
        "uba": programs.upper.T[:rows],
        "lbx": programs.lower.T[rows:],
        "ubx": programs.upper.T[rows:],
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
            return np.zeros((1, unknowns)), np.zeros((1, rows + unknowns))
        alone = [qpsol(plugin, options, programs.at(np.arange(count) == sample)) for sample in range(count)]
        x, dual = (np.concatenate(part) for part in zip(*alone, strict=True))
        return x, dual
    return solved["x"].full().T, np.vstack([solved["lam_a"].full(), solved["lam_x"].full()]).T


Solver = Callable[[ConvexPrograms], Found]
QPOASES: Solver = partial(qpsol, "qpoases", {"printLevel": "none", "error_on_fail": False})
DAQP: Solver = partial(qpsol, "daqp", {"error_on_fail": False})

SOLVERS: dict[str, Solver] = {"kernel": kernel, "qpsol:qpoases": QPOASES}

FALLBACKS = (kernel, QPOASES, DAQP)
"""Asked in this order for what the chosen solver does not get right. DAQP is no choice by itself: it gets the quadratic
programs that qpOASES leaves."""


def check_solver(name: str) -> None:
    """InputError unless a name is registered."""
    check_type("solver", name, str)
    if name not in SOLVERS:
        raise InputError("solver", f"there is no such solver; there are {', '.join(SOLVERS)}.", value=name)


@dataclass(frozen=True)
class Answers:
    """Minimisers and multipliers of a batch.

    Signs follow Hx + g + [Aᵀ 1] dual = 0 up to a positive factor: a positive multiplier belongs to an upper limit.
    Those that passed `optimality_error` are verified.
    """

    x: Array
    dual: Array
    verified: Mask


def solve_programs(programs: ConvexPrograms, solver: str, *, alone: bool = False) -> Answers:
    """Solve a batch; what the chosen solver does not get right the others are asked for, unless it is alone."""
    check_solver(solver)
    chosen = SOLVERS[solver]
    scaled, column, of_limits = programs.scaled()
    x, dual = np.zeros_like(programs.g), np.zeros_like(programs.lower)
    verified = np.zeros(len(x), dtype=bool)
    for solve in (chosen, *(other for other in FALLBACKS if other is not chosen and not alone)):
        todo = ~verified
        part = scaled.at(todo)
        found = solve(part)
        good = optimality_error(part, *found) <= OPTIMALITY_TOLERANCE
        where = np.flatnonzero(todo)[good]
        x[where], dual[where] = (value[good] for value in found)
        verified[where] = True
        if np.all(verified):
            break
    # multipliers are those of the scaled objective: only their signs and proportions matter
    return Answers(x * column, dual * of_limits, verified)


def require_verified(answers: Answers) -> None:
    """SolverError where no solver could answer, of the first such sample."""
    if not np.all(answers.verified):
        sample = int(np.argmin(answers.verified))
        raise SolverError(
            f"no solver answers the program of sample {sample} to a precision of {OPTIMALITY_TOLERANCE:.0e}. This is a "
            "defect of mrts or of extremely scaled data: please report the cell and the motion."
        )
