# SPDX-License-Identifier: MIT
"""The theorem of the guaranteed range: a c² carries every load of a box exactly if it carries all its corners.

At a fixed c² the loads that the arms can carry form a convex set, so it holds the box if it holds its corners (proof in
docs/uncertain_load.md). The range that is guaranteed for a whole box is therefore the intersection of the ranges of its
corners: no grid, no nonlinear program, nothing approximate. Where a fixed distribution leaves c² as the only unknown,
the worst load of every row follows in closed form, and no corner is enumerated.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.load_box import OFFSETS, LoadBox, LoadPoint
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.samples.closed_form import ends_in_closed_form, load_sensitivity, worst_parameters
from mrts.samples.infeasibility import Conflict
from mrts.samples.range_ends import Gap
from mrts.samples.sample_ranges import SampleRanges, first_least, statuses, with_gaps, without_speed_at_rest
from mrts.scaling.load_study import LoadQuestion, LoadStudy, ends_of_loads
from mrts.scaling.range import ScalingRange, intersect

INERT = 1e-12
"""A parameter that changes the object's wrench by no more than this share of it has no effect along a motion."""


def guaranteed_range(asked: LoadQuestion, box: LoadBox, varying: tuple[str, ...]) -> tuple[ScalingRange, LoadStudy]:
    """The range of c² that carries every load of a box: the intersection of its corners' ranges.

    Args:
        asked: Of which cell and motion.
        box: The box.
        varying: Parameters that matter, as from `effective_parameters`.

    Raises:
        SolverError: If no solver answers.
    """
    if asked.sharing is not None and not any(name in OFFSETS for name in varying):
        closed = _in_closed_form(asked, box, varying)
        if closed is not None:
            return intersect(closed), LoadStudy("guaranteed", box, (), ())
    return for_every_load(asked, "guaranteed", box, box.corners(varying))


def for_every_load(
    asked: LoadQuestion, question: str, box: LoadBox, points: tuple[LoadPoint, ...]
) -> tuple[ScalingRange, LoadStudy]:
    """The range of c² that carries each of some loads.

    Args:
        asked: Of which cell and motion.
        question: Name of the question that these loads answer.
        box: The box that they are of.
        points: The loads.

    Raises:
        SolverError: If no solver answers.
    """
    ranges = asked.ranges(points)
    found = asked.whole(_intersection(points, ranges))
    return found, LoadStudy(question, box, points, tuple(intersect(of_point) for of_point in ranges))


def effective_parameters(
    cell: Cell, motion: CoordinatedMotion, box: LoadBox, parts: tuple[str, ...] = ("P", "Q")
) -> tuple[str, ...]:
    """Parameters that change the object's wrench along this motion: corners that differ in others coincide.

    Args:
        cell: The cell.
        motion: Its motion.
        box: The box.
        parts: What the wrench is made of: P c² + Q, with S r̈ where the speed varies.
    """

    def wrenches(load: Array) -> list[Array]:
        terms = cell.functions("terms", motion.samples, motion.inputs(load))
        return [terms[part] for part in parts]  # compared each by itself: how fast the motion is given does not move Q

    nominal = wrenches(box.nominal_point().load)
    found = []
    for name in box.varying:
        ends = [wrenches(box.load_at({name: end})) for end in box.ranges[name]]
        for end, part in product(ends, range(len(parts))):
            change = float(np.max(np.abs(end[part] - nominal[part])))
            if change > INERT * float(np.max(np.abs(nominal[part]))):
                found.append(name)
                break
    return tuple(found)


def _intersection(points: Sequence[LoadPoint], ranges: Sequence[SampleRanges]) -> SampleRanges:
    """The intersection of the ranges of all loads at every sample, with the load that sets each end."""
    low, high = np.array([found.lower for found in ranges]), np.array([found.upper for found in ranges])
    at_low, at_high = first_least(-low), first_least(high)
    conflicts: dict[int, Conflict] = {}
    for point, found in zip(points, ranges, strict=True):
        for conflict in found.conflicts:
            worst = conflicts.get(conflict.sample)
            if worst is None or conflict.widening > worst.widening:
                conflicts[conflict.sample] = replace(conflict, load=point)
    ordered = tuple(conflicts[sample] for sample in sorted(conflicts))
    ends = np.max(low, axis=0), np.min(high, axis=0)
    found = ends_of_loads(points, ranges, ends, (at_low, at_high), ordered)
    gaps: dict[int, list[Gap]] = {}
    for point, of_point in zip(points, ranges, strict=True):
        for gap in of_point.gaps:
            gaps.setdefault(gap.sample, []).append(replace(gap, lower_load=point, upper_load=point))
    return with_gaps(found, gaps) if gaps else found


def _in_closed_form(asked: LoadQuestion, box: LoadBox, varying: tuple[str, ...]) -> SampleRanges | None:
    """The guaranteed range of a fixed distribution, no corner enumerated; None if it needs the corners all the same."""
    least = {name: box.ranges[name][0] for name in varying}
    problem = without_speed_at_rest(asked.problem(box.load_at(least)))
    if problem.speed is not None:
        return None  # a row then leaves a union of intervals for each load: the corners are looked at
    others = [asked.problem(box.load_at(least | {name: box.ranges[name][1]})) for name in varying]
    sensitivity = load_sensitivity(problem, others)
    ends = ends_in_closed_form(problem, sensitivity)
    if np.any(ends.undecided):
        return None

    def worst(sample: int, c2: float) -> LoadPoint:
        if not np.isfinite(c2):
            return box.nominal_point()
        largest = worst_parameters(problem, sensitivity, sample, c2)
        values = {name: box.ranges[name][int(high)] for name, high in zip(varying, largest, strict=True)}
        return LoadPoint(values, box.load_at(values))

    return SampleRanges(
        time=asked.motion.object.time,
        status=statuses(ends.lower, ends.upper, ()),
        lower=ends.lower,
        upper=ends.upper,
        lower_rows=ends.lower_rows,
        upper_rows=ends.upper_rows,
        conflicts=(),
        fallbacks=0,
        lower_loads=_LoadsOnDemand(ends.lower, worst),
        upper_loads=_LoadsOnDemand(ends.upper, worst),
    )


@dataclass(frozen=True)
class _LoadsOnDemand(Sequence[LoadPoint]):
    """The load that sets one end of each sample, found when it is asked for: c² of the end, Shape (N,), and by whom."""

    c2: Array
    find: Callable[[int, float], LoadPoint]

    def __len__(self) -> int:
        return len(self.c2)

    def __getitem__(self, sample: Any) -> Any:
        if isinstance(sample, slice):
            return tuple(self[index] for index in range(*sample.indices(len(self))))
        return self.find(sample, float(self.c2[sample]))
