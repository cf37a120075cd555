# SPDX-License-Identifier: MIT
"""The constant factors at which torques, wrenches and accelerations change at limited rates, exactly, and torques.

At a constant factor x = c² and u = 0, and between two nodes a time h w passes, with w = 1 / c. With γ = c², the rows

    lower <= free F + square γ + root c + offset <= upper,     |v_{k+1} - v_k| <= change h w

are convex in (F, γ, c, w). The least w at given γ and c is a linear program over all nodes, for each load by itself,
whose multipliers give a line w >= start + a γ + b c that every admissible factor keeps. So a factor that is not
admissible rules out all around it, up to where 1 / c meets that line.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import SolverError
from mrts.base.load_box import LoadPoint
from mrts.limits.rows import ActiveRow, RowName
from mrts.program.formulation import DistributionName
from mrts.program.motion_rows import MotionRows
from mrts.program.path_solver import KernelSolver
from mrts.program.rate_limits import RateLimits, rate_names
from mrts.program.reserve import given_sizes
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import RangeStatus
from mrts.program.smooth_program import SmoothProgram, path_program, third_derivatives, without_polygons
from mrts.program.torque_distribution import TORQUE_WIDENING
from mrts.scaling.range import RangeEnd, ScalingRange, range_between
from mrts.scaling.remarks import STILL

RATE_MARGIN = 1e-6
"""Share of a rate: factors keep three of it free, less one for rounding, so that torques are more than one point. With
1e-8 an interior point found none for the shipped UR5s within rates of a whole limit per second."""

REAL_ROOT = 1e-6
"""Share of a root that may be imaginary by rounding: two that coincide are found to half of all digits."""

FELT = 1e-6
"""Share of the largest multiplier from which on a limit is told to bind."""

MOST_CUTS = 200
"""Factors that are asked about; each rules out a whole interval, and fewer than ten are usual."""

FASTER = 4.0
"""Where nothing but rates limits the speed, factors are asked about in turn, each so many times as large."""

FASTEST = 1e6
"""The largest of them."""


@dataclass(frozen=True)
class FactorAsked:
    """The least w at one factor, of the load that takes the largest.

    Attributes:
        load: Its place among the loads.
        c: The factor.
        share: The least w as a share of 1 / c: at most 1 if the rates admit it.
        line: How that grows with c² and with c.
        rows: Multipliers of the rows at their upper and their lower limits, Shape (2, n, r).
        changes: Multipliers of changes upward and downward, Shape (2, n - 1, number of limited rows).
    """

    load: int
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


class RatedFactors:
    """Constant factors of a motion within limits of rates, for all of some loads at once; None is the cell's load."""

    def __init__(self, rows: MotionRows, loads: Sequence[LoadPoint | None], rates: RateLimits) -> None:
        cell, motion = rows.cell, rows.motion
        self.loads, self.time, names = loads, motion.object.time, rate_names(cell)
        self.stands = float(np.max(np.ptp(motion.q, axis=0))) < STILL
        vectors = [None if point is None else point.load for point in loads]
        problems = [build_sample_problem(rows, load=load, varying=True) for load in vectors]
        self.problems = [without_polygons(problem) for problem in problems]  # sides bound c alone
        changes = replace(rates, jerk=np.full_like(rates.jerk, np.inf))  # c alone keeps limits of jerk
        self.programs = [path_program(cell, motion, [problem], changes) for problem in self.problems]
        self.limits_changes = bool(np.any(np.isfinite(self.programs[0].change)))
        limits = (*rates.torque.tolist(), *rates.wrench.tolist())
        self.rates = dict(zip((*names[0], *names[1]), limits, strict=True))
        third = third_derivatives(self.programs[0].step, motion.dq, motion.ddq)
        self.by_jerk = self._end_by_jerk(third / rates.jerk, names[2], rates.jerk)

    def within(self, found: ScalingRange, below: Callable[[float], ScalingRange]) -> ScalingRange:
        """What limits of rates leave of a range that admits motion, whose ends they move inward."""
        whole, refused = found, None
        while whole.status.admits_motion:
            low, top = whole.lower, self._fastest(whole.lower.c2, whole.upper)
            if top.c2 >= low.c2:
                return range_between(self.slowest(low, top.c2), top, whole.samples)
            refused = refused or ScalingRange(RangeStatus.EMPTY, low, top, found.samples)
            if not whole.samples.several:
                break
            lower = below(top.c2)
            if not lower.lower.c2 < low.c2:
                break
            whole = lower
        assert refused is not None  # noqa: S101 (the range admits motion)
        return refused

    def _fastest(self, lower: float, upper: RangeEnd) -> RangeEnd:
        """The largest c² that rates admit of what lies between a c² and an end, which may be infinity.

        If they admit nothing of it, it is the largest c² beneath that they do not rule out.
        """
        end = upper if self.by_jerk is None or upper.c2 <= self.by_jerk.c2 else self.by_jerk
        c2, c = end.c2, max(1.0, float(np.sqrt(lower)))
        if not self.limits_changes or c2 <= 0 or c2 < lower or (self.stands and np.isinf(c2)):
            return end
        while np.isinf(c2) and c < FASTEST:
            c2 = c2 if self._asked(c).is_admitted else c * c
            c *= FASTER
        return end if np.isinf(c2) else self._followed(c2, (lower, np.inf), faster=False) or end

    def slowest(self, lower: RangeEnd, upper: float) -> RangeEnd:
        """The least c² that rates admit of what lies between an end and a c²."""
        if not self.limits_changes or lower.c2 <= 0:  # however slowly it may be played, nothing changes fast
            return lower
        return self._followed(lower.c2, (0.0, upper), faster=True) or lower

    def refused(self, c2: float) -> RangeEnd | None:
        """What binds where rates do not admit a c² > 0 that all other limits admit; None if they admit it."""
        asked = self._asked(float(np.sqrt(c2))) if self.limits_changes else None
        return None if asked is None or asked.is_admitted else self._binding(asked)

    def _asked(self, c: float) -> FactorAsked:
        return max((self._least(load, c) for load in range(len(self.loads))), key=lambda one: one.share)

    def _least(self, load: int, c: float) -> FactorAsked:
        program = _with_margins(self.programs[load], 3 * RATE_MARGIN)
        found = KernelSolver().least_rates(program, np.full(len(program.square), c * c))
        if found is None:
            raise SolverError(f"what the rates admit at c = {c:.6g} was not found.")
        share, rows, changes = found
        limited = np.isfinite(program.change)
        allowed = np.outer(program.step, program.change[limited]) / c

        def growth(of: Array) -> float:
            moved = np.diff(of[:, limited], axis=0) / allowed
            return float(np.sum((rows[0] - rows[1]) * of) + np.sum((changes[0] - changes[1]) * moved))

        return FactorAsked(load, c, share, (growth(program.square), growth(program.root)), rows, changes)

    def _followed(self, c2: float, within: tuple[float, float], *, faster: bool) -> RangeEnd | None:
        """The first c² from a given one on that rates admit, or the first not ruled out beyond what is of interest."""
        c, refusing = float(np.sqrt(c2)), None
        for _ in range(MOST_CUTS):
            if refusing is not None and not within[0] <= c * c <= within[1]:
                return replace(self._binding(refusing), c2=c * c)
            asked = self._asked(c)
            if asked.is_admitted:
                return None if refusing is None else self._binding(asked)
            c, refusing = asked.next(faster=faster), asked
        raise SolverError(f"the factors within the rates were not found by {MOST_CUTS} linear programs.")

    def _end_by_jerk(self, share: Array, names: Sequence[RowName], most: Array) -> RangeEnd | None:
        """The largest c² by c³ |q'''| <= jerk, of q''' as shares of the limit; None if no jerk is limited or needed."""
        segment, end, joint = (int(one) for one in np.unravel_index(np.argmax(np.abs(share)), share.shape))
        largest, at = float(share[segment, end, joint]), segment + end
        row = ActiveRow.of(names[joint], -most[joint], most[joint], at_upper=largest > 0)
        return RangeEnd(abs(largest) ** (-2 / 3), at, float(self.time[at]), (row,)) if largest else None

    def _binding(self, asked: FactorAsked) -> RangeEnd:
        """The rates of the segment that matters most, and the limits that bind at its ends."""
        problem, program = self.problems[asked.load], self.programs[asked.load]
        weight = np.sum(asked.changes, axis=0)
        segment = int(np.argmax(np.max(weight, axis=1)))
        least = FELT * max(float(np.max(asked.rows)), float(np.max(weight)))
        at_ends = np.max(asked.rows[:, segment : segment + 2, : len(problem.names)], axis=1)
        limited = np.flatnonzero(np.isfinite(program.change))
        rates = []
        for side, place in np.argwhere(asked.changes[:, segment] > least).tolist():
            name = program.names[limited[place]].rate
            rates.append(ActiveRow.of(name, -self.rates[name], self.rates[name], at_upper=side == 0))
        limits = [problem.active_row(row, upper=side == 0) for side, row in np.argwhere(at_ends > least).tolist()]
        named = tuple(dict.fromkeys((*rates, *limits)))
        return RangeEnd(asked.c**2, segment, float(self.time[segment]), named, self.loads[asked.load])


