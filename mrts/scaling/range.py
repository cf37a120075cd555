# SPDX-License-Identifier: MIT
"""The admissible range of c² over the whole motion: the intersection of the ranges of all samples.

At a fixed c² the loads that the arms can carry form a convex set, so it holds the box if it holds its corners (proof in
docs/uncertain_load.md). The range that is guaranteed for a whole box is therefore the intersection of the ranges of its
corners: no grid, no nonlinear program, nothing approximate. Which c² some load admits at a sample is the paper's
nonlinear program, verified by linear ones.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Progress
from mrts.base.held_interrupt import held_interrupt
from mrts.base.load_box import LoadBox, LoadPoint
from mrts.base.notebook import NotebookTable
from mrts.base.words import interval_text
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import RATES, ActiveRow, Side, row_labels, rows_text
from mrts.program.infeasibility import Conflict
from mrts.program.motion_rows import MotionRows
from mrts.program.sample_problem import NO_EFFECT, SampleProblem, build_sample_problem
from mrts.program.sample_ranges import (
    MOST_INTERVALS,
    POINT_TOLERANCE,
    SIDES,
    UNBOUNDED,
    RangeStatus,
    SampleRanges,
    first_least,
    motion_ranges,
    sample_ranges,
)
from mrts.scaling.options import Options, load_box

INERT = 1e-12
"""A parameter that changes the object's wrench by no more than this share of it has no effect along a motion."""

AT_END = 1e-6
"""Share of c² within which it is at an end of what a sample admits: ends that tie are right to 1e-7."""

LARGEST_GRID = 10_000


ACHIEVED_TOLERANCE = 1e-6
"""The linear program at the load found must reach the nonlinear program's c² to this share of it."""

IPOPT_OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-10,  # of the scaled program: far below `ACHIEVED_TOLERANCE`, and IPOPT reaches it
    "ipopt.max_iter": 500,
    # by default IPOPT oversteps bounds by 1e-8 of their size, which the substituted program does not
    "ipopt.bound_relax_factor": 0.0,
}


@dataclass(frozen=True)
class RangeEnd:
    """One end of the range over the motion.

    Attributes:
        c2: Its value; infinity if nothing limits it, or of a lower end without an admissible c².
        sample: Where it is reached, None if nothing limits it.
        time: Of that sample [s], None if nothing limits it.
        named: The rows that bind there, or what finds them: to name all of them takes linear programs.
        load: The load that sets it, if the load is uncertain.
    """

    c2: float
    sample: int | None = None
    time: float | None = None
    named: tuple[ActiveRow, ...] | Callable[[], tuple[ActiveRow, ...]] = field(default=(), repr=False, compare=False)
    load: LoadPoint | None = None

    @cached_property
    def rows(self) -> tuple[ActiveRow, ...]:
        """The rows that bind there."""
        return self.named() if callable(self.named) else self.named

    def is_at(self, c2: float) -> bool:
        """Whether a c² is at this end, and limits set it."""
        return self.time is not None and abs(c2 - self.c2) <= AT_END * self.c2

    def to_json(self) -> dict[str, Any] | None:
        """Entry of "binding" in the JSON result; None if nothing limits this end."""
        if self.time is None:
            return None
        entry: dict[str, Any] = {"time": self.time, "rows": [row.to_json() for row in self.rows]}
        return entry if self.load is None else entry | {"load": self.load.to_json()}

    def place(self) -> str:
        """When, with which load and by which rows this end is set, in words."""
        of_load = self.load is not None and any(row.name.of_load for row in self.rows)
        load = f" with {self.load}" if of_load else ""
        return f"at t = {self.time:.4g} s{load} by {rows_text(self.rows)}"


