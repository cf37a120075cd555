# SPDX-License-Identifier: MIT
"""The range of c² where the load is known only within a box: three questions, kept apart by name."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.load_box import OFFSETS, LoadBox, LoadPoint
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.samples.closed_form import ends_in_closed_form, load_sensitivity, worst_parameters
from mrts.samples.end_rows import with_end_rows
from mrts.samples.infeasibility import Conflict
from mrts.samples.load_sharing import LoadSharing
from mrts.samples.range_ends import SelectedRows
from mrts.samples.sample_problem import FormulationName, SampleProblem, build_sample_problem
from mrts.samples.sample_ranges import SampleRanges, first_least, statuses, without_speed_at_rest
from mrts.samples.trajectory_programs import motion_ranges
from mrts.scaling.possible_load import widen_by_search
from mrts.scaling.range import ScalingRange, intersect

INERT = 1e-12
"""A parameter that changes the object's wrench by no more than this share of it has no effect along a motion."""

GRID_POINTS = 51
"""Loads of `grid` where no number is given."""

LARGEST_GRID = 10_000

Progress = Callable[[int, int], None]
"""Told how many of how many pieces of work are done."""


@dataclass(frozen=True, repr=False)
class LoadStudy:
    """What was asked of an uncertain load, and the answer for each load that was looked at.

    Attributes:
        question: "guaranteed" (every load of the box), "possible" (some load, sample by sample) or "grid:N".
        box: The box.
        points: Loads that were evaluated one by one; empty where a fixed distribution was answered in closed form.
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

    def to_json(self) -> dict[str, Any]:
        """The study as JSON values."""
        return {
            "question": self.question,
            "ranges": {name: list(pair) for name, pair in self.box.ranges.items()},
            "outer_hull": self.box.outer_hull,
            "principal_axes": self.box.principal_axes.tolist(),
            "principal_moments": self.box.principal_moments.tolist(),
            "points": [
                point.to_json() | found.to_json() for point, found in zip(self.points, self.ranges, strict=True)
            ],
            "not_converged": list(self.not_converged),
        }


@dataclass(frozen=True)
class _Task:
    """What every question shares."""

    cell: Cell
    motion: CoordinatedMotion
    formulation: FormulationName
    sharing: LoadSharing | None
    solver: str
    progress: Progress

    def problem(self, load: Array) -> SampleProblem:
        """Rows with a load, Shape (10,), or one a sample, Shape (N, 10)."""
        return build_sample_problem(
            self.cell, self.motion, formulation=self.formulation, sharing=self.sharing, load=load
        )

    def ranges(self, points: Sequence[LoadPoint]) -> list[SampleRanges]:
        """Ranges of each load."""
        found = []
        for number, point in enumerate(points):
            self.progress(number, len(points))
            found.append(motion_ranges(self.cell, self.motion, self.formulation, self.sharing, self.solver, point.load))
        self.progress(len(points), len(points))
        return found

    def whole(self, samples: SampleRanges) -> ScalingRange:
        """The range over the motion of samples each of whose ends is that of some load."""
        if self.sharing is None and samples.lower_loads is not None and samples.upper_loads is not None:
            loads = {"lower": samples.lower_loads, "upper": samples.upper_loads}
            samples = with_end_rows(self.cell, self.motion, samples, lambda sample, side: loads[side][sample].load)
        return intersect(samples)


def study_load(
    cell: Cell,
    motion: CoordinatedMotion,
    question: str,
    formulation: FormulationName,
    sharing: LoadSharing | None,
    solver: str,
    progress: Progress = lambda _done, _total: None,
) -> tuple[ScalingRange, LoadStudy]:
    """The range of c² of an uncertain load.

    Args:
        cell: The cell, with a load box.
        motion: Its motion.
        question: "guaranteed", "possible", or "grid:N" for N masses.
        formulation: As in `build_sample_problem`.
        sharing: Likewise.
        solver: Name in the registry.
        progress: Told how far the work is.

    Raises:
        InputError: If there is no box, or the question does not fit it.
        SolverError: If no solver answers.
    """
    box = cell.load_box
    if box is None:
        raise InputError(
            "load",
            "the cell says nothing of how its load varies: add 'variation' under 'object' in the cell file, such as "
            "'variation: {mass: [0.5, 2.0]}'.",
            value=question,
        )
    task = _Task(cell, motion, formulation, sharing, solver, progress)
    varying = effective_parameters(cell, motion, box)
    if question == "guaranteed":
        if sharing is not None and not any(name in OFFSETS for name in varying):
            closed = _guaranteed_by_fixed_rule(task, box, varying)
            if closed is not None:
                return intersect(closed), LoadStudy(question, box, (), ())
        points = box.corners(varying)
    elif question == "possible":
        return _possible(task, box, varying)
    else:
        points = _mass_grid(box, question)
    ranges = task.ranges(points)
    found = task.whole(_for_every_point(points, ranges))
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


def _mass_grid(box: LoadBox, question: str) -> tuple[LoadPoint, ...]:
    """The paper's exhaustive search along k_m (below (46)): evenly spaced masses, both ends included."""
    match = re.fullmatch(r"grid(?::([0-9]{1,9}))?", question)
    if not match:
        raise InputError("load", "must be nominal, guaranteed, possible, or grid:N such as grid:51.", value=question)
    if "mass" not in box.varying:
        raise InputError("load", "a grid runs along the mass, which does not vary in this cell.", value=question)
    count = int(match.group(1) or GRID_POINTS)
    if not 2 <= count <= LARGEST_GRID:  # noqa: PLR2004 (both ends)
        raise InputError("load", f"a grid takes 2 to {LARGEST_GRID} masses.", value=question)
    factors = np.linspace(*box.ranges["mass"], count).tolist()
    return tuple(LoadPoint({"mass": factor}, box.load_at({"mass": factor})) for factor in factors)


