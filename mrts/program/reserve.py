# SPDX-License-Identifier: MIT
"""How far from their limits torques and wrenches can be kept: another way to choose the redundant ones.

The quadratic program (31)-(34) asks for the least torques within the limits, so it puts wrenches at theirs even where
something else binds. Here the largest share of any limit that is used is made as small as can be, sample by sample, by
a linear program over the free wrenches and that share; the least torques are chosen among what is left. Where rates
join the samples, it is one quadratic program over the shares of all of them, `of_shares`.
"""

from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.load_box import LoadPoint
from mrts.base.words import first_names
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits import limit_rows
from mrts.limits.rows import ActiveRow, LimitRows, RowLimits, counted_sizes
from mrts.program.infeasibility import least_widening
from mrts.program.motion_rows import MotionRows
from mrts.program.sample_problem import BLOCK, SampleProblem, build_sample_problem
from mrts.program.sample_ranges import BINDING_TOLERANCE
from mrts.program.smooth_program import LEAST_SHARE, whole_sides

ROWS_NAMED = 2
"""Most rows that the text names."""

NO_RESERVE = 1e-9
"""A reserve below this share is none: at the fastest c² rounding leaves some, of the precision of an answer."""


def least_shares(problem: SampleProblem, c2: float) -> tuple[Array, Array]:
    """The least largest share of any limit at each sample, less 1: as a widening, below 0 within the limits.

    Rows that no distribution moves do not count. Where both sides are one number, a row is kept and does not count.
    """
    (lower, upper), moved, sizes = problem.limits_at(c2), problem.moved, problem.counted
    return least_widening(
        problem.free,
        np.where(moved, lower, -np.inf),
        np.where(moved, upper, np.inf),
        sizes,
        solver=problem.solver,
        least=-1.0,
    )


def reserved(problem: SampleProblem, c2: float) -> SampleProblem:
    """The same problem with all limits reduced to the least share of themselves that admits c², or to `LEAST_SHARE`."""
    share = np.maximum(1 + least_shares(problem, c2)[0], LEAST_SHARE)
    low, high = (1 - share)[:, None] * whole_sides(problem.free, problem.counted)
    return replace(problem, lower=problem.lower + low, upper=problem.upper - high)


def given_sizes(cell: Cell, motion: CoordinatedMotion) -> Array:
    """`counted_sizes` of the limits as they are given, whatever reserve the cell keeps, without those of polygons."""
    rows = limit_rows(cell.with_reserve(0.0), motion)
    limits = rows.only(np.array([not name.sides for name in rows.names])).limits
    return counted_sizes(limits.lower, limits.upper, limits.units)


def without_unmoved(problem: SampleProblem) -> SampleProblem:
    """The same problem without the limits that no distribution moves, for a motion that passes some of these."""
    moved = problem.moved
    return replace(problem, lower=np.where(moved, problem.lower, -np.inf), upper=np.where(moved, problem.upper, np.inf))


@dataclass(frozen=True)
class Reserve:
    """By how much limits may shrink before a plan at its c² has no torques within them.

    Attributes:
        share: The largest share that all limits may move inward by, each side of its own size; 0 at the fastest c².
        sample: Where that is.
        time: Time of that sample in the given motion [s].
        rows: Rows at their limit then.
        load: With which load, if the load is uncertain.
        distributed: Reserve of the rows alone that the distribution of the torques moves; None where nothing is free.
    """

    share: float
    sample: int
    time: float
    rows: tuple[ActiveRow, ...]
    load: LoadPoint | None = None
    distributed: "Reserve | None" = None

    def __str__(self) -> str:
        text = f"{100 * self.share:.3g} % of all limits ({self.place()})"
        least = self.distributed
        if least is None or least.share <= self.share:
            return text
        other = f"{100 * least.share:.3g} % of those of torques and wrenches if these are distributed for it"
        return f"{text}, {other} ({least.place()})"

    def place(self) -> str:
        """By which rows, when and with which load it is set, in words."""
        named = [name.short for name in dict.fromkeys(row.name for row in self.rows)]
        by = f"{first_names(named, ROWS_NAMED)} " if named else ""
        return f"{by}at t = {self.time:.4g} s" + ("" if self.load is None else f" with {self.load}")

    def to_json(self) -> dict[str, Any]:
        """Entry "reserve" of the JSON result, and "distributed" in it."""
        entry = {"share": self.share, "time": self.time, "rows": [row.to_json() for row in self.rows]}
        entry |= {} if self.load is None else {"load": self.load.to_json()}
        return entry | {"distributed": self.distributed and self.distributed.to_json()}


