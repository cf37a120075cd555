# SPDX-License-Identifier: MIT
"""How far from their limits torques and wrenches can be kept: another way to choose the redundant ones.

The quadratic program (31)-(34) asks for the least torques within the limits, so it puts wrenches at theirs even where
something else binds. Here the largest share of any limit that is used is made as small as can be, sample by sample, by
a linear program over the free wrenches and that share; the least torques are chosen among what is left. Where rates
join the samples, it is one quadratic program over the shares of all of them.
"""

from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.load_box import LoadPoint
from mrts.base.words import first_names
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits import limit_rows
from mrts.limits.rows import ActiveRow, LimitRows, RowName, counted_sizes
from mrts.program.infeasibility import least_widening
from mrts.program.motion_rows import MotionRows
from mrts.program.path_solver import KernelSolver
from mrts.program.sample_problem import BLOCK, SampleProblem, build_sample_problem, moved_by
from mrts.program.sample_ranges import BINDING_TOLERANCE
from mrts.program.smooth_program import SmoothProgram

LEAST_SHARE = 0.01
"""Share of a limit that torques may always use: they are not asked to keep more than 99 % of it free."""

SHARE_MARGIN = 1e-5
"""Share of a limit beyond the least that torques within rates may use: the least shares of a whole motion are met by
hardly more than one distribution, in which an interior point finds no inside."""

SHARE = RowName("share of the limits")
"""Name of the row of s."""

OF_SPEED = ("square", "rate", "root", "offset")
"""What of the rows of a path does not depend on the distribution."""

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
    rows = rows.only(np.array([not name.sides for name in rows.names]))
    return counted_sizes(rows.lower, rows.upper, rows.units)


def whole_sides(free: Array, sizes: Array) -> Array:
    """By how much limits move inward of which nothing may be used, Shape (2, N, r); 0 for rows no distribution moves.

    `free` are the columns of what a distribution chooses, Shape (N, r, f), `sizes` from `counted_sizes`.
    """
    return sizes[:, None] * moved_by(free)


def of_shares(program: SmoothProgram) -> SmoothProgram:
    """The program with the largest share s of any limit at each node as the last free unknown, and ∫ s² dt as effort.

    Each node has an s of its own, so that a place that needs all of a limit loosens no other; the square lets a tall
    one count more than a wide one. Each row stands three times: with the limits that do not count and its rate, and
    with each side that counts, of which it may use s. The last row is s itself.
    """
    n, r, _ = program.free.shape
    low, high = whole_sides(program.free, program.sizes)
    least, most, any_rate = np.full((n, r), -np.inf), np.full((n, r), np.inf), np.full(r, np.inf)
    parts = (
        (np.where(low > 0, least, program.lower), np.where(high > 0, most, program.upper), 0 * low, program.change),
        (np.where(low > 0, program.lower + low, least), most, low, any_rate),
        (least, np.where(high > 0, program.upper - high, most), -high, any_rate),
        (np.full((n, 1), LEAST_SHARE), np.ones((n, 1)), np.ones((n, 1)), any_rate[:1]),
    )
    lower, upper, share, change = map(partial(np.concatenate, axis=-1), zip(*parts, strict=True))
    given: dict[str, Any] = {name: np.pad(np.tile(getattr(program, name), 3), ((0, 0), (0, 1))) for name in OF_SPEED}
    free = np.pad(np.tile(program.free, (1, 3, 1)), ((0, 0), (0, 1), (0, 1)))
    free[:, :, -1] = share
    start, end = (None if held is None else np.append(held, 1.0) for held in program.end_free)
    whole = replace(
        program,
        **given,
        free=free,
        lower=lower,
        upper=upper,
        change=change,
        weight=np.append(np.zeros(3 * r), 1.0),
        sizes=np.zeros((2, len(change))),
        names=(*program.names[:r] * 3, SHARE, *program.names[r:]),
        end_free=(start, end),
    )
    return whole.only(np.isfinite(change) | np.any(np.isfinite(lower) | np.isfinite(upper), axis=0))


def reserved_torques(
    program: SmoothProgram, x: Array, u: Array, solver: KernelSolver, shares: Array | None = None
) -> Array | None:
    """F of the least effort at a given timing among those with the least ∫ s² dt of `of_shares`, Shape (n, f).

    Where no rates join the nodes these are the torques of `reserved`; where no share counts, those of the least effort
    alone. None where none keep the limits and the rates. `shares` are s of the least ∫ s² dt where it is known.
    """
    if program.free.shape[2] == 0 or not np.any(program.sizes):
        return solver.torques(program, x, u)
    found = None if shares is not None else solver.torques(of_shares(program), x, u)
    if found is not None:
        shares = found[:, -1]
    if shares is None:
        return None
    low, high = (1 - np.minimum(shares[:, None] + SHARE_MARGIN, 1.0)) * whole_sides(program.free, program.sizes)
    least = solver.torques(replace(program, lower=program.lower + low, upper=program.upper - high), x, u)
    if least is None and found is None:
        return reserved_torques(program, x, u, solver)
    return least if found is None or least is not None else found[:, :-1]


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
                distributed.append(_reserve(given, at_best, time, start, load))
                shares = np.maximum(shares, at_best)
            whole.append(_reserve(given, shares, time, start, load))
    least = attrgetter("share")
    return replace(min(whole, key=least), distributed=min(distributed, key=least, default=None))


def _reserve(given: LimitRows, shares: Array, time: Array, start: int, load: LoadPoint | None) -> Reserve:
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
    of_speed = given.is_of_speed
    if np.any(of_speed):
        torque, wrench = (np.zeros((problem.samples, M.shape[1])) for M in (given.torque_matrix, given.wrench_matrix))
        value, size = given.value(torque, wrench, 0.0, np.sqrt(c2)), given.side_sizes()
        at = np.stack([1 - (value - given.lower) / size[0], 1 - (given.upper - value) / size[1]])
        shares[:, :, of_speed] = at[:, :, of_speed]
    return np.where(stays, shares, -np.inf)
