# SPDX-License-Identifier: MIT
"""What limits of rates leave of constant factors c: one linear program a factor, which rules out all around it.

At a constant factor x = c² and u = 0, and between two nodes a time h w passes, with w = 1 / c. With γ = c², the rows

    lower <= free F + square γ + root c + offset <= upper,     |v_{k+1} - v_k| <= change h w

are convex in (F, γ, c, w). The least w at given γ and c is a linear program over all nodes, whose multipliers give a
line w >= start + a γ + b c that every admissible factor keeps. So a factor that is not admissible rules out all around
it, up to where 1 / c meets that line.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import sparse
from scipy.optimize import OptimizeResult, linprog

from mrts.base.arrays import Array
from mrts.base.errors import SolverError
from mrts.program.convex_program import HIGHS_TOLERANCE
from mrts.program.smooth_program import SmoothProgram
from mrts.program.torque_distribution import TORQUE_WIDENING

RATE_MARGIN = 1e-8
"""Share of a rate: factors keep three of it free, less one for rounding, so that torques are more than one point."""

SPREAD = 100.0
"""Share up to which changes stand as shares of what is allowed: beyond, the program counts in larger units."""

REAL_ROOT = 1e-6
"""Share of a root that may be imaginary by rounding: two that coincide are found to half of all digits."""


@dataclass(frozen=True)
class FactorAsked:
    """The least w at one factor.

    Attributes:
        c: The factor.
        share: The least w as a share of 1 / c: at most 1 if the rates admit it.
        line: How that grows with c² and with c.
        rows: Multipliers of the rows at their upper and their lower limits, Shape (2, n, r).
        changes: Multipliers of changes upward and downward, Shape (2, n - 1, number of limited rows).
    """

    c: float
    share: float
    line: tuple[float, float]
    rows: Array
    changes: Array

    @property
    def is_admitted(self) -> bool:
        """Whether the rates admit the factor."""
        return self.share <= 1 + RATE_MARGIN

    def next(self, *, faster: bool) -> float:
        """The nearest factor that is not ruled out by this one: below it or, if faster, above; 0 or infinity if none.

        With ρ for the ratio of the two, the line is met where 1/ρ = share + a (ρ² - 1) + b (ρ - 1).
        """
        a, b = self.line[0] * self.c**2, self.line[1] * self.c
        roots = np.roots([a, b, self.share - a - b, -1.0])
        real = roots.real[np.abs(roots.imag) <= REAL_ROOT * np.abs(roots)]
        if faster:
            return self.c * float(np.min(real[real > 1], initial=np.inf))
        return self.c * float(np.max(real[(real > 0) & (real < 1)], initial=0.0))


class FactorProgram:
    """The linear program over z = [F, share].

    Args:
        program: The rows of a motion, its time for σ.
    """

    def __init__(self, program: SmoothProgram) -> None:
        n, r, f = program.free.shape
        self.program = program
        self.limited = np.flatnonzero(np.isfinite(program.change))
        self.allowed = np.outer(program.step, program.change[self.limited] * (1 - 3 * RATE_MARGIN))
        node, places = np.arange(n)[:, None, None], np.arange(n * r).reshape(n, r)
        largest = np.max(np.abs(program.free), axis=(0, 1))
        scaled = program.free / np.where(largest > 0, largest, 1.0)  # HiGHS drops what is below 1e-9
        entries = np.nonzero(scaled)
        columns = np.broadcast_to(node * f + np.arange(f), program.free.shape)[entries]
        rows = np.broadcast_to(places[:, :, None], program.free.shape)[entries]
        self._values = sparse.csr_array((scaled[entries], (rows, columns)), shape=(n * r, n * f + 1))
        here = places[:-1, self.limited].ravel()
        by_share = sparse.diags_array(1 / self.allowed.ravel())
        self._changes = by_share @ (self._values[here + r] - self._values[here])
        count = len(here)
        last = np.full(count, n * f)
        self._share = sparse.csr_array((np.ones(count), (np.arange(count), last)), shape=(count, n * f + 1))
        self._widening = np.where(program.lower < program.upper, TORQUE_WIDENING, 0.0)

    def asked(self, c: float) -> FactorAsked:
        """The least w at a factor that the rows admit.

        Args:
            c: The factor.

        Raises:
            SolverError: If HiGHS finds no answer.
        """
        program = self.program
        n, r, f = program.free.shape
        fixed = program.square * c**2 + program.root * c + program.offset
        upper, lower = (
            (program.upper + self._widening - fixed).ravel(),
            (program.lower - self._widening - fixed).ravel(),
        )
        above, below = np.isfinite(upper), np.isfinite(lower)
        moved = (c / self.allowed * np.diff(fixed[:, self.limited], axis=0)).ravel()
        unit = max(1.0, float(np.max(np.abs(moved))) / SPREAD)
        moved, changes = moved / unit, (c / unit) * self._changes
        found = _solved(
            np.append(np.zeros(n * f), 1.0),
            sparse.vstack([self._values[above], -self._values[below], changes - self._share, -changes - self._share]),
            np.concatenate([upper[above], -lower[below], -moved, moved]),
        )
        if found.status != 0:
            raise SolverError(f"what the rates admit at c = {c:.6g} was not found; HiGHS: {found.message}")
        rows = np.zeros((2, n * r))
        parts = np.split(-found.ineqlin.marginals, np.cumsum([above.sum(), below.sum(), len(moved)]))
        rows[0, above], rows[1, below] = parts[:2]
        by_side, by_change = unit * rows.reshape(2, n, r), np.stack(parts[2:]).reshape(2, *self.allowed.shape)
        line = (self._growth(program.square, c, by_side, by_change), self._growth(program.root, c, by_side, by_change))
        return FactorAsked(c, unit * float(found.fun), line, by_side, by_change)

    def _growth(self, of: Array, c: float, rows: Array, changes: Array) -> float:
        """How the share grows with what multiplies a column of the rows, by the multipliers."""
        by_rows = np.sum((rows[0] - rows[1]) * of)
        moved = c / self.allowed * np.diff(of[:, self.limited], axis=0)
        return float(by_rows + np.sum((changes[0] - changes[1]) * moved))


def _solved(cost: Array, A: sparse.csr_array, b: Array) -> OptimizeResult:
    """The z of least cost with A z <= b and its last >= 0, by HiGHS: by its interior point first, which is faster."""
    ask = partial(
        linprog,
        cost,
        A_ub=A,
        b_ub=b,
        bounds=[(None, None)] * (len(cost) - 1) + [(0.0, None)],
        options={"primal_feasibility_tolerance": HIGHS_TOLERANCE, "dual_feasibility_tolerance": HIGHS_TOLERANCE},
    )
    found = ask(method="highs-ipm")
    return found if found.status == 0 else ask(method="highs-ds")
