# SPDX-License-Identifier: MIT
"""Which limits set the range along a motion, for drawing: a lane for each row, filled where it binds."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.drawing.labels import row_label
from mrts.limits.rows import STANDSTILL, ActiveRow, Side
from mrts.program.range_status import RangeStatus
from mrts.program.sample_ranges import SampleRanges
from mrts.scaling.range import ScalingRange

MOST_LANES = 14
"""Lanes of one end of the range; rows beyond share the last."""

LaneKind = Literal["upper", "lower", "conflict"]


@dataclass(frozen=True)
class Lane:
    """Where a row binds.

    Attributes:
        kind: At the upper end of the samples' ranges, at the lower one, or in a conflict that leaves no range.
        label: The row, or how many rows share the lane.
        sets: Whether the row sets the range over the motion.
        binds: Shape (N,).
    """

    kind: LaneKind
    label: str
    sets: bool
    binds: NDArray[np.bool_]


def binding_lanes(found: ScalingRange) -> list[Lane]:
    """The rows that bind along a motion: those that set the range over the motion first, then the most frequent.

    c² >= 0 alone at the lower ends of all samples is no news and takes no lane.

    Args:
        found: The range over the motion.
    """
    samples = found.samples
    conflicts: list[tuple[ActiveRow, ...]] = [()] * len(samples.time)
    for conflict in samples.conflicts:
        conflicts[conflict.sample] = tuple(row for row in conflict.rows if row.name.kind != "balance")
    lanes = _lanes("conflict", conflicts, ())
    lanes += _lanes("upper", *_rows(found, "upper"))
    lower = _lanes("lower", *_rows(found, "lower"))
    return lanes + ([] if {lane.label for lane in lower} <= {str(STANDSTILL)} else lower)


def _rows(found: ScalingRange, side: Side) -> tuple[list[tuple[ActiveRow, ...]], Sequence[ActiveRow]]:
    """The rows at one end of every sample, and those that set the end over the motion."""
    end = found.lower if side == "lower" else found.upper
    rows = [found.binding(sample, side) for sample in range(len(found.samples.time))]
    return rows, () if end is None else end.rows


def _lanes(kind: LaneKind, rows: Sequence[tuple[ActiveRow, ...]], first: Sequence[ActiveRow]) -> list[Lane]:
    labels = [{row_label(row) for row in of_sample} for of_sample in rows]
    counts = Counter(sorted(label for of_sample in labels for label in of_sample))
    setting = [label for label in dict.fromkeys(map(row_label, first)) if label in counts]
    order = setting + [label for label, _ in counts.most_common() if label not in setting]
    groups = {label: {label} for label in order}
    if len(order) > MOST_LANES:
        rest = order[MOST_LANES - 1 :]
        groups = {label: {label} for label in order[: MOST_LANES - 1]} | {f"{len(rest)} others": set(rest)}
    return [
        Lane(kind, label, label in setting, np.array([not group.isdisjoint(of_sample) for of_sample in labels]))
        for label, group in groups.items()
    ]


def infeasible_spans(samples: SampleRanges) -> list[tuple[float, float]]:
    """Spans of time where no c² keeps the limits [s]."""
    return spans(samples.time, np.array([status is RangeStatus.INFEASIBLE for status in samples.status]))


def spans(time: Array, where: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Spans of time of consecutive samples, each sample reaching half way to its neighbours.

    Args:
        time: Shape (N,) [s].
        where: Which samples count, Shape (N,).

    Returns:
        Start and end of every span [s].
    """
    edges = _edges(time)
    steps = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(int)))
    return [(float(edges[start]), float(edges[end])) for start, end in steps.reshape(-1, 2)]


def _edges(time: Array) -> Array:
    """Where samples begin and end that reach half way to their neighbours, Shape (N + 1,) [s]."""
    return np.concatenate([time[:1], (time[1:] + time[:-1]) / 2, time[-1:]])