def plan_reserve(rows: MotionRows, c2: float, loads: tuple[LoadPoint | None, ...] = (None,)) -> Reserve:
    """By how much the limits of a motion, as they are given, may shrink before c² has no torques for some load."""
    whole: list[Reserve] = []
    distributed: list[Reserve] = []
    for load in loads:
        for start in range(0, rows.motion.samples, BLOCK):
            block = np.arange(start, min(start + BLOCK, rows.motion.samples))
            problem = build_sample_problem(rows, load=None if load is None else load.load, samples=block)
            given, time = rows.given.at(block), rows.motion.object.time
            shares = _shares_unmoved(problem, given, c2)
            if problem.unknowns > 1:
                at_best = _shares_moved(*least_shares(problem, c2))
                distributed.append(_reserve(given.limits, at_best, time, start, load))
                shares = np.maximum(shares, at_best)
            whole.append(_reserve(given.limits, shares, time, start, load))
    least = attrgetter("share")
    return replace(min(whole, key=least), distributed=min(distributed, key=least, default=None))


def _reserve(given: RowLimits, shares: Array, time: Array, start: int, load: LoadPoint | None) -> Reserve:
    """The reserve that shares of the lower and the upper sides leave, Shape (2, b, r), of samples from `start` on."""
    most = np.max(shares, axis=(0, 2), initial=0.0)
    place = int(np.argmax(most))
    near = (shares[:, place] >= most[place] - BINDING_TOLERANCE) & (shares[:, place] > 0)
    rows = dict.fromkeys(
        ActiveRow.of(given.names[row], given.lower[row], given.upper[row], at_upper=bool(side))
        for row, side in np.argwhere(near.T).tolist()
    )
    left = 1 - float(most[place])
    return Reserve(left if left > NO_RESERVE else 0.0, start + place, float(time[start + place]), tuple(rows), load)


def _shares_moved(share: Array, dual: Array) -> Array:
    """Shares that rows with a multiplier have in every best distribution, minus infinity elsewhere, Shape (2, b, r)."""
    size = np.abs(dual)
    strong = size > BINDING_TOLERANCE * np.max(size, axis=(0, 2), keepdims=True, initial=0.0)
    return np.where(strong, 1 + share[:, None], -np.inf)


def _shares_unmoved(problem: SampleProblem, given: LimitRows, c2: float) -> Array:
    """Shares of rows that no distribution moves, minus infinity elsewhere, Shape (2, b, r); those of the speed in ṙ."""
    sizes, (lower, upper) = problem.counted, problem.limits_at(c2)
    stays = ~problem.moved & (sizes[0] > 0)
    low, high = np.where(sizes > 0, sizes, 1.0)
    shares = np.stack([1 + lower / low, 1 - upper / high])
    limits, of_speed = given.limits, given.limits.is_of_speed
    if np.any(of_speed):
        torque, wrench = (np.zeros((problem.samples, M.shape[1])) for M in (limits.torque_matrix, limits.wrench_matrix))
        value, size = given.value(torque, wrench, 0.0, np.sqrt(c2)), limits.side_sizes()
        at = np.stack([1 - (value - limits.lower) / size[0], 1 - (limits.upper - value) / size[1]])
        shares[:, :, of_speed] = at[:, :, of_speed]
    return np.where(stays, shares, -np.inf)
