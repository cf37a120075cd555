# SPDX-License-Identifier: MIT
"""The constant factors at which torques, wrenches and accelerations change at limited rates, exactly, and torques."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import SolverError
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import ActiveRow, RowName
from mrts.program.factor_program import RATE_MARGIN, FactorAsked, FactorProgram
from mrts.program.load_sharing import LoadSharing
from mrts.program.path_program import path_program
from mrts.program.path_solver import KernelSolver
from mrts.program.rate_limits import RateLimits, rate_names
from mrts.program.sample_problem import build_sample_problem
from mrts.program.smooth_program import SmoothProgram
from mrts.program.torque_distribution import TORQUE_WIDENING

FELT = 1e-6
"""Share of the largest multiplier from which on a limit is told to bind."""

MOST_CUTS = 200
"""Factors that are asked about; each rules out a whole interval, and fewer than ten are usual."""

FASTER = 4.0
"""Where nothing but rates limits the speed, factors are asked about in turn, each so many times as large."""

MOST_FASTER = 10
"""How many: up to a million times the speed that is given."""


@dataclass(frozen=True)
class RatesAtEnd:
    """What binds at an end of the factors that rates admit.

    Attributes:
        c2: c² of the end.
        sample: Where.
        rows: What binds there.
        load: Which of the loads binds; None of a jerk, which no load moves.
    """

    c2: float
    sample: int
    rows: tuple[ActiveRow, ...]
    load: int | None


class RatedFactors:
    """Constant factors of a motion within limits of rates, for all of some loads at once.

    Args:
        cell: The cell.
        motion: Its motion.
        loads: Load vectors, Shape (10,) each; None for the cell's.
        sharing: A fixed distribution of the load.
        rates: The limits.
    """

    def __init__(
        self,
        cell: Cell,
        motion: CoordinatedMotion,
        loads: Sequence[Array | None],
        sharing: LoadSharing | None,
        rates: RateLimits,
    ) -> None:
        self.cell, self.rates = cell, rates
        self.problems = [build_sample_problem(cell, motion, sharing=sharing, load=load, varying=True) for load in loads]
        self.program = path_program(cell, motion, self.problems, rates)
        self.by_jerk = self._end_by_jerk()
        changes = FactorProgram(self.program)
        self.changes = changes if changes.limited.size else None

    def fastest(self, lower: float, upper: float) -> tuple[float, RatesAtEnd | None]:
        """The largest c² that rates admit, and what binds there; `upper` and None if they do not bind.

        Args:
            lower: Least c² that all other limits admit.
            upper: Largest one that they admit, with all between the two; may be infinity.

        Returns:
            Less than `lower` if rates admit nothing of it: then the largest beneath it that they do not rule out.

        Raises:
            SolverError: If HiGHS finds no answer.
        """
        end = self.by_jerk if self.by_jerk is not None and self.by_jerk.c2 < upper else None
        c2 = upper if end is None else end.c2
        if self.changes is not None and not np.isfinite(c2):
            c2 = self._ruled_out(lower)
        if self.changes is None or not np.isfinite(c2) or c2 < lower:
            return c2, end
        if c2 > 0 and self._carried(c2):
            return c2, end
        found = self._followed(c2, (lower, np.inf), faster=False)
        return (c2, end) if found is None else (found.c2, found)

    def slowest(self, lower: float, upper: float) -> tuple[float, RatesAtEnd | None]:
        """The least c² that rates admit, likewise: `lower` and None if they do not bind, above `upper` if none is.

        Args:
            lower: As in `fastest`.
            upper: Likewise.

        Raises:
            SolverError: If HiGHS finds no answer.
        """
        if self.changes is None or lower <= 0:  # however slowly it may be played, nothing changes fast
            return lower, None
        found = self._followed(lower, (0.0, upper), faster=True)
        return (lower, None) if found is None else (found.c2, found)

    def refused(self, c2: float) -> RatesAtEnd | None:
        """What binds where rates do not admit a c² > 0 that all other limits admit; None if they admit it.

        Args:
            c2: The c².

        Raises:
            SolverError: If HiGHS finds no answer.
        """
        if self.by_jerk is not None and c2 > self.by_jerk.c2 * (1 + RATE_MARGIN):
            return self.by_jerk
        if self._carried(c2):
            return None
        asked = None if self.changes is None else self.changes.asked(float(np.sqrt(c2)))
        return None if asked is None or asked.is_admitted else self._binding(asked)

    def _carried(self, c2: float) -> bool:
        """Whether torques within the rates are found at a c² > 0: much sooner than by HiGHS, but no proof if not."""
        square, nothing = np.full(self.program.nodes, c2), np.zeros(self.program.nodes)
        program = _with_margins(self.program)
        free = KernelSolver().torques(program, square, nothing)
        return free is not None and program.excess(square, nothing, free) <= RATE_MARGIN

    def _followed(self, c2: float, within: tuple[float, float], *, faster: bool) -> RatesAtEnd | None:
        """The first c² from a given one on that rates admit, or the first not ruled out beyond what is of interest."""
        assert self.changes is not None  # noqa: S101 (checked by every caller)
        c, refusing = float(np.sqrt(c2)), None
        for _ in range(MOST_CUTS):
            if refusing is not None and not within[0] <= c * c <= within[1]:
                return replace(self._binding(refusing), c2=c * c)
            asked = self.changes.asked(c)
            if asked.is_admitted:
                return None if refusing is None else self._binding(asked)
            c, refusing = asked.next(faster=faster), asked
        raise SolverError(f"the factors within the rates were not found by {MOST_CUTS} linear programs.")

    def _ruled_out(self, lower: float) -> float:
        """A c² that rates rule out where nothing else limits it; infinity if there is none."""
        assert self.changes is not None  # noqa: S101 (checked by every caller)
        c = max(1.0, float(np.sqrt(lower)))
        for _ in range(MOST_FASTER):
            if not self.changes.asked(c).is_admitted:
                return c * c
            c *= FASTER
        return float(np.inf)

    def _end_by_jerk(self) -> RatesAtEnd | None:
        """The largest c² by c³ |q'''| <= jerk; None if no jerk is limited, or there is none."""
        third, most = self.program.q3, self.program.jerk
        share = np.abs(third) / most
        if not np.any(share > 0):
            return None
        segment, end, place = (int(one) for one in np.unravel_index(np.argmax(share), share.shape))
        names = rate_names(self.cell)[2]
        name = names[np.flatnonzero(np.isfinite(self.rates.jerk))[place]]
        row = _at_limit(name, most[place], rises=bool(third[segment, end, place] > 0))
        return RatesAtEnd(float(share[segment, end, place] ** (-2 / 3)), segment + end, (row,), None)

    def _binding(self, asked: FactorAsked) -> RatesAtEnd:
        """The rates of the segment that matters most, and the limits that bind at its ends."""
        assert self.changes is not None  # noqa: S101 (checked by every caller)
        weight = np.sum(asked.changes, axis=0)
        segment, place = (int(one) for one in np.unravel_index(np.argmax(weight), weight.shape))
        rows_each = self.program.square.shape[1] // len(self.problems)
        load = int(self.changes.limited[place]) // rows_each
        problem, first = self.problems[load], load * rows_each
        least = FELT * max(float(np.max(asked.rows)), float(np.max(weight)))
        at_ends = np.max(asked.rows[:, segment : segment + 2, first : first + len(problem.names)], axis=1)
        rates = [
            self._rate(int(self.changes.limited[place]), rises=side == 0)
            for side, place in np.argwhere(asked.changes[:, segment] > least).tolist()
        ]
        limits = [problem.active_row(row, upper=side == 0) for side, row in np.argwhere(at_ends > least).tolist()]
        return RatesAtEnd(asked.c**2, segment, (*dict.fromkeys((*rates, *limits)),), load)

    def _rate(self, row: int, *, rises: bool) -> ActiveRow:
        """The limit of how fast a row of the program changes."""
        torques, wrenches, _ = rate_names(self.cell)
        limits = (*self.rates.torque.tolist(), *self.rates.wrench.tolist())
        known = {str(name): (name, limit) for name, limit in zip((*torques, *wrenches), limits, strict=True)}
        text = f"{self.program.names[row]} rate"  # a contact in base axes may stand for a wrench component
        name, limit = known.get(text, (RowName(text, unit="/s"), float(self.program.change[row])))
        return _at_limit(name, limit, rises=rises)


def torques_within_rates(
    cell: Cell, motion: CoordinatedMotion, sharing: LoadSharing | None, rates: RateLimits, c2: float, weights: Array
) -> tuple[Array, Array]:
    """Torques of least ∫ τᵀWτ dt over the motion that keep limits and rates at a constant factor.

    Args:
        cell: The cell.
        motion: Its motion.
        sharing: A fixed distribution of the load.
        rates: The limits of rates.
        c2: c², which they admit.
        weights: W, Shape (m, m).

    Returns:
        Torques, Shape (N, m) [N m], and wrenches, Shape (N, n w) [N, N m].

    Raises:
        SolverError: If no solver answers.
    """
    problem = build_sample_problem(cell, motion, sharing=sharing, varying=True)
    program = _with_margins(path_program(cell, motion, [problem], rates, weights))
    square, nothing = np.full(motion.samples, c2), np.zeros(motion.samples)
    free = KernelSolver().torques(program, square, nothing)
    if free is None:
        raise SolverError(f"no torques within the limits and the rates were found at c² = {c2:.6g}.")
    x = np.column_stack([free, nothing, square])
    return problem.torque(x), problem.wrench(x)


def _with_margins(program: SmoothProgram) -> SmoothProgram:
    """The same program with limits a little wider, as that of the torques without rates, and rates a little less."""
    widening = np.where(program.lower < program.upper, TORQUE_WIDENING, 0.0)
    return replace(
        program,
        lower=program.lower - widening,
        upper=program.upper + widening,
        change=program.change * (1 - RATE_MARGIN / 2),
        jerk=program.jerk * (1 + RATE_MARGIN),
    )


def _at_limit(name: RowName, limit: float, *, rises: bool) -> ActiveRow:
    return ActiveRow(name, "upper" if rises else "lower", float(limit if rises else -limit))