@dataclass(frozen=True, repr=False)
class ScalingRange:
    """The range over the whole motion.

    Attributes:
        status: The outcome.
        lower: c²⁻; infinity if infeasible.
        upper: c²⁺; minus infinity if infeasible, below `lower` if empty.
        samples: The ranges that were intersected.
    """

    status: RangeStatus
    lower: RangeEnd
    upper: RangeEnd
    samples: SampleRanges

    @property
    def c2_upper(self) -> float:
        """c²⁺; infinity if nothing limits it, minus infinity if no c² is admissible."""
        return self.upper.c2 if self.status.admits_motion else -np.inf

    def __repr__(self) -> str:
        return f"<ScalingRange {self.status.value}: {self.reason() or f'c² ∈ {self.text()}'}>"

    def text(self, digits: int = 4) -> str:
        """Both ends in words, such as `[0, 3.062]`."""
        return interval_text(self.lower.c2, self.upper.c2, digits=digits)

    def binding(self, sample: int, side: Side) -> tuple[ActiveRow, ...]:
        """Rows that bind at one end of a sample; all of them where it sets the range."""
        end = self.lower if side == "lower" else self.upper
        own = float((self.samples.lower if side == "lower" else self.samples.upper)[sample])
        return end.rows if end.sample == sample and end.c2 == own else self.samples.binding(sample, side)

    def to_json(self) -> dict[str, Any]:
        """Status, both ends and what sets them; None stands for an end that does not exist."""
        ends = {"lower": self.lower, "upper": self.upper}
        return {
            "status": self.status.value,
            "c2": {side: end.c2 if np.isfinite(end.c2) else None for side, end in ends.items()},
            "binding": {side: end.to_json() for side, end in ends.items()},
        }

    def reason(self) -> str:
        """Why no c² is admissible, in a few words; empty if some is."""
        conflicts, slow, fast = self.samples.conflicts, self.lower, self.upper
        if self.status.admits_motion:
            return ""
        if self.status is RangeStatus.INFEASIBLE:
            worst = max(conflicts, key=lambda conflict: conflict.widening)
            where = f"at {len(conflicts)} of {len(self.samples.time)} samples"
            return f"{where}; at t = {worst.time:.4g} s{worst.with_load} {row_labels(worst.rows)} conflict"
        rated = any(row.name.kind in RATES for row in (*slow.rows, *fast.rows))
        text = f"c² must be at least {slow.c2:.6g} {slow.place()}, but at most {fast.c2:.6g} {fast.place()}"
        return f"a rate is too small: {text}" if rated else text

    def explain(self) -> str:
        """Why no c² is admissible (the message of step 3.2); empty if some is."""
        conflicts, text = self.samples.conflicts, f"{self.reason()}."
        if self.status.admits_motion:
            return ""
        if self.status is RangeStatus.INFEASIBLE:
            worst = max(conflicts, key=lambda conflict: conflict.widening)
            text = f"{len(conflicts)} of {len(self.samples.time)} samples are infeasible. The worst: {worst}."
        elif self.samples.several:
            text += " Of several intervals of a sample its highest is meant: lower ones have nothing in common either."
        return f"{text} {self.status.advice}"


def intersect(samples: SampleRanges) -> ScalingRange:
    """Eq. (30): the intersection of the ranges of all samples (step 2 of MMTSF)."""
    at_low, at_high = int(first_least(-samples.lower)), int(first_least(samples.upper))
    low, high = float(samples.lower.max()), float(samples.upper.min())
    ends = []
    for side, sample, c2 in zip(SIDES, (at_low, at_high), (low, high), strict=True):
        rows, load = partial(samples.all_binding, sample, side), samples.load_at(sample, side)
        named = RangeEnd(c2, sample, float(samples.time[sample]), rows, load)
        ends.append(named if np.isfinite(c2) else RangeEnd(c2))
    return range_between(ends[0], ends[1], samples)


