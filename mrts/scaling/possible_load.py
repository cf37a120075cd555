# SPDX-License-Identifier: MIT
"""Which c² some load of a box admits at a sample: the paper's nonlinear program, verified by linear ones."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.load_box import LoadBox, LoadPoint
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import Side
from mrts.program.closed_form import LoadSensitivity, load_sensitivity
from mrts.program.held_interrupt import held_interrupt
from mrts.program.linear_programs import NO_EFFECT, UNBOUNDED, effect_of_speed
from mrts.program.sample_problem import SampleProblem
from mrts.program.sample_ranges import SampleRanges, first_least, sample_ranges, statuses
from mrts.scaling.loads import (
    LoadStudy,
    effective_parameters,
    ends_of_loads,
    problem_of_load,
    ranges_of_load,
    ranges_of_loads,
    with_all_rows,
)
from mrts.scaling.options import Options
from mrts.scaling.range import ScalingRange, common_range

ACHIEVED_TOLERANCE = 1e-6
"""The linear program at the load found must reach the nonlinear program's c² to this share of it."""

IPOPT_TOLERANCE = 1e-10
"""Of the scaled program: far below `ACHIEVED_TOLERANCE`, and IPOPT reaches it."""

IPOPT_OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": IPOPT_TOLERANCE,
    "ipopt.max_iter": 500,
    # by default IPOPT oversteps bounds by 1e-8 of their size, which the substituted program does not
    "ipopt.bound_relax_factor": 0.0,
}


SIDES: tuple[Side, Side] = ("lower", "upper")


@dataclass(frozen=True)
class _BestLoad:
    """What the search found at some samples: parameters in [0, 1], Shape (n, p), c², and IPOPT's word, Shape (n,)."""

    parameters: Array
    c2: Array
    success: NDArray[np.bool_]


def possible_range(
    cell: Cell, motion: CoordinatedMotion, options: Options, box: LoadBox, progress: Progress, high: float
) -> tuple[ScalingRange, LoadStudy]:
    """The range of c² of the best load of a box, at each sample by itself.

    Of each sample it is what lies between the least and the largest c² of any load: where a load leaves a gap below its
    highest interval, whether another load of the box fills it is not asked.

    Args:
        cell: The cell.
        motion: Its motion.
        options: How the programs are made and solved.
        box: The box.
        progress: Told how far the work is.
        high: As in `range_at_samples`.

    Raises:
        InputError: If the box is an outer hull.
        SolverError: If no solver answers.
    """
    if box.outer_hull:
        raise InputError(
            "load",
            "an outer hull holds loads that do not exist, so it cannot answer what is possible. Give ranges of the "
            "first moments mx, my, mz instead of the offsets.",
            value="possible",
        )
    varying = effective_parameters(cell, motion, box)
    points = box.corners(varying)
    if varying:
        points = (*points, box.nominal_point())
    of_points = ranges_of_loads(cell, motion, options, points, progress, high)
    not_converged: tuple[int, ...] = ()

    def find(below: float) -> SampleRanges:
        nonlocal not_converged
        ranges = [
            ranges_of_load(cell, motion, options, point.load, below) if known.samples.several else known.samples
            for point, known in zip(points, of_points, strict=True)
        ]
        best = _for_some_load(points, ranges)
        if varying:
            best, not_converged = _searched(cell, motion, options, box, varying, best, progress)
        return with_all_rows(cell, motion, options, best)

    found = common_range(find, high)
    return found, LoadStudy("possible", box, points, of_points, not_converged)


def _for_some_load(points: Sequence[LoadPoint], ranges: Sequence[SampleRanges]) -> SampleRanges:
    """At every sample the lowest and the highest c² that one of the loads reaches."""
    low, high = np.array([found.lower for found in ranges]), np.array([found.upper for found in ranges])
    at_low, at_high = first_least(low), first_least(-high)
    conflicts = []
    for sample in np.flatnonzero(np.isinf(np.min(low, axis=0))):
        of_points = [
            replace(conflict, load=point)
            for point, found in zip(points, ranges, strict=True)
            for conflict in found.conflicts
            if conflict.sample == sample
        ]
        conflicts.append(min(of_points, key=lambda conflict: conflict.widening))
    return ends_of_loads(
        points, ranges, (np.min(low, axis=0), np.max(high, axis=0)), (at_low, at_high), tuple(conflicts)
    )


