# SPDX-License-Identifier: MIT
"""Least and largest c² of samples, the gaps between them, and the rows that bind there."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import SolverError
from mrts.base.load_box import LoadPoint
from mrts.limits.rows import STANDSTILL, ActiveRow, LimitRows, RowName, Side
from mrts.limits.squared_rows import SpeedCaps
from mrts.samples.sample_problem import SampleProblem

BINDING_TOLERANCE = 1e-7
"""A row binds if its multiplier exceeds this share of the largest, or, in closed form, its c² ties this closely."""


@dataclass
class RangeEnds:
    """Least and largest c² of a batch, the rows that bind there, and where neither was found."""

    lower: Array
    upper: Array
    lower_rows: "list[tuple[ActiveRow, ...]] | TiedRows"
    upper_rows: "list[tuple[ActiveRow, ...]] | TiedRows"
    undecided: NDArray[np.bool_]
    fallbacks: int

    def replace(self, samples: NDArray[np.int_], other: "RangeEnds") -> None:
        """Take some samples from another batch, which must have found them."""
        require_decided(samples, other.undecided)
        for index, sample in enumerate(samples):
            lower, upper = other.lower[index], other.upper[index]
            self.lower[sample], self.upper[sample] = min(lower, upper), upper
            self.lower_rows[sample], self.upper_rows[sample] = other.lower_rows[index], other.upper_rows[index]
        self.fallbacks += other.fallbacks


def require_decided(samples: NDArray[np.int_], undecided: NDArray[np.bool_]) -> None:
    """Refuse to go on where limits hold together but no range was found.

    Args:
        samples: Indices of the samples.
        undecided: Which of them have no range.

    Raises:
        SolverError: If one has none.
    """
    if np.any(undecided):
        sample = int(samples[int(np.argmax(undecided))])
        raise SolverError(
            f"no solver found the range of c² at sample {sample}, although its limits hold together. This is a defect "
            "of mrts or of extremely scaled data: please report the cell and the motion."
        )


@dataclass(frozen=True)
class KernelRows(Sequence[tuple[ActiveRow, ...]]):
    """The rows that bind at one end of each of N samples, named when they are asked for.

    Attributes:
        limits: The rows of a motion.
        kept: Those that the kernel has, Shape (r,); row r + k - 1 of a basis is c² >= 0 at its lower side, a cap at its
            upper one.
        caps: The rows that bound c² alone.
        basis: As the kernel gives them, Shape (N, k).
        dual: Their multipliers, Shape (N, k).
        settled: By sample, what was found in another way.
    """

    limits: LimitRows
    kept: NDArray[np.int_]
    caps: SpeedCaps
    basis: NDArray[np.int16]
    dual: NDArray[np.float32]
    settled: dict[int, tuple[ActiveRow, ...]]

    def __len__(self) -> int:
        return len(self.basis)

    def __getitem__(self, sample: Any) -> Any:
        if isinstance(sample, slice):
            return tuple(self[index] for index in range(*sample.indices(len(self))))
        index = range(len(self))[sample]
        if index in self.settled:
            return self.settled[index]
        sides, size = self.basis[index], np.abs(self.dual[index])
        rows = np.abs(sides.astype(int)) - 1
        strong = size > BINDING_TOLERANCE * np.max(size)
        of_c2 = rows >= len(self.kept)
        named = [ActiveRow(STANDSTILL, "lower", 0.0)] if np.any(strong & of_c2 & (sides < 0)) else []
        for place in np.argsort(-size, kind="stable"):
            row, upper = rows[place], bool(sides[place] > 0)
            if strong[place] and of_c2[place] and upper:
                named += self.caps.binding(index)
            elif strong[place] and not of_c2[place]:
                named.append(self.limits.active(int(self.kept[row]), upper=upper))
        return tuple(named)


@dataclass(frozen=True, kw_only=True)
class TiedRows(Sequence[tuple[ActiveRow, ...]]):
    """The rows that tie at one end of each of N samples where c² is the only unknown, named when they are asked for.

    Attributes:
        end: Which end.
        c2: The end at every sample, Shape (N,); there are no rows where it is not finite.
        sides: 1 where a row's upper limit sets the end, -1 where its lower one does, 0 where neither, Shape (N, r).
        names: One a row.
        limits: Lower and upper limits as given, each Shape (r,).
        settled: By sample, what was found in another way.
    """

    end: Side
    c2: Array
    sides: NDArray[np.int8]
    names: tuple[RowName, ...]
    limits: tuple[Array, Array]
    settled: dict[int, tuple[ActiveRow, ...]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.c2)

    def __setitem__(self, sample: int, rows: tuple[ActiveRow, ...]) -> None:
        self.settled[sample] = rows

    def __getitem__(self, sample: Any) -> Any:
        if isinstance(sample, slice):
            return tuple(self[index] for index in range(*sample.indices(len(self))))
        index = range(len(self))[sample]
        if index in self.settled:
            return self.settled[index]
        if self.end == "lower" and self.c2[index] == 0:
            return (ActiveRow(STANDSTILL, "lower", 0.0),)
        if not np.isfinite(self.c2[index]):
            return ()
        (lower, upper), sides = self.limits, self.sides[index]
        return tuple(
            ActiveRow(self.names[row], "upper", float(upper[row]))
            if sides[row] > 0
            else ActiveRow(self.names[row], "lower", float(lower[row]))
            for row in np.flatnonzero(sides).tolist()
        )


@dataclass(frozen=True)
class SelectedRows(Sequence[tuple[ActiveRow, ...]]):
    """The rows at one end of each of N samples, each from one of several sources, looked up when they are asked for.

    Attributes:
        sources: Rows of every sample by source.
        choice: Which source counts, Shape (N,).
    """

    sources: tuple[Sequence[tuple[ActiveRow, ...]], ...]
    choice: NDArray[np.int_]

    def __len__(self) -> int:
        return len(self.choice)

    def __getitem__(self, sample: Any) -> Any:
        if isinstance(sample, slice):
            return tuple(self[index] for index in range(*sample.indices(len(self))))
        return self.sources[self.choice[sample]][sample]


def active_rows(problem: SampleProblem, dual: Array, standstill_dual: float) -> tuple[ActiveRow, ...]:
    """Rows with a multiplier, strongest first; rows of the object's balance are laws and are left out."""
    largest = max(float(np.max(np.abs(dual), initial=0.0)), abs(standstill_dual))
    active = []
    if abs(standstill_dual) > BINDING_TOLERANCE * largest:
        active.append(ActiveRow(STANDSTILL, "lower", 0.0))
    order = np.argsort(-np.abs(dual), kind="stable")
    strong = [row for row in order if problem.is_limit[row] and abs(dual[row]) > BINDING_TOLERANCE * largest]
    return tuple(active + [problem.active_row(row, upper=bool(dual[row] > 0)) for row in strong])