def torques_within_rates(
    rows: MotionRows, rates: RateLimits, c2: float, weights: Array, distribute: DistributionName
) -> tuple[Array, Array]:
    """Torques, Shape (N, m), and wrenches, (N, n w), of the least ∫ τᵀWτ dt within limits and rates at a c².

    With `distribute` "reserve" the least of those of `KernelSolver.reserved_torques`; a SolverError if there are none.
    """
    cell, motion, problem = rows.cell, rows.motion, build_sample_problem(rows, varying=True)
    sizes = given_sizes(cell, motion) if distribute == "reserve" else None
    program = _with_margins(path_program(cell, motion, [problem], rates, weights, sizes=sizes), RATE_MARGIN / 2)
    square, nothing = np.full(motion.samples, c2), np.zeros(motion.samples)
    free = KernelSolver().reserved_torques(program, square, nothing)
    if free is None:
        raise SolverError(f"no torques within the limits and the rates were found at c² = {c2:.6g}.")
    x = np.column_stack([free, nothing, square])
    return problem.torque(x), problem.wrench(x)


def _with_margins(program: SmoothProgram, margin: float) -> SmoothProgram:
    """The same program with limits a little wider, as that of the torques without rates, and rates a little less."""
    widening = np.where(program.lower < program.upper, TORQUE_WIDENING, 0.0)
    lower, upper = program.lower - widening, program.upper + widening
    return replace(program, lower=lower, upper=upper, change=program.change * (1 - margin))