def _searched(
    cell: Cell,
    motion: CoordinatedMotion,
    options: Options,
    box: LoadBox,
    varying: tuple[str, ...],
    best: SampleRanges,
    progress: Progress,
) -> tuple[SampleRanges, tuple[int, ...]]:
    """Extend the best corner's range at every sample by loads inside the box.

    Every answer is verified: its load is substituted and the linear program solved, and that program's c² is what
    counts. So an end never claims more than a load of the box reaches, nor less than the best corner.

    Returns:
        The ranges, and the samples where an answer was not verified.
    """
    least = {name: box.ranges[name][0] for name in varying}
    rows = partial(problem_of_load, cell, motion, options)
    problem = rows(box.load_at(least))
    others = [rows(box.load_at(least | {name: box.ranges[name][1]})) for name in varying]
    search = _Search(problem, load_sensitivity(problem, others))
    infeasible, in_order = np.isinf(best.lower), np.all(problem.lower <= problem.upper, axis=1)
    wanted: dict[Side, NDArray[np.int_]] = {
        "lower": np.flatnonzero(in_order & (best.lower > 0) & (not best.several)),
        "upper": np.flatnonzero(in_order & (np.isfinite(best.upper) | infeasible)),
    }  # where sides cross no load helps
    total, done = sum(len(samples) for samples in wanted.values()), 0
    missed: set[int] = set()
    for side, samples in wanted.items():
        if not len(samples):
            continue
        counted = partial(_count_on, progress, done, total)
        found = search.run(samples, side, best, _starts(box, varying, best, side), counted)
        done += len(samples)
        low, high = (np.array([box.ranges[name][end] for name in varying]) for end in (0, 1))
        values = np.clip(low + found.parameters * (high - low), low, high)
        points = [LoadPoint(dict(zip(varying, map(float, row), strict=True)), np.zeros(0)) for row in values]
        points = [replace(point, load=box.load_at(point.parameters)) for point in points]
        loads = np.tile(box.load_at({}), (motion.samples, 1))
        loads[samples] = [point.load for point in points]
        checked = sample_ranges(rows(loads).at(samples), motion.object.time[samples], options.solver)
        best, unverified = _keep_better(best, side, samples, points, checked, found)
        missed |= unverified
    return best, tuple(sorted(missed))


def _count_on(progress: Progress, before: int, total: int, done: int) -> None:
    progress(before + done, total)


def _starts(box: LoadBox, varying: tuple[str, ...], best: SampleRanges, side: Side) -> Array:
    """Parameters of the best corner at every sample, as shares of their ranges, Shape (N, p)."""
    loads = best.lower_loads if side == "lower" else best.upper_loads
    assert loads is not None  # noqa: S101 (made from points)
    low, high = (np.array([box.ranges[name][end] for name in varying]) for end in (0, 1))
    values = np.array([[point.parameters[name] for name in varying] for point in loads])
    starts: Array = (values - low) / (high - low)
    return starts


def _keep_better(
    best: SampleRanges,
    side: Side,
    samples: NDArray[np.int_],
    points: list[LoadPoint],
    checked: SampleRanges,
    found: _BestLoad,
) -> tuple[SampleRanges, set[int]]:
    """Take what the verified loads reach beyond the best corner; also the samples whose answer was not verified."""
    ends = {"lower": best.lower.copy(), "upper": best.upper.copy()}
    loads = {"lower": list(best.lower_loads or ()), "upper": list(best.upper_loads or ())}
    reached, sign = (checked.lower, -1.0) if side == "lower" else (checked.upper, 1.0)
    short = sign * (found.c2 - reached)
    promised = found.success & ~(short <= ACHIEVED_TOLERANCE * np.abs(found.c2))
    unverified = samples[promised | (~found.success & np.isfinite(best.lower[samples]))]
    carried, rows = np.isfinite(checked.lower), best.rows
    beyond = checked.lower < best.lower[samples], checked.upper > best.upper[samples]
    for number, end in enumerate(SIDES):
        taken = np.flatnonzero(carried & beyond[number])
        ends[end][samples[taken]] = (checked.lower, checked.upper)[number][taken]
        rows = rows.with_samples(samples[taken], checked.rows.codes[:, taken], slice(number, number + 1))
        for index in taken.tolist():
            loads[end][int(samples[index])] = points[index]
    cleared = set(samples[carried].tolist())
    lower, upper = ends["lower"], ends["upper"]
    conflicts = tuple(conflict for conflict in best.conflicts if conflict.sample not in cleared)
    better = replace(
        best,
        status=statuses(lower, upper, conflicts),
        lower=lower,
        upper=upper,
        rows=rows,
        conflicts=conflicts,
        lower_loads=tuple(loads["lower"]),
        upper_loads=tuple(loads["upper"]),
        fallbacks=best.fallbacks + checked.fallbacks,
    )
    return better, set(unverified.tolist())