def range_between(lower: RangeEnd, upper: RangeEnd, samples: SampleRanges) -> ScalingRange:
    """The range between two ends; what rounding turned inside out is a point."""
    if upper.c2 < lower.c2 <= upper.c2 * (1 + POINT_TOLERANCE):
        lower = replace(lower, c2=upper.c2)
    status = RangeStatus.UNBOUNDED if np.isinf(upper.c2) else RangeStatus.FEASIBLE
    if lower.c2 > upper.c2:
        status = RangeStatus.INFEASIBLE if samples.conflicts else RangeStatus.EMPTY
    return ScalingRange(status, lower, upper, samples)


def common_range(find: Callable[[float], SampleRanges], high: float = np.inf) -> ScalingRange:
    """The highest interval of c² that all samples admit, of those that do not begin above a c².

    Where intervals of single samples lie above what all others admit, their next lower ones are looked at.

    Returns:
        Where the samples have nothing in common: an empty range, of their highest intervals.
    """
    first = found = find(high)
    for _ in range(MOST_INTERVALS):
        top = float(np.min(found.upper)) * (1 + POINT_TOLERANCE)
        if not found.several or found.conflicts or not np.any(found.lower > top):
            return intersect(found)
        found = find(top)
        if np.any(found.lower > top):
            break
    return intersect(first)


@dataclass(frozen=True, repr=False)
class LoadStudy:
    """What was asked of an uncertain load, and the answer for each load that was looked at.

    Attributes:
        question: "guaranteed" (every load of the box), "possible" (some load, sample by sample) or "grid:N".
        box: The box.
        points: Loads that were evaluated one by one.
        ranges: Their ranges over the motion.
        not_converged: Samples where the search of `possible` was not verified and a corner's range stands.
    """

    question: str
    box: LoadBox
    points: tuple[LoadPoint, ...]
    ranges: tuple[ScalingRange, ...]
    not_converged: tuple[int, ...] = ()

    def __repr__(self) -> str:
        return f"<LoadStudy {self.sentence()}>"

    def sentence(self) -> str:
        """The question and the box in words."""
        what = self.box.description()
        if self.question == "guaranteed":
            return f"for every load of the box ({what})"
        if self.question == "possible":
            missed = f"; {len(self.not_converged)} samples not converged" if self.not_converged else ""
            return f"at best, for some load of the box at each sample ({what}{missed})"
        low, high = (self.box.mass * factor for factor in self.box.ranges["mass"])
        return f"for {len(self.points)} masses from {low:.4g} to {high:.4g} kg, all else nominal"

    def table(self) -> NotebookTable:
        """The range of each load that was looked at, that with the least c²⁺ first."""
        rows = [
            (str(point), found.text(), row_labels(found.upper.rows))
            if found.status.admits_motion
            else (str(point), found.status.value, found.reason())
            for point, found in sorted(zip(self.points, self.ranges, strict=True), key=lambda one: one[1].c2_upper)
        ]
        return NotebookTable(("load", "c²", "c²⁺ is set by"), rows)

    def to_json(self) -> dict[str, Any]:
        """The study as JSON values."""
        return {
            "question": self.question,
            "ranges": {name: list(pair) for name, pair in self.box.ranges.items()},
            "principal_axes": self.box.principal_axes.tolist(),
            "principal_moments": self.box.principal_moments.tolist(),
            "points": [
                point.to_json() | found.to_json() for point, found in zip(self.points, self.ranges, strict=True)
            ],
            "not_converged": list(self.not_converged),
        }


