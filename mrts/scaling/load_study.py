# SPDX-License-Identifier: MIT
"""What is asked of an uncertain load, the ranges of c² of single loads, and the answer."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.argument_types import Progress, check_type
from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.load_box import LoadBox, LoadPoint
from mrts.base.notebook.in_notebooks import InNotebooks, NotebookTable
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import Side
from mrts.program.formulation import FormulationName
from mrts.program.infeasibility import Conflict
from mrts.program.load_sharing import LoadSharing
from mrts.program.range_ends import chosen_rows
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.sample_ranges import SampleRanges, statuses, with_end_problem
from mrts.program.trajectory_programs import motion_ranges
from mrts.scaling.range import ScalingRange, common_range


def load_question(cell: Cell, load: str, select: object) -> str:
    """The question that is asked of the load.

    Args:
        cell: The cell.
        load: As in `scale`; "auto" asks for the guaranteed range where the load varies.
        select: As in `scale`.

    Raises:
        InputError: If it is no text, leaves open what `select` needs, or the cell's load does not vary.
    """
    check_type("load", load, str)
    if load == "auto":
        return "nominal" if cell.load_box is None else "guaranteed"
    if load == "possible" and select != "auto":
        raise InputError(
            "select",
            "what is possible leaves open which load it is, so no c² and no torques are chosen. Ask for the guaranteed "
            "range, or give the cell a known load.",
            value=select,
        )
    if load != "nominal":
        load_box(cell, load)
    return load


def load_box(cell: Cell, question: str) -> LoadBox:
    """What the load is known within.

    Args:
        cell: The cell.
        question: That is asked of it.

    Raises:
        InputError: If the cell's load does not vary.
    """
    if cell.load_box is None:
        raise InputError(
            "load",
            "the cell says nothing of how its load varies: add 'variation' under 'object' in the cell file, such as "
            "'variation: {mass: [0.5, 2.0]}'.",
            value=question,
        )
    return cell.load_box


@dataclass(frozen=True, repr=False)
class LoadStudy(InNotebooks):
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

    def notebook_tables(self) -> Iterator[NotebookTable]:
        """The range of every load that was looked at."""
        rows = [(str(point), repr(found).strip("<>")) for point, found in zip(self.points, self.ranges, strict=True)]
        yield NotebookTable(("load", "range"), rows)

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


@dataclass(frozen=True, kw_only=True)
class LoadQuestion:
    """What every question of an uncertain load shares.

    Attributes:
        cell: The cell.
        motion: Its motion.
        formulation: As in `build_sample_problem`.
        sharing: Likewise.
        solver: Name in the registry.
        progress: Told how many of how many loads are done.
        high: Of several intervals the highest is found that does not begin above this c².
    """

    cell: Cell
    motion: CoordinatedMotion
    formulation: FormulationName
    sharing: LoadSharing | None
    solver: str
    progress: Progress
    high: float = np.inf

    def problem(self, load: Array) -> SampleProblem:
        """Rows with a load, Shape (10,), or one a sample, Shape (N, 10)."""
        return build_sample_problem(
            self.cell, self.motion, formulation=self.formulation, sharing=self.sharing, load=load
        )

    def ranges_at(self, point: LoadPoint, high: float) -> SampleRanges:
        """Ranges of a load whose intervals do not begin above a c²."""
        return motion_ranges(self.cell, self.motion, self.formulation, self.sharing, self.solver, point.load, high)

    def ranges(self, points: Sequence[LoadPoint]) -> list[ScalingRange]:
        """The range over the motion of each load."""
        found = []
        for number, point in enumerate(points):
            self.progress(number, len(points))
            found.append(common_range(partial(self.ranges_at, point), self.high))
        self.progress(len(points), len(points))
        return found

    def named(self, samples: SampleRanges) -> SampleRanges:
        """Ranges each of whose ends is that of some load, which can name all rows that set an end."""
        if self.sharing is not None or samples.lower_loads is None or samples.upper_loads is None:
            return samples
        loads = partial(_load_of_end, samples.lower_loads, samples.upper_loads)
        return with_end_problem(self.cell, self.motion, samples, loads)


def _load_of_end(lower: Sequence[LoadPoint], upper: Sequence[LoadPoint], sample: int, side: Side) -> Array:
    return (lower if side == "lower" else upper)[sample].load


def ends_of_loads(
    points: Sequence[LoadPoint],
    ranges: Sequence[SampleRanges],
    ends: tuple[Array, Array],
    places: tuple[NDArray[np.int_], NDArray[np.int_]],
    conflicts: tuple[Conflict, ...],
) -> SampleRanges:
    """Ranges of which the lower and the upper end of each sample are those of some load.

    Args:
        points: The loads.
        ranges: Their ranges.
        ends: Lower and upper end, each Shape (N,).
        places: Which load sets each, likewise.
        conflicts: Of the samples that have no range.
    """
    (lower, upper), (at_low, at_high) = ends, places
    return SampleRanges(
        time=ranges[0].time,
        status=statuses(lower, upper, conflicts),
        lower=lower,
        upper=upper,
        rows=chosen_rows([found.rows for found in ranges], np.stack(places)),
        conflicts=conflicts,
        fallbacks=sum(found.fallbacks for found in ranges),
        lower_loads=tuple(points[index] for index in at_low),
        upper_loads=tuple(points[index] for index in at_high),
        several=any(found.several for found in ranges),
    )
