# SPDX-License-Identifier: MIT
"""The variants of a study laid out over one or two of its numbers, and how much each number matters."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.plots.colours import COLOURS
from mrts.plots.study_table import Index, StudyTable

LIMIT_COLOURS = (*COLOURS[:6], "#999999")
"""Of the limits that bind on a map; rarer ones share the last."""

NEARLY_ALL, SEVERAL = 0.95, 3.0
"""Share of the durations, and times the shortest, that colours tell apart; longer ones look like the longest of these:
near a singularity a variant may take a hundred times as long as the best."""

WIDE = 10.0
"""Times the shortest duration from which an axis of durations is logarithmic."""

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

OUTERMOST = 0.02
"""Share of a number's range, at either end, in which a value counts as at the end."""


@dataclass(frozen=True)
class Cells:
    """The cells of one axis.

    Attributes:
        knob: Index of the number.
        edges: Where they begin and end, Shape (cells + 1,).
        exact: Whether each holds one value.
        cell: In which cell each variant is, Shape (V,).
    """

    knob: int
    edges: Array
    exact: bool
    cell: Index

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.edges) - 1

    @property
    def middles(self) -> Array:
        """Shape (cells,)."""
        return np.asarray((self.edges[1:] + self.edges[:-1]) / 2)


@dataclass(frozen=True)
class StudyMap:
    """The best variant of every cell over one or two numbers.

    Attributes:
        axes: Of the first number, then of the second where there are two.
        best: Row of the best variant in each cell, -1 where none has a duration; Shape (cells of the last, …, first).
        outcome: What became of most variants of a cell without a best, as a code; -1 where there is one, or no variant.
        others: How many other numbers were varied: the best of a cell is that over them.
    """

    axes: tuple[Cells, ...]
    best: Index
    outcome: Index
    others: int

    def of_best(self, column: Array) -> Array:
        """A column's value of the best in each cell, NaN where there is none; Shape of `best`.

        Args:
            column: Shape (V,).
        """
        return np.where(self.best >= 0, column[self.best], np.nan)

    @property
    def exact(self) -> bool:
        """Whether every cell holds one value of each number."""
        return all(cells.exact for cells in self.axes)


def study_map(table: StudyTable, over: Sequence[str] = ()) -> StudyMap:
    """Lay out a study over one or two of its numbers.

    Args:
        table: The study, with at least one variant and one number.
        over: Their paths; without any, all, or the two that matter most.

    Raises:
        InputError: If the study does not vary them.
    """
    knobs = _knobs(table, over)
    different = [np.unique(table.values[:, knob]) for knob in knobs]
    counts = [len(values) for values in different]
    whole = max(counts) <= MOST_VALUES and np.prod(counts) <= MOST_EMPTY * table.variants
    most = int(np.clip((table.variants / VARIANTS_A_CELL) ** (1 / len(knobs)), 2, MOST_CELLS))
    axes = tuple(
        _cells(table.values[:, knob], knob, values, MOST_VALUES if whole else most)
        for knob, values in zip(knobs, different, strict=True)
    )
    shape = tuple(cells.count for cells in reversed(axes))
    place = np.ravel_multi_index([cells.cell for cells in reversed(axes)], shape)
    best = np.full(np.prod(shape), -1)
    best[place[table.ranked[::-1]]] = table.ranked[::-1]  # the last one written stays: the best
    without = np.flatnonzero(~np.isin(np.arange(table.variants), table.ranked))
    kinds = len(table.outcome.names)
    became = np.bincount(place[without] * kinds + table.outcome.codes[without], minlength=kinds * len(best))
    became = became.reshape(-1, kinds)
    outcome = np.where((best < 0) & (np.sum(became, axis=1) > 0), np.argmax(became, axis=1), -1)
    return StudyMap(axes, best.reshape(shape), outcome.reshape(shape), len(table.knobs) - len(knobs))


def _knobs(table: StudyTable, over: Sequence[str]) -> list[int]:
    if not over:
        return sorted(weight.knob for weight in weights(table)[:2])
    paths = [knob.path for knob in table.knobs]
    if len(over) > 2 or len(set(over)) < len(over) or not set(over) <= set(paths):  # noqa: PLR2004 (of a picture)
        raise InputError("over", f"must be one or two of what the study varies: {', '.join(paths)}.", value=list(over))
    return [paths.index(path) for path in over]


def _cells(column: Array, knob: int, values: Array, most: int) -> Cells:
    """A cell for each of the different values, or cells of one width."""
    exact = len(values) <= most
    if len(values) == 1:
        half = abs(values[0]) / 2 or 0.5
        edges = np.array([values[0] - half, values[0] + half])
    elif exact:
        middles = (values[1:] + values[:-1]) / 2
        edges = np.concatenate([[2 * values[0] - middles[0]], middles, [2 * values[-1] - middles[-1]]])
    else:
        edges = np.linspace(values[0], values[-1], most + 1)
    return Cells(knob, edges, exact, np.asarray(np.searchsorted(edges[1:-1], column, "right")))


