# SPDX-License-Identifier: MIT
"""Which c² some load of a box admits at a sample: the paper's nonlinear program, verified by linear ones."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.load_box import LoadBox, LoadPoint
from mrts.limits.rows import Side
from mrts.program.held_interrupt import held_interrupt
from mrts.program.motion_rows import MotionRows
from mrts.program.range_ends import NO_EFFECT, UNBOUNDED, effect_of_speed
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.sample_ranges import SampleRanges, motion_ranges, sample_ranges
from mrts.scaling.loads import (
    LoadStudy,
    combined_ranges,
    effective_parameters,
    ranges_of_loads,
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


def possible_range(
    rows: MotionRows, options: Options, box: LoadBox, progress: Progress, high: float
) -> tuple[ScalingRange, LoadStudy]:
    """The range of c² of the best load of a box, at each sample by itself.

    Of each sample it is what lies between the least and the largest c² of any load: where a load leaves a gap below its
    highest interval, whether another load of the box fills it is not asked. Arguments as in `range_at_samples`.

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
    varying = effective_parameters(rows.cell, rows.motion, box)
    points = (*box.corners(varying), box.nominal_point()) if varying else box.corners(varying)
    of_points = ranges_of_loads(rows, options, points, progress, high)
    not_converged: tuple[int, ...] = ()

    def find(below: float) -> SampleRanges:
        nonlocal not_converged
        ranges = [
            motion_ranges(rows, options.solver, point.load, below) if known.samples.several else known.samples
            for point, known in zip(points, of_points, strict=True)
        ]
        best = combined_ranges(points, ranges, every=False)
        if varying:
            best, not_converged = _searched(rows, options.solver, box, varying, best, progress)
        return best

    found = common_range(find, high)
    return found, LoadStudy("possible", box, points, of_points, not_converged)


def _searched(
    rows: MotionRows,
    solver: str,
    box: LoadBox,
    varying: tuple[str, ...],
    best: SampleRanges,
    progress: Progress,
) -> tuple[SampleRanges, tuple[int, ...]]:
    """The best corner's range at every sample extended by loads inside the box, and the samples without convergence.

    Every answer is verified: its load is substituted and the linear program solved, and that program's c² is what
    counts. So an end never claims more than a load of the box reaches, nor less than the best corner.
    """
    least = {name: box.ranges[name][0] for name in varying}
    motion, problem = rows.motion, build_sample_problem(rows, load=box.load_at(least))
    others = [build_sample_problem(rows, load=box.load_at(least | {name: box.ranges[name][1]})) for name in varying]
    search = _Search(problem, others)
    low, high = np.array([box.ranges[name] for name in varying]).T
    in_order = np.all(problem.lower <= problem.upper, axis=1)  # where sides cross no load helps
    wanted: dict[Side, NDArray[np.intp]] = {
        "lower": np.flatnonzero(in_order & (best.lower > 0) & (not best.several)),
        "upper": np.flatnonzero(in_order & (np.isfinite(best.upper) | np.isinf(best.lower))),
    }
    total, done = sum(map(len, wanted.values())), 0
    missed: set[int] = set()
    for side, samples in wanted.items():
        corners = best.lower_loads if side == "lower" else best.upper_loads
        assert corners is not None  # noqa: S101 (made from points)
        tried, c2, success = (
            [box.nominal_point()] * motion.samples,
            np.zeros(len(samples)),
            np.zeros(len(samples), bool),
        )
        for place, sample in enumerate(samples.tolist()):
            corner = np.array([corners[sample].parameters[name] for name in varying])
            share, c2[place], success[place] = search.best(sample, side, best, (corner - low) / (high - low))
            values = np.clip(low + share * (high - low), low, high).tolist()
            parameters = dict(zip(varying, values, strict=True))
            tried[sample] = LoadPoint(parameters, box.load_at(parameters))
            done += 1
            progress(done, total)
        loads = np.array([point.load for point in tried])
        checked = sample_ranges(build_sample_problem(rows, load=loads), motion.object.time, solver)
        checked = replace(checked, lower_loads=tried, upper_loads=tried)
        reached, sign = (checked.lower, -1.0) if side == "lower" else (checked.upper, 1.0)
        promised = success & ~(sign * (c2 - reached[samples]) <= ACHIEVED_TOLERANCE * np.abs(c2))
        missed |= set(samples[promised | (~success & np.isfinite(best.lower[samples]))].tolist())
        carried = np.isfinite(checked.lower)
        left = tuple(conflict for conflict in best.conflicts if not carried[conflict.sample])
        best = replace(combined_ranges((None, None), (best, checked), every=False), conflicts=left)
    return best, tuple(sorted(missed))


class _Search:
    """Eqs. (42), (43), (44), (45), (46): least or largest c² over torques and load together, with (24) as well.

    Unknowns are those of the linear program and the uncertain parameters as shares s in [0, 1] of their ranges: rows
    read A x + (a + Σ_j s_j a_j) c² + b c + Σ_j s_j o_j, exactly, as they are affine in the load. IPOPT (Wächter and
    Biegler, 2006) finds a local optimum from each start. Where some row has a term b in c, c is the unknown, else c².

    Args:
        problem: Rows with every parameter at its least value.
        others: Rows with one parameter at its largest value, one problem a parameter.
    """

    def __init__(self, problem: SampleProblem, others: Sequence[SampleProblem]) -> None:
        _, rows, unknowns = problem.A.shape
        p = len(others)
        change = np.array([other.square - problem.square for other in others])
        upper = np.isfinite(problem.upper)
        finite = np.where(upper, problem.upper, problem.lower)  # limits move opposite to the offset of their row
        self.do = np.array([finite - np.where(upper, other.upper, other.lower) for other in others])
        effect = np.maximum(effect_of_speed(problem), np.max(np.abs(change), axis=(0, 2), initial=0.0))
        if problem.speed is not None:
            effect = np.maximum(effect, np.max(np.abs(problem.speed), axis=1, initial=0.0) ** 2)
        self.unit = 1 / np.where(effect > NO_EFFECT, effect, 1.0)
        self.b = None if problem.speed is None else problem.speed * np.sqrt(self.unit)[:, None]
        size = np.max(np.abs(problem.free), axis=1, initial=0.0)
        self.A = problem.free / np.where(size > NO_EFFECT, size, 1.0)[:, None, :]
        self.a, self.da = problem.square * self.unit[:, None], change * self.unit[:, None]
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
        self.free, self.p = unknowns - 1, p

    def best(self, sample: int, side: Side, known: SampleRanges, corner: Array) -> tuple[Array, float, bool]:
        """Shares of the parameters, c² and whether IPOPT converged, from a corner and from the middle of the box."""
        sign = 1.0 if side == "lower" else -1.0
        end = float((known.lower if side == "lower" else known.upper)[sample])
        start_y = end / float(self.unit[sample]) if np.isfinite(end) else 1.0
        shares, c2, success = np.zeros(self.p), sign * np.inf, False
        for start in (corner, np.full(self.p, 0.5)):
            with held_interrupt():
                s, value, solved = self._from(sample, sign, start_y, start)
            better = sign * value < sign * c2
            if (solved and (better or not success)) or (not success and better):
                shares, c2 = s, value
            success |= solved
        return shares, c2, success

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
