# SPDX-License-Identifier: MIT
"""The durations of a study over one or two of its numbers, which limit binds where, and how durations spread."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.words import first_names
from mrts.limits.rows import MOST_NAMES
from mrts.plots.labels import shortened
from mrts.plots.plot import COLOURS, MARGIN, Axis, HeatMap, Item, Line, Panel, Plot, Points, level, rectangles
from mrts.plots.range_plots import neighbours
from mrts.plots.study_table import (
    OUTCOMES,
    SHARES,
    Index,
    StudyTable,
    best_text,
    managed,
    managed_texts,
    outcome_text,
    variant_text,
)
from mrts.studies.variant_rows import LIMIT_SEPARATOR

FASTER = ("#fde725", "#aadc32", "#5ec962", "#28ae80", "#21918c", "#2c728e", "#3b528b", "#472d7b", "#440154")
"""Viridis from its end, bright is fast: ordered in grey and for every colour vision (van der Walt and Smith, 2015)."""

WITHOUT = {
    "unbounded": "#e3f1e9",
    "infeasible": "#bbb",
    "empty": "#a9a9a9",
    "unreachable": "#d9d9d9",
    "invalid": "#8d8d8d",
    "failed": "#6f6f6f",
}
"""Of what has no duration: greys, which no duration has."""

NEARLY_ALL, SEVERAL = 0.95, 3.0
"""Share of the durations, and times the shortest, that colours tell apart; longer ones look like the longest of these:
near a singularity a variant may take a hundred times as long as the best."""

WIDE = 10.0
"""Times the shortest duration from which an axis of durations is logarithmic."""

SAME = 0.01
"""Share of a duration by which an axis of durations that are all alike is wide."""

CELL_LETTERS = 80
"""Of a line of what is told of a cell."""

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


def study_map_plot(table: StudyTable) -> Plot:
    """The shortest duration and which limit binds, over the two numbers that matter most, or over the only one."""
    drawn = study_map(table)
    title = _title(table, map_remark(table, drawn))
    panels = [_line_panel(table, drawn)] if len(drawn.knobs) == 1 else _map_panels(table, drawn)
    return Plot(name="map" if len(drawn.knobs) > 1 else "line", title=title, rows=[panels])


def _title(table: StudyTable, *remarks: str) -> str:
    return "\n".join([f"{table.name}: {outcome_text(table)}", best_text(table), *filter(None, remarks)])


def _map_panels(table: StudyTable, drawn: StudyMap) -> list[Panel]:
    grid: dict[str, Any] = {"x": drawn.edges[0], "y": drawn.edges[1], "texts": _texts(table, drawn)}
    limits, binding = map_binding(table, drawn)
    greys = [WITHOUT.get(name, "#fff") for name in OUTCOMES]
    without = HeatMap(**grid, z=drawn.outcome, names=list(OUTCOMES), colors=greys)
    duration: list[Item] = []
    if len(table.ranked):
        durations = table.duration[table.ranked]
        most, median = np.quantile(durations, (NEARLY_ALL, 0.5))
        high = min(most, max(median, SEVERAL * durations[0]))
        duration = [HeatMap(**grid, z=drawn.durations(table), colors=FASTER, low=durations[0], high=high,
                            title="shortest duration [s]")]  # fmt: skip
    limit: list[Item] = (
        [HeatMap(**grid, z=binding, names=limits, colors=LIMIT_COLOURS[: len(limits)])] if limits else []
    )
    x, y = (_knob_axis(table, drawn, place) for place in (0, 1))
    best = _best(table, *(table.values[:, knob] for knob in drawn.knobs))
    return [
        Panel(title="Shortest duration", x=x, y=y, items=[*duration, without, *best]),
        Panel(title="What limits it", x=x, y=y, items=[*limit, without, *best]),
    ]


def _knob_axis(table: StudyTable, drawn: StudyMap, place: int) -> Axis:
    edges = drawn.edges[place]
    return Axis(label=table.knobs[drawn.knobs[place]].title, ends=(float(edges[0]), float(edges[-1])))


def _best(table: StudyTable, x: Array, y: Array) -> list[Item]:
    row = table.ranked[:1]
    return [Points(x=x[row], y=y[row], symbol="star", color="#fff", label="the best")] if len(row) else []


def _texts(table: StudyTable, drawn: StudyMap) -> list[list[str]]:
    texts = np.full(drawn.best.shape, "", dtype=object)
    for place, row in np.ndenumerate(drawn.best):
        if row >= 0:
            limits = table.limits(int(row))
            said = [
                variant_text(table, int(row)),
                *([f"limited by {first_names(limits, MOST_NAMES)}"] if limits else []),
            ]
            said += [
                f"{table.knobs[knob].path} = {table.values[row, knob]:.4g} {table.knobs[knob].unit}".rstrip()
                for knob in drawn.knobs
            ]
            texts[place] = "\n".join(shortened(each, CELL_LETTERS) for each in said)
        elif drawn.outcome[place] >= 0:
            texts[place] = ": ".join(list(OUTCOMES.items())[drawn.outcome[place]])
    return list(texts.tolist())


def _line_panel(table: StudyTable, drawn: StudyMap) -> Panel:
    (edges,), durations = drawn.edges, drawn.durations(table)
    limits, binding = map_binding(table, drawn)
    fills = [
        (binding == code, name, _pale(color))
        for code, (name, color) in enumerate(zip(limits, LIMIT_COLOURS, strict=False))
    ]
    fills += [(drawn.outcome == code, name, WITHOUT[name]) for code, name in enumerate(OUTCOMES) if name in WITHOUT]
    log = _spreads_widely(table)
    low, high = (np.nanmin(durations), np.nanmax(durations)) if len(table.ranked) else (0.0, 1.0)
    margin = MARGIN * ((high - low) or high)
    ends = (low / (1 + MARGIN), high * (1 + MARGIN)) if log else (low - margin, high + margin)
    items: list[Item] = [
        rectangles(neighbours(edges, where), *ends, label=name, color=color)
        for where, name, color in fills
        if np.any(where)
    ]
    middles = (edges[1:] + edges[:-1]) / 2
    items.append(Line(x=middles, y=durations, label="shortest duration", unit="s", color="#1b1b1b"))
    items += _best(table, table.values[:, drawn.knobs[0]], table.duration)
    y = Axis(label="duration [s]", log=log, ends=ends)
    return Panel(title="Shortest duration and what limits it", x=_knob_axis(table, drawn, 0), y=y, items=items)


def _spreads_widely(table: StudyTable) -> bool:
    durations = table.duration[table.ranked]
    return len(durations) > 0 and bool(durations[-1] > WIDE * durations[0])


def _pale(color: str) -> str:
    red, green, blue = (255 - (255 - int(color[at : at + 2], 16)) * 3 // 10 for at in (1, 3, 5))
    return f"#{red:02x}{green:02x}{blue:02x}"


def durations_plot(table: StudyTable) -> Plot:
    """Which share of all variants finishes within a duration."""
    title = _title(table, "; ".join(managed_texts(table)) if len(table.ranked) else "")
    if not len(table.ranked):
        return Plot(name="durations", title=title, rows=[[Panel(note="no variant has a duration")]])
    durations = table.duration[table.ranked]
    percent = 100 * np.arange(1, len(durations) + 1) / table.variants
    marks = [(share, end) for share in SHARES if (end := managed(table, share)) is not None]
    share, at = (np.array([mark[part] for mark in marks], dtype=np.float64) for part in (0, 1))
    ends = (float(durations[0]), max(float(durations[-1]), (1 + SAME) * float(durations[0])))
    x = Axis(label="shortest duration [s]", log=_spreads_widely(table), ends=ends, hover="{} s")
    items: list[Item] = [
        Line(x=durations, y=percent, label="finish within this duration", unit="%", steps=True),
        level(float(percent[-1]), x, color=COLOURS[1], dash=1, label="can be played at all"),
        Points(x=at, y=share),
    ]
    panel = Panel(x=x, y=Axis(label="share of all variants [%]", ends=(0.0, 104.0)), items=items)
    return Plot(name="durations", title=title, rows=[[panel]])
