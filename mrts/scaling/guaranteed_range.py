# SPDX-License-Identifier: MIT
"""The theorem of the guaranteed range: a c² carries every load of a box exactly if it carries all its corners.

At a fixed c² the loads that the arms can carry form a convex set, so it holds the box if it holds its corners (proof in
docs/uncertain_load.md). The range that is guaranteed for a whole box is therefore the intersection of the ranges of its
corners: no grid, no nonlinear program, nothing approximate. Where a fixed distribution leaves c² as the only unknown,
the worst load of every row follows in closed form, and no corner is enumerated.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from mrts.base.arrays import Array
from mrts.base.load_box import OFFSETS, LoadBox, LoadPoint
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.closed_form import LoadSensitivity, ends_in_closed_form, load_sensitivity, worst_parameters
from mrts.program.infeasibility import Conflict
from mrts.program.sample_problem import SampleProblem
from mrts.program.sample_ranges import SampleRanges, first_least, statuses, without_speed_at_rest
from mrts.scaling.load_study import LoadQuestion, LoadStudy, ends_of_loads
from mrts.scaling.range import ScalingRange, common_range, intersect

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
    of_points = asked.ranges(points)

    def find(high: float) -> SampleRanges:
        ranges = [
            known.samples if high == asked.high else asked.ranges_at(point, high)
            for point, known in zip(points, of_points, strict=True)
        ]
        return asked.named(_intersection(points, ranges))

    return common_range(find, asked.high), LoadStudy(question, box, points, tuple(of_points))


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
    return ends_of_loads(points, ranges, ends, (at_low, at_high), ordered)


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

    return SampleRanges(
        time=asked.motion.object.time,
        status=statuses(ends.lower, ends.upper, ()),
        lower=ends.lower,
        upper=ends.upper,
        rows=ends.rows,
        conflicts=(),
        fallbacks=0,
        lower_loads=_worst_loads(problem, sensitivity, box, varying, ends.lower),
        upper_loads=_worst_loads(problem, sensitivity, box, varying, ends.upper),
    )


def _worst_loads(
    problem: SampleProblem, sensitivity: LoadSensitivity, box: LoadBox, varying: tuple[str, ...], c2: Array
) -> tuple[LoadPoint, ...]:
    """The load that sets one end of each sample, of c², Shape (N,)."""
    largest = worst_parameters(problem, sensitivity, np.where(np.isfinite(c2), c2, 0.0))
    points = {}
    for key in {
        (*row, finite) for row, finite in zip(map(tuple, largest.tolist()), np.isfinite(c2).tolist(), strict=True)
    }:
        values = {name: box.ranges[name][int(high)] for name, high in zip(varying, key[:-1], strict=True)}
        points[key] = LoadPoint(values, box.load_at(values)) if key[-1] else box.nominal_point()
    return tuple(points[*row, finite] for row, finite in zip(largest.tolist(), np.isfinite(c2).tolist(), strict=True))