def range_at_samples(
    rows: MotionRows, options: Options, progress: Progress = lambda _done, _total: None, high: float = np.inf
) -> tuple[ScalingRange, LoadStudy | None]:
    """The range of c² at the samples of a motion (steps 1 and 2 of MMTSF), and what was found of an uncertain load.

    Of several intervals the highest is found that does not begin above `high`. What is possible at a sample lies
    between the least and the largest c² of any load: where a load leaves a gap below its highest interval, whether
    another load of the box fills it is not asked.

    Raises:
        InputError: If there is no box, or the question does not fit it.
        SolverError: If no solver answers.
    """
    if options.load == "nominal":
        return common_range(partial(motion_ranges, rows, None), high), None
    box, every = load_box(rows.cell, options.load), options.load != "possible"
    if options.load in {"guaranteed", "possible"}:
        varying = effective_parameters(rows.cell, rows.motion, box)
        middle = () if every or not varying else (box.nominal_point(),)
        points: tuple[LoadPoint, ...] = (*box.corners(varying), *middle)
    else:
        points, varying = mass_grid(box, options.load), ()
    of_points = []
    for number, point in enumerate(points):
        progress(number, len(points))
        of_points.append(common_range(partial(motion_ranges, rows, point.load), high))
    progress(len(points), len(points))
    not_converged: tuple[int, ...] = ()

    def find(below: float) -> SampleRanges:
        nonlocal not_converged
        ranges = [
            motion_ranges(rows, point.load, below)
            if known.samples.several and not (every and below == high)
            else known.samples
            for point, known in zip(points, of_points, strict=True)
        ]
        found = combined_ranges(points, ranges, every=every)
        if not every and varying:
            found, not_converged = _searched(rows, box, varying, found, progress)
        return found

    found = common_range(find, high)
    return found, LoadStudy(options.load, box, points, tuple(of_points), not_converged)


def effective_parameters(
    cell: Cell, motion: CoordinatedMotion, box: LoadBox, parts: tuple[str, ...] = ("P", "Q")
) -> tuple[str, ...]:
    """Parameters that change the object's wrench along this motion: corners that differ in others coincide."""

    def wrenches(load: Array) -> list[Array]:
        terms = cell.functions("terms", motion.samples, motion.inputs(load))
        return [terms[part] for part in parts]  # compared each by itself: how fast the motion is given does not move Q

    nominal = wrenches(box.nominal_point().load)

    def has_effect(name: str) -> bool:
        ends = [wrenches(box.load_at({name: end})) for end in box.ranges[name]]
        pairs = [pair for end in ends for pair in zip(end, nominal, strict=True)]
        return any(np.max(np.abs(of - known)) > INERT * np.max(np.abs(known)) for of, known in pairs)

    return tuple(filter(has_effect, box.varying))


def mass_grid(box: LoadBox, question: str) -> tuple[LoadPoint, ...]:
    """The paper's exhaustive search along k_m (below (46)): evenly spaced masses, both ends included.

    Raises:
        InputError: If it is another question, or the mass does not vary.
    """
    match = re.fullmatch(r"grid:([0-9]{1,9})", question)
    if not match:
        raise InputError("load", "must be nominal, guaranteed, possible, or grid:N such as grid:51.", value=question)
    if "mass" not in box.varying:
        raise InputError("load", "a grid runs along the mass, which does not vary in this cell.", value=question)
    count = int(match[1])
    if not 2 <= count <= LARGEST_GRID:  # noqa: PLR2004 (both ends)
        raise InputError("load", f"a grid takes 2 to {LARGEST_GRID} masses.", value=question)
    factors = np.linspace(*box.ranges["mass"], count).tolist()
    return tuple(LoadPoint({"mass": factor}, box.load_at({"mass": factor})) for factor in factors)


def combined_ranges(points: Sequence[LoadPoint | None], ranges: Sequence[SampleRanges], *, every: bool) -> SampleRanges:
    """What every load, or some load, admits at each sample, with the load that sets each end.

    Args:
        points: The loads; None for ranges that have loads of their own at each sample.
        every: Whether the ranges are intersected, or what lies between their outermost ends is taken.
    """
    inward = 1.0 if every else -1.0
    low, high = (inward * np.array([getattr(found, end) for found in ranges]) for end in SIDES)
    choice = np.array([first_least(-low), first_least(high)])
    duals, own = np.stack([found.duals for found in ranges]), np.indices(choice.shape)
    of_samples: dict[int, list[Conflict]] = {}
    for point, found in zip(points, ranges, strict=True):
        for conflict in found.conflicts:
            of_samples.setdefault(conflict.sample, []).append(replace(conflict, load=point or conflict.load))
    worst = max if every else min
    at_low, at_high = (
        tuple(points[k] or ranges[k].load_at(sample, side) for sample, k in enumerate(chosen))
        for side, chosen in zip(SIDES, choice.tolist(), strict=True)
    )
    return replace(
        ranges[0],
        lower=inward * np.max(low, axis=0),
        upper=inward * np.min(high, axis=0),
        duals=duals[choice, own[0], own[1]],
        gaps=np.any([found.gaps for found in ranges], axis=0),
        conflicts=tuple(
            worst(conflicts, key=lambda conflict: conflict.widening)
            for _, conflicts in sorted(of_samples.items())
            if every or len(conflicts) == len(points)
        ),
        loads=(at_low, at_high),
    )


