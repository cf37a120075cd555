# SPDX-License-Identifier: MIT
"""What a sample does not admit between its least and its largest c²: where inertia helps what friction hinders."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from mrts.base.load_box import LoadPoint
from mrts.limits.rows import ActiveRow, Side


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