class _Search:
    """Eqs. (42), (43), (44), (45), (46): least or largest c² over torques and load together, with (24) as well.

    Unknowns are those of the linear program and the uncertain parameters as shares s in [0, 1] of their ranges: rows
    read A x + (a + Σ_j s_j a_j) c² + b c + Σ_j s_j o_j. IPOPT (Wächter and Biegler, 2006) finds a local optimum from
    each start. Where some row has a term b in c, c is the unknown, else c².

    Args:
        problem: Rows with every parameter at its least value.
        sensitivity: Effect of the parameters.
    """

    def __init__(self, problem: SampleProblem, sensitivity: LoadSensitivity) -> None:
        count, rows, unknowns = problem.A.shape
        p = len(sensitivity.c2)
        effect = np.maximum(effect_of_speed(problem), np.max(np.abs(sensitivity.c2), axis=(0, 2), initial=0.0))
        if problem.speed is not None:
            effect = np.maximum(effect, np.max(np.abs(problem.speed), axis=1, initial=0.0) ** 2)
        self.unit = 1 / np.where(effect > NO_EFFECT, effect, 1.0)
        self.b = None if problem.speed is None else problem.speed * np.sqrt(self.unit)[:, None]
        size = np.max(np.abs(problem.free), axis=1, initial=0.0)
        self.column = 1 / np.where(size > NO_EFFECT, size, 1.0)
        self.A = problem.free * self.column[:, None, :]
        self.a = problem.square * self.unit[:, None]
        self.da = sensitivity.c2 * self.unit[:, None]
        self.do = sensitivity.offset
        self.lower, self.upper = problem.lower, problem.upper
        import casadi as ca  # noqa: PLC0415 (only here: this is the nonlinear program)

        x, y, s = ca.SX.sym("x", unknowns - 1), ca.SX.sym("y"), ca.SX.sym("s", p)
        A, a = ca.SX.sym("A", rows, unknowns - 1), ca.SX.sym("a", rows)
        da, do, sign = ca.SX.sym("da", rows, p), ca.SX.sym("do", rows, p), ca.SX.sym("sign")
        b = ca.SX.sym("b", 0 if self.b is None else rows)
        square = y if self.b is None else y**2
        program = {
            "x": ca.vertcat(x, y, s),
            "f": sign * y,
            "g": A @ x + (a + da @ s) * square + do @ s + (0 if self.b is None else b * y),
            "p": ca.vertcat(ca.vec(A), a, ca.vec(da), ca.vec(do), b, sign),
        }
        self.solve = ca.nlpsol("possible_load", "ipopt", program, IPOPT_OPTIONS)
        self.free, self.p, self.samples = unknowns - 1, p, count

    def run(
        self,
        samples: NDArray[np.int_],
        side: Side,
        best: SampleRanges,
        corners: Array,
        progress: Callable[[int], None],
    ) -> _BestLoad:
        """Search some samples, each from its best corner and from the middle of the box.

        Args:
            samples: Indices, n of them.
            side: Which end of the range.
            best: Ranges to start from.
            corners: Shares of the parameters to start from, Shape (N, p).
            progress: Told how many samples are done.
        """
        sign = 1.0 if side == "lower" else -1.0
        ends = best.lower if side == "lower" else best.upper
        parameters, c2 = np.zeros((len(samples), self.p)), np.full(len(samples), sign * np.inf)
        success = np.zeros(len(samples), dtype=bool)
        for index, sample in enumerate(samples.tolist()):
            start_y = ends[sample] / self.unit[sample] if np.isfinite(ends[sample]) else 1.0
            for start in (corners[sample], np.full(self.p, 0.5)):
                with held_interrupt():
                    s, value, solved = self._from(sample, sign, start_y, start)
                better = sign * value < sign * c2[index]
                if (solved and (better or not success[index])) or (not success[index] and better):
                    parameters[index], c2[index] = s, value
                success[index] |= solved
            progress(index + 1)
        return _BestLoad(parameters, c2, success)

    def _from(self, sample: int, sign: float, y: float, s: Array) -> tuple[Array, float, bool]:
        target = np.clip(0.0, self.lower[sample], self.upper[sample])
        rest = (self.a[sample] + s @ self.da[:, sample]) * y + s @ self.do[:, sample]
        largest, of_speed = UNBOUNDED, np.zeros(0)
        if self.b is not None:
            y, largest, of_speed = float(np.sqrt(y)), float(np.sqrt(UNBOUNDED)), self.b[sample]
            rest = rest + of_speed * y
        x = np.linalg.lstsq(self.A[sample], target - rest, rcond=None)[0]
        found = self.solve(
            x0=np.concatenate([x, [y], s]),
            p=np.concatenate(
                [
                    self.A[sample].ravel(order="F"),
                    self.a[sample],
                    self.da[:, sample].ravel(),
                    self.do[:, sample].ravel(),
                    of_speed,
                    [sign],
                ]
            ),
            lbx=np.concatenate([np.full(self.free, -np.inf), np.zeros(1 + self.p)]),
            ubx=np.concatenate([np.full(self.free, np.inf), [largest], np.ones(self.p)]),
            lbg=self.lower[sample],
            ubg=self.upper[sample],
        )
        z = found["x"].full()[:, 0]
        shares = np.clip(np.nan_to_num(z[self.free + 1 :], nan=0.5), 0.0, 1.0)
        value = float(z[self.free] if self.b is None else z[self.free] ** 2) * float(self.unit[sample])
        return shares, value if np.isfinite(value) else sign * np.inf, bool(self.solve.stats()["success"])