def _searched(
    rows: MotionRows, box: LoadBox, varying: tuple[str, ...], best: SampleRanges, progress: Progress
) -> tuple[SampleRanges, tuple[int, ...]]:
    """The best corner's range at every sample extended by loads inside the box, and the samples without convergence.

    Every answer is verified: its load is substituted and the linear program solved, and that program's c² is what
    counts. So an end never claims more than a load of the box reaches, nor less than the best corner.
    """
    least = {name: box.ranges[name][0] for name in varying}
    motion, problem = rows.motion, build_sample_problem(rows, load=box.load_at(least))
    others = [build_sample_problem(rows, load=box.load_at(least | {name: box.ranges[name][1]})) for name in varying]
    search = load_search(problem, others)
    low, high = np.array([box.ranges[name] for name in varying]).T
    in_order = np.all(problem.lower <= problem.upper, axis=1)  # where sides cross no load helps
    wanted: dict[Side, NDArray[np.intp]] = {
        "lower": np.flatnonzero(in_order & (best.lower > 0) & (not best.several)),
        "upper": np.flatnonzero(in_order & (np.isfinite(best.upper) | np.isinf(best.lower))),
    }
    total, done = sum(map(len, wanted.values())), 0
    missed: set[int] = set()
    for side, samples in wanted.items():
        assert best.loads is not None  # noqa: S101 (made from points)
        corners, c2 = best.loads[SIDES.index(side)], np.zeros(len(samples))
        tried = [box.nominal_point()] * motion.samples
        for place, sample in enumerate(samples.tolist()):
            corner = np.array([corners[sample].parameters[name] for name in varying])
            known = float(getattr(best, side)[sample])
            share, c2[place] = search(sample, side, known, (corner - low) / (high - low))
            values = np.clip(low + share * (high - low), low, high).tolist()
            parameters = dict(zip(varying, values, strict=True))
            tried[sample] = LoadPoint(parameters, box.load_at(parameters))
            done += 1
            progress(done, total)
        loads = np.array([point.load for point in tried])
        checked = sample_ranges(build_sample_problem(rows, load=loads), motion.object.time)
        checked = replace(checked, loads=(tried, tried))
        reached, sign = (checked.lower, -1.0) if side == "lower" else (checked.upper, 1.0)
        kept = sign * (c2 - reached[samples]) <= ACHIEVED_TOLERANCE * np.abs(c2)
        missed |= set(samples[~kept & (np.isfinite(c2) | np.isfinite(best.lower[samples]))].tolist())
        carried = np.isfinite(checked.lower)
        left = tuple(conflict for conflict in best.conflicts if not carried[conflict.sample])
        best = replace(combined_ranges((None, None), (best, checked), every=False), conflicts=left)
    return best, tuple(sorted(missed))