@dataclass(frozen=True, kw_only=True)
class Gap:
    """An open interval of c² that a sample does not admit, between two that it does.

    Attributes:
        sample: Index of the sample.
        lower: Where it begins: the largest c² of the interval below.
        upper: Where it ends: the least c² of the interval above.
        lower_rows: Rows that bind where it begins.
        upper_rows: Rows that bind where it ends.
        lower_load: The load that sets where it begins, if the load is uncertain.
        upper_load: Likewise where it ends.
    """

    sample: int
    lower: float
    upper: float
    lower_rows: Sequence[ActiveRow]
    upper_rows: Sequence[ActiveRow]
    lower_load: LoadPoint | None = None
    upper_load: LoadPoint | None = None


def gaps_of(
    sample: int, speeds: Sequence[tuple[float, float]], rows: Callable[[int, float, Side], Sequence[ActiveRow]]
) -> list[Gap]:
    """The gaps between the intervals of speeds c that a sample admits.

    Args:
        sample: Index of the sample.
        speeds: Its intervals, ascending.
        rows: The rows of an end: of a sample, at a c², on that side of an interval.
    """
    ends = [(below[1] ** 2, above[0] ** 2) for below, above in pairwise(speeds)]
    return [
        Gap(
            sample=sample,
            lower=lower,
            upper=upper,
            lower_rows=rows(sample, lower, "upper"),
            upper_rows=rows(sample, upper, "lower"),
        )
        for lower, upper in ends
    ]


@dataclass(frozen=True)
class Piece:
    """An interval of c² that several gaps leave.

    Attributes:
        lower: Its least c².
        upper: Its largest.
        after: The gap that it begins at; None if it begins where all does.
        before: The gap that it ends at; None if it ends where all does.
    """

    lower: float
    upper: float
    after: Gap | None
    before: Gap | None


def pieces(lower: float, upper: float, gaps: Sequence[Gap]) -> list[Piece]:
    """What gaps leave of an interval, ascending.

    Args:
        lower: Its least c².
        upper: Its largest.
        gaps: In any order, of one or of several samples and loads.
    """
    left, least, after = [], lower, None
    for gap in sorted(gaps, key=lambda gap: (gap.lower, -gap.upper)):
        if gap.lower >= upper:
            break
        if gap.upper <= least:
            continue
        if gap.lower >= least:
            left.append(Piece(least, gap.lower, after, gap))
        least, after = gap.upper, gap
    if least <= upper:
        left.append(Piece(least, upper, after, None))
    return left


def gaps_between(left: Sequence[Piece], sample: int) -> tuple[Gap, ...]:
    """The gaps between pieces of one sample, each with the rows of the two gaps that it lies between."""
    between = []
    for below, above in pairwise(left):
        begins, ends = below.before, above.after
        assert begins is not None and ends is not None  # noqa: S101, PT018 (there is something between them)
        between.append(
            replace(
                begins,
                sample=sample,
                lower=below.upper,
                upper=above.lower,
                upper_rows=ends.upper_rows,
                upper_load=ends.upper_load,
            )
        )
    return tuple(between)