@dataclass(frozen=True)
class Weight:
    """How much one number of a study matters.

    Attributes:
        knob: Index of the number.
        duration: Share of the spread of the durations that it explains by itself, 0 to 1.
        playable: Likewise, of whether a variant may be played at all.
    """

    knob: int
    duration: float
    playable: float

    @property
    def larger(self) -> float:
        """The larger of both."""
        return max(self.duration, self.playable)


def weights(table: StudyTable) -> list[Weight]:
    """How much each number matters by itself, the most first.

    The durations are replaced by their ranks, and the variants sorted into groups by the number's value; what the means
    of the groups spread, of what all spread, is the correlation ratio ε² (Kelley, 1935): the first-order index of
    Sobol, corrected for the number of groups. What numbers do only together, it does not see.
    """
    some = np.arange(table.variants)
    if table.variants > MOST_WEIGHED:  # by chance: an even choice would keep time with a grid
        some = np.sort(np.random.default_rng(0).choice(table.variants, MOST_WEIGHED, replace=False))
    has = np.isin(some, table.ranked)
    rank = np.empty(np.count_nonzero(has))
    rank[np.argsort(table.duration[some[has]], kind="stable")] = np.arange(len(rank))
    playable = table.admitted[some].astype(np.float64)
    groups = [_groups(table.values[some, knob]) for knob in range(len(table.knobs))]
    found = [
        Weight(knob, _explained(rank, group[has]), _explained(playable, group)) for knob, group in enumerate(groups)
    ]
    return sorted(found, key=lambda weight: -weight.larger)


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


def ends_reached(table: StudyTable, row: int) -> list[tuple[int, str]]:
    """Which numbers of a variant lie at an end of what was tried, and whether at the "lower" or "upper" one."""
    low, high = np.min(table.values, axis=0), np.max(table.values, axis=0)
    at = (table.values[row] - low) / np.where(high > low, high - low, np.inf)
    return [
        (knob, "lower" if at[knob] <= OUTERMOST else "upper")
        for knob in np.flatnonzero((high > low) & ((at <= OUTERMOST) | (at >= 1 - OUTERMOST))).tolist()
        if not table.knobs[knob].by_chance
    ]


def duration_ends(table: StudyTable) -> tuple[float, float]:
    """The shortest duration, and the longest that is worth a colour of its own [s].

    Args:
        table: The study, with a variant that has a duration.
    """
    durations = table.duration[table.ranked]
    most, median = np.quantile(durations, (NEARLY_ALL, 0.5))
    return float(durations[0]), float(min(most, max(median, SEVERAL * durations[0])))


def spreads_widely(table: StudyTable) -> bool:
    """Whether an axis of durations is better logarithmic.

    Args:
        table: The study, with a variant that has a duration.
    """
    durations = table.duration[table.ranked]
    return bool(durations[-1] > WIDE * durations[0])


def map_remark(table: StudyTable, drawn: StudyMap) -> str:
    """What a cell of the map stands for; nothing where each is one variant."""
    if drawn.exact and not drawn.others:
        return ""
    shape = " × ".join(str(cells.count) for cells in drawn.axes)
    text = f"each of {shape} cells shows the best of its variants"
    if drawn.others:
        most = " and ".join(table.knobs[cells.knob].path for cells in drawn.axes)
        text += f", over {drawn.others} other number{'s' * (drawn.others > 1)}; {most} matter most"
    return text


def map_binding(table: StudyTable, drawn: StudyMap) -> tuple[list[str], Index]:
    """Which limit binds at c²⁺ of the best in each cell of a map; of several at once, the first.

    Returns:
        Names, the most frequent first, at most as many as there are colours: the last may stand for several; and the
        number of each cell's, -1 where there is none, Shape of the map.
    """
    firsts = [name.split(", ")[0] for name in table.limit.names]
    first = {name: code for code, name in enumerate(dict.fromkeys(firsts))}
    of_variant = np.array([*(first[name] for name in firsts), -1])[table.limit.codes]
    limits = np.where(drawn.best >= 0, of_variant[drawn.best], -1)
    found, count = np.unique(limits[limits >= 0], return_counts=True)
    order = found[np.argsort(-count, kind="stable")]
    names, most = [list(first)[code] for code in order], len(LIMIT_COLOURS)
    if len(order) > most:
        names = [*names[: most - 1], f"{len(order) - most + 1} other limits"]
    place = np.full(len(first) + 1, -1)
    place[order] = np.minimum(np.arange(len(order)), most - 1)
    return names, place[limits]
