# SPDX-License-Identifier: MIT
"""The range of c² at the samples of a motion, for a load that is known or for one that is known within a box.

At a fixed c² the loads that the arms can carry form a convex set, so it holds the box if it holds its corners (proof in
docs/uncertain_load.md). The range that is guaranteed for a whole box is therefore the intersection of the ranges of its
corners: no grid, no nonlinear program, nothing approximate.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.load_box import LoadBox, LoadPoint
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.infeasibility import Conflict
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.range_ends import same_width
from mrts.program.sample_ranges import SIDES, SampleRanges, first_least
from mrts.program.trajectory_programs import motion_ranges
from mrts.scaling.options import Options, load_box
from mrts.scaling.range import ScalingRange, common_range

INERT = 1e-12
"""A parameter that changes the object's wrench by no more than this share of it has no effect along a motion."""

GRID_POINTS = 51
"""Loads of `grid` where no number is given."""

LARGEST_GRID = 10_000


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


def range_at_samples(
    cell: Cell,
    motion: CoordinatedMotion,
    options: Options,
    progress: Progress = lambda _done, _total: None,
    high: float = np.inf,
    rows: MotionRows | None = None,
) -> tuple[ScalingRange, LoadStudy | None]:
    """The range of c² at the samples of a motion (steps 1 and 2 of MMTSF), and what was found of an uncertain load.

    Args:
        options: Which load is asked about, and how the programs are made and solved; checked.
        high: Of several intervals the highest is found that does not begin above this c².

    Raises:
        InputError: If there is no box, or the question does not fit it.
        SolverError: If no solver answers.
    """
    rows = motion_rows(cell, motion, options.sharing, options.formulation) if rows is None else rows
    if options.load == "nominal":
        return common_range(partial(motion_ranges, rows, options.solver, None), high), None
    box = load_box(cell, options.load)
    if options.load == "possible":
        from mrts.scaling.possible_load import possible_range  # noqa: PLC0415 (its nonlinear program is rarely asked for)

        return possible_range(rows, options, box, progress, high)
    if options.load == "guaranteed":
        points = box.corners(effective_parameters(cell, motion, box))
    else:
        points = mass_grid(box, options.load)
    of_points = ranges_of_loads(rows, options, points, progress, high)

    def find(below: float) -> SampleRanges:
        ranges = [
            known.samples if below == high else motion_ranges(rows, options.solver, point.load, below)
            for point, known in zip(points, of_points, strict=True)
        ]
        return combined_ranges(points, ranges, every=True)

    return common_range(find, high), LoadStudy(options.load, box, points, of_points)


def ranges_of_loads(
    rows: MotionRows, options: Options, points: Sequence[LoadPoint], progress: Progress, high: float
) -> tuple[ScalingRange, ...]:
    """The range over the motion of each load; arguments as in `range_at_samples`."""
    found = []
    for number, point in enumerate(points):
        progress(number, len(points))
        found.append(common_range(partial(motion_ranges, rows, options.solver, point.load), high))
    progress(len(points), len(points))
    return tuple(found)


def effective_parameters(
    cell: Cell, motion: CoordinatedMotion, box: LoadBox, parts: tuple[str, ...] = ("P", "Q")
) -> tuple[str, ...]:
    """Parameters that change the object's wrench along this motion: corners that differ in others coincide."""

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


def mass_grid(box: LoadBox, question: str) -> tuple[LoadPoint, ...]:
    """The paper's exhaustive search along k_m (below (46)): evenly spaced masses, both ends included.

    Raises:
        InputError: If it is another question, or the mass does not vary.
    """
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


def combined_ranges(points: Sequence[LoadPoint | None], ranges: Sequence[SampleRanges], *, every: bool) -> SampleRanges:
    """What every load, or some load, admits at each sample, with the load that sets each end.

    Args:
        points: The loads; None for ranges that have loads of their own at each sample.
        every: Whether the ranges are intersected, or what lies between their outermost ends is taken.
    """
    inward = 1.0 if every else -1.0
    low, high = (inward * np.array([getattr(found, end) for found in ranges]) for end in SIDES)
    choice = np.array([first_least(-low), first_least(high)])
    codes, own = np.stack(same_width([found.codes for found in ranges])), np.indices(choice.shape)
    of_samples: dict[int, list[Conflict]] = {}
    for point, found in zip(points, ranges, strict=True):
        for conflict in found.conflicts:
            of_samples.setdefault(conflict.sample, []).append(replace(conflict, load=point or conflict.load))
    worst = max if every else min
    lower_loads, upper_loads = (
        tuple(points[k] or ranges[k].loads(side)[sample] for sample, k in enumerate(chosen))
        for side, chosen in zip(SIDES, choice.tolist(), strict=True)
    )
    return replace(
        ranges[0],
        lower=inward * np.max(low, axis=0),
        upper=inward * np.min(high, axis=0),
        codes=codes[choice, own[0], own[1]],
        gaps=np.any([found.gaps for found in ranges], axis=0),
        conflicts=tuple(
            worst(conflicts, key=lambda conflict: conflict.widening)
            for _, conflicts in sorted(of_samples.items())
            if every or len(conflicts) == len(points)
        ),
        fallbacks=sum(found.fallbacks for found in ranges),
        lower_loads=lower_loads,
        upper_loads=upper_loads,
    )