def load_search(
    problem: SampleProblem, others: Sequence[SampleProblem]
) -> Callable[[int, Side, float, Array], tuple[Array, float]]:
    """Eqs. (42), (43), (44), (45), (46): least or largest c² over torques and load together, with (24) as well.

    Unknowns are those of the linear program with c for c², and the uncertain parameters as shares s in [0, 1] of their
    ranges: rows read A x + (a + Σ_j s_j a_j) c² + b c + Σ_j s_j o_j, exactly, as they are affine in the load. IPOPT
    (Wächter and Biegler, 2006) finds a local optimum from each start: a corner of the box, and its middle.

    Args:
        problem: Rows with every parameter at its least value.
        others: Rows with one parameter at its largest value, one problem a parameter.

    Returns:
        Of a sample, a side, the c² known of it and a corner: shares of the parameters, and c²; NaN if IPOPT found none.
    """
    import casadi as ca  # noqa: PLC0415 (only here: this is the nonlinear program)

    _, rows, unknowns = problem.A.shape
    free, count = unknowns - 1, len(others)
    change = np.array([other.square - problem.square for other in others])
    upper = np.isfinite(problem.upper)
    finite = np.where(upper, problem.upper, problem.lower)  # limits move opposite to the offset of their row
    offsets = np.array([finite - np.where(upper, other.upper, other.lower) for other in others])
    effect = np.maximum(problem.effect(caps=True), np.max(np.abs(change), axis=(0, 2), initial=0.0))
    unit = 1 / np.where(effect > NO_EFFECT, effect, 1.0)
    root = np.zeros_like(problem.lower) if problem.speed is None else problem.speed * np.sqrt(unit)[:, None]
    size = np.max(np.abs(problem.free), axis=1, initial=0.0)
    matrix = problem.free / np.where(size > NO_EFFECT, size, 1.0)[:, None, :]
    square, squares = problem.square * unit[:, None], change * unit[:, None]

    x, c, s = ca.SX.sym("x", free), ca.SX.sym("c"), ca.SX.sym("s", count)
    A, a, b = ca.SX.sym("A", rows, free), ca.SX.sym("a", rows), ca.SX.sym("b", rows)
    da, do, sign = ca.SX.sym("da", rows, count), ca.SX.sym("do", rows, count), ca.SX.sym("sign")
    program = {
        "x": ca.vertcat(x, c, s),
        "f": sign * c,
        "g": A @ x + (a + da @ s) * c**2 + b * c + do @ s,
        "p": ca.vertcat(ca.vec(A), a, b, ca.vec(da), ca.vec(do), sign),
    }
    solve = ca.nlpsol("possible_load", "ipopt", program, IPOPT_OPTIONS)

    def found(sample: int, sign: float, c: float, s: Array) -> tuple[Array, float]:
        A, a, b = matrix[sample], square[sample], root[sample]
        lower, upper, da, do = problem.lower[sample], problem.upper[sample], squares[:, sample], offsets[:, sample]
        rest = (a + s @ da) * c**2 + b * c + s @ do
        x = np.linalg.lstsq(A, np.clip(0.0, lower, upper) - rest, rcond=None)[0]
        with held_interrupt():
            answer = solve(
                x0=np.concatenate([x, [c], s]),
                p=np.concatenate([A.ravel(order="F"), a, b, da.ravel(), do.ravel(), [sign]]),
                lbx=np.concatenate([np.full(free, -np.inf), np.zeros(1 + count)]),
                ubx=np.concatenate([np.full(free, np.inf), [np.sqrt(UNBOUNDED)], np.ones(count)]),
                lbg=lower,
                ubg=upper,
            )
        z = answer["x"].full()[:, 0]
        c2 = float(z[free] ** 2 * unit[sample]) if solve.stats()["success"] else np.nan
        return np.clip(np.nan_to_num(z[free + 1 :], nan=0.5), 0.0, 1.0), c2

    def best(sample: int, side: Side, known: float, corner: Array) -> tuple[Array, float]:
        sign, start = 1.0 if side == "lower" else -1.0, np.sqrt(known / unit[sample]) if np.isfinite(known) else 1.0
        tried = [found(sample, sign, float(start), s) for s in (corner, np.full(count, 0.5))]
        return min(tried, key=lambda one: (np.isnan(one[1]), sign * one[1]))

    return best