def _for_every_point(points: Sequence[LoadPoint], ranges: Sequence[SampleRanges]) -> SampleRanges:
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
    return _ends_of_loads(points, ranges, (np.max(low, axis=0), np.min(high, axis=0)), (at_low, at_high), ordered)


def _ends_of_loads(
    points: Sequence[LoadPoint],
    ranges: Sequence[SampleRanges],
    ends: tuple[Array, Array],
    places: tuple[NDArray[np.int_], NDArray[np.int_]],
    conflicts: tuple[Conflict, ...],
) -> SampleRanges:
    """Ranges of which the lower and the upper end of each sample are those of some load, Shape (N,) each."""
    (lower, upper), (at_low, at_high) = ends, places
    return SampleRanges(
        ranges[0].time,
        statuses(lower, upper, conflicts),
        lower,
        upper,
        SelectedRows(tuple(found.lower_rows for found in ranges), at_low),
        SelectedRows(tuple(found.upper_rows for found in ranges), at_high),
        conflicts,
        sum(found.fallbacks for found in ranges),
        tuple(points[index] for index in at_low),
        tuple(points[index] for index in at_high),
    )


def _guaranteed_by_fixed_rule(task: _Task, box: LoadBox, varying: tuple[str, ...]) -> SampleRanges | None:
    """The guaranteed range of a fixed distribution, no corner enumerated; None if some sample has none."""
    least = {name: box.ranges[name][0] for name in varying}
    problem = without_speed_at_rest(task.problem(box.load_at(least)))
    others = [task.problem(box.load_at(least | {name: box.ranges[name][1]})) for name in varying]
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
        task.motion.object.time,
        statuses(ends.lower, ends.upper, ()),
        ends.lower,
        ends.upper,
        tuple(ends.lower_rows),
        tuple(ends.upper_rows),
        (),
        0,
        _LoadsOnDemand(ends.lower, worst),
        _LoadsOnDemand(ends.upper, worst),
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


def _possible(task: _Task, box: LoadBox, varying: tuple[str, ...]) -> tuple[ScalingRange, LoadStudy]:
    if box.outer_hull:
        raise InputError(
            "load",
            "an outer hull holds loads that do not exist, so it cannot answer what is possible. Give ranges of the "
            "first moments mx, my, mz instead of the offsets.",
            value="possible",
        )
    points = box.corners(varying)
    if varying:
        points = (*points, box.nominal_point())
    ranges = task.ranges(points)
    best = _for_some_point(points, ranges)
    not_converged: tuple[int, ...] = ()
    if varying:
        best, not_converged = widen_by_search(
            task.problem, box, varying, best, task.motion.object.time, task.solver, task.progress
        )
    study = LoadStudy("possible", box, points, tuple(intersect(of_point) for of_point in ranges), not_converged)
    return task.whole(best), study


def _for_some_point(points: Sequence[LoadPoint], ranges: Sequence[SampleRanges]) -> SampleRanges:
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
    return _ends_of_loads(
        points, ranges, (np.min(low, axis=0), np.max(high, axis=0)), (at_low, at_high), tuple(conflicts)
    )
