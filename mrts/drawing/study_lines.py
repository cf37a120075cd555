# SPDX-License-Identifier: MIT
"""Variants as lines through parallel axes, one for each number and the last for the duration."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.drawing.study_map import duration_ends, weights
from mrts.drawing.study_table import Index, StudyTable
from mrts.drawing.study_words import best_part

MOST_AXES = 10
"""Numbers that get an axis: those that matter most."""

MOST_LINES = 200
"""Of the best, of the others, and of those without a duration, each."""

NO_DURATION = 1.12
"""Where variants without a duration meet the last axis; the longest shown is at 1."""


@dataclass(frozen=True)
class ParallelAxes:
    """Axes and lines.

    Attributes:
        knobs: Indices of the numbers with an axis, in the study's order.
        low: Least value on each axis, that of the durations last, Shape (A + 1,).
        high: Largest value, likewise.
        best: Rows of the best that are drawn, the best first.
        others: Rows of others with a duration.
        without: Rows without.
        all_drawn: Whether these are all variants.
    """

    knobs: tuple[int, ...]
    low: Array
    high: Array
    best: Index
    others: Index
    without: Index
    all_drawn: bool

    def remark(self, table: StudyTable) -> str:
        """What is drawn, where that is not everything; else nothing."""
        remarks = []
        if len(self.knobs) < len(table.knobs):
            remarks.append(f"the {len(self.knobs)} of {len(table.knobs)} numbers that matter most")
        if not self.all_drawn:
            drawn = len(self.best) + len(self.others) + len(self.without)
            remarks.append(f"an even choice of {drawn} of {table.variants} variants")
        return ", ".join(remarks)

    def heights(self, table: StudyTable, rows: Index) -> Array:
        """Where lines meet the axes: 0 at the least value, 1 at the largest; Shape (len(rows), A + 1)."""
        values = np.column_stack([table.values[rows][:, self.knobs], table.duration[rows]])
        span = self.high - self.low
        share = np.where(span > 0, (values - self.low) / np.where(span > 0, span, 1), 0.5)
        share[:, -1] = np.where(np.isnan(values[:, -1]), NO_DURATION, np.minimum(share[:, -1], 1))
        return share


def parallel_axes(table: StudyTable) -> ParallelAxes:
    """Choose axes and lines.

    Args:
        table: The study, with at least one variant.
    """
    knobs = tuple(sorted(weight.knob for weight in weights(table)[:MOST_AXES]))
    ends = duration_ends(table) if len(table.ranked) else (0.0, 1.0)
    shown = table.values[:, knobs]
    first = len(best_part(table))
    groups = (
        table.ranked[:first],
        table.ranked[first:],
        np.flatnonzero(~np.isin(np.arange(table.variants), table.ranked)),
    )
    best, others, without = (_some(rows) for rows in groups)
    return ParallelAxes(
        knobs=knobs,
        low=np.append(np.min(shown, axis=0), ends[0]),
        high=np.append(np.max(shown, axis=0), ends[1]),
        best=best,
        others=others,
        without=without,
        all_drawn=len(best) + len(others) + len(without) == table.variants,
    )


def _some(rows: Index) -> Index:
    """All, or an even choice with the first."""
    if len(rows) <= MOST_LINES:
        return rows
    return np.asarray(rows[np.linspace(0, len(rows) - 1, MOST_LINES).round().astype(int)])
