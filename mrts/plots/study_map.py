# SPDX-License-Identifier: MIT
"""The variants of a study laid out over one or two of its numbers, and how much each number matters."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.plots.colours import COLOURS
from mrts.plots.study_table import OUTCOMES, Index, StudyTable
from mrts.studies.variant_rows import LIMIT_SEPARATOR

LIMIT_COLOURS = (*COLOURS[:6], "#999999")
"""Of the limits that bind on a map; rarer ones share the last."""

MOST_VALUES = 120
"""Different values of a number that are shown one by one; of more, neighbours share a cell."""

MOST_EMPTY = 4
"""Cells of a grid for each variant at most: points that were drawn by chance share cells instead."""

MOST_CELLS = 60
VARIANTS_A_CELL = 6
"""Where neighbours share a cell: cells along an axis at most, and variants in each on average at least."""

GROUPS = 20
"""Into which the values of a number are sorted to see how much it explains."""

MOST_WEIGHED = 100_000
"""Variants by which it is told how much a number explains: more do not change a per cent of it."""


@dataclass(frozen=True, eq=False)
class StudyMap:
    """The best variant of every cell over one or two numbers.

    Attributes:
        knobs: Indices of the numbers.
        edges: Where their cells begin and end, Shape (cells + 1,) each.
        exact: Whether every cell holds one value of each number.
        best: Row of the best variant in each cell, -1 where none has a duration; Shape (cells of the last, …, first).
        outcome: What became of most variants of a cell without a best, as of `StudyTable.outcome`; -1 elsewhere.
    """

    knobs: list[int]
    edges: list[Array]
    exact: bool
    best: Index
    outcome: Index

    def durations(self, table: StudyTable) -> Array:
        """Of the best in each cell [s], NaN where there is none."""
        return np.where(self.best >= 0, table.duration[self.best], np.nan)


def study_map(table: StudyTable) -> StudyMap:
    """Lay out a study, with at least one variant and one number, over its numbers, or the two that matter most."""
    knobs = sorted(np.argsort(-np.max(weights(table), axis=1), kind="stable")[:2].tolist())
    different = [np.unique(table.values[:, knob]) for knob in knobs]
    counts = [len(values) for values in different]
    whole = max(counts) <= MOST_VALUES and np.prod(counts) <= MOST_EMPTY * table.variants
    most = MOST_VALUES if whole else int(np.clip((table.variants / VARIANTS_A_CELL) ** (1 / len(knobs)), 2, MOST_CELLS))
    edges = [_edges(values, most) for values in different]
    shape = [len(of_axis) - 1 for of_axis in reversed(edges)]
    cells = [
        np.searchsorted(of_axis[1:-1], table.values[:, knob], "right")
        for knob, of_axis in zip(knobs, edges, strict=True)
    ]
    place = np.ravel_multi_index(cells[::-1], shape)
    best = np.full(np.prod(shape), -1)
    best[place[table.ranked[::-1]]] = table.ranked[::-1]  # the last one written stays: the best
    without = np.setdiff1d(np.arange(table.variants), table.ranked)
    became = np.zeros((len(best), len(OUTCOMES)), dtype=int)
    np.add.at(became, (place[without], table.outcome[without]), 1)
    outcome = np.where((best < 0) & np.any(became, axis=1), np.argmax(became, axis=1), -1)
    return StudyMap(knobs, edges, max(counts) <= most, best.reshape(shape), outcome.reshape(shape))


def _edges(values: Array, most: int) -> Array:
    if len(values) > most:
        return np.linspace(values[0], values[-1], most + 1)
    if len(values) == 1:
        return values + np.array([-0.5, 0.5]) * (abs(values[0]) or 1.0)
    middles = (values[1:] + values[:-1]) / 2
    return np.concatenate([[2 * values[0] - middles[0]], middles, [2 * values[-1] - middles[-1]]])


def weights(table: StudyTable) -> Array:
    """Shares of the spread of durations, and of playability, that each number explains by itself, Shape (P, 2).

    The durations are replaced by their ranks, and the variants sorted into groups by the number's value; what the means
    of the groups spread, of what all spread, is the correlation ratio ε² (Kelley, 1935): the first-order index of
    Sobol, corrected for the number of groups. What numbers do only together, it does not see.
    """
    some = np.arange(table.variants)
    if table.variants > MOST_WEIGHED:  # by chance: an even choice would keep time with a grid
        some = np.sort(np.random.default_rng(0).choice(table.variants, MOST_WEIGHED, replace=False))
    has = np.isin(some, table.ranked)
    _, place, alike = np.unique(table.duration[some[has]], return_inverse=True, return_counts=True)
    rank = (np.cumsum(alike) - (alike + 1) / 2)[place]  # equal durations share the mean of their ranks
    playable = table.admitted[some].astype(np.float64)
    groups = [_groups(column) for column in table.values[some].T]
    return np.array([[_explained(rank, group[has]), _explained(playable, group)] for group in groups])


def _groups(column: Array) -> Index:
    """Groups of about equal size, by value; values that are equal share one."""
    values = np.unique(column)
    ends = values[1:] if len(values) <= GROUPS else np.quantile(column, np.arange(1, GROUPS) / GROUPS)
    return np.asarray(np.searchsorted(ends, column, "right"))


def _explained(values: Array, group: Index) -> float:
    """ε², at least 0; 0 where nothing spreads."""
    size = np.bincount(group)
    free = len(values) - np.count_nonzero(size)
    total = float(np.sum((values - np.mean(values)) ** 2)) if len(values) else 0.0
    if total <= 0 or free <= 0:
        return 0.0
    means = np.bincount(group, values) / np.maximum(size, 1)
    within = float(np.sum((values - means[group]) ** 2))
    return max(0.0, float(1 - within / free / (total / (len(values) - 1))))


def map_remark(table: StudyTable, drawn: StudyMap) -> str:
    """What a cell of the map stands for; nothing where each is one variant."""
    others = len(table.knobs) - len(drawn.knobs)
    if drawn.exact and not others:
        return ""
    shape = " × ".join(map(str, reversed(drawn.best.shape)))
    text = f"each of {shape} cells shows the best of its variants"
    if others:
        most = " and ".join(table.knobs[knob].path for knob in drawn.knobs)
        text += f", over {others} other number{'s' * (others > 1)}; {most} matter most"
    return text


def map_binding(table: StudyTable, drawn: StudyMap) -> tuple[list[str], Index]:
    """Which limit binds at c²⁺ of the best in each cell of a map; of several at once, the first.

    Returns:
        Names, the most frequent first, at most as many as there are colours: the last may stand for several; and the
        number of each cell's, -1 where there is none, Shape of the map.
    """
    has, most = drawn.best >= 0, len(LIMIT_COLOURS)
    limits = table.rows["upper_limit"].iloc[drawn.best[has]].astype(object).str.split(LIMIT_SEPARATOR).str[0]
    names = list(limits.value_counts().index)
    place = {name: min(code, most - 1) for code, name in enumerate(names)}
    codes = np.full(drawn.best.shape, -1)
    codes[has] = [place.get(name, -1) for name in limits]
    if len(names) > most:
        names = [*names[: most - 1], f"{len(names) - most + 1} other limits"]
    return names, codes
