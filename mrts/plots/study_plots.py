# SPDX-License-Identifier: MIT
"""The durations of a study over each of its numbers, and how they spread."""

from math import isqrt

import numpy as np

from mrts.plots.plot import COLOURS, Axis, Item, Line, Panel, Plot, Points, level
from mrts.plots.study_table import (
    SHARES,
    StudyTable,
    best_text,
    managed,
    managed_texts,
    outcome_text,
    variant_text,
)

WIDE = 10.0
"""Times the shortest duration from which an axis of durations is logarithmic."""

SAME = 0.01
"""Share of a duration by which an axis of durations that are all alike is wide."""

MOST_VALUES = 120
"""Different values of a number that are drawn one by one; of more, neighbours share a point."""


def numbers_plot(table: StudyTable) -> Plot:
    """The shortest duration over each number; where its values are no grid, the best of neighbours is drawn."""
    panels = [_number_panel(table, number) for number in range(len(table.knobs))]
    rows = [panels[at : at + 2] for at in range(0, len(panels), 2)]
    return Plot(name="numbers", title=_title(table), rows=rows)


def _title(table: StudyTable, *remarks: str) -> str:
    return "\n".join([f"{table.name}: {outcome_text(table)}", best_text(table), *filter(None, remarks)])


def _number_panel(table: StudyTable, number: int) -> Panel:
    name, values = table.knobs[number].title, table.values[:, number]
    if not len(table.ranked):
        return Panel(x=Axis(label=name), note="no variant has a duration")
    places, group = np.unique(values, return_inverse=True)
    in_grid = len(places) < table.variants or len(table.knobs) == 1
    most = MOST_VALUES if in_grid else min(MOST_VALUES, max(2, isqrt(table.variants)))
    if len(places) > most:
        edges = np.linspace(places[0], places[-1], most + 1)
        places, group = (edges[1:] + edges[:-1]) / 2, np.searchsorted(edges[1:-1], values, "right")
    best = np.full(len(places), -1)
    best[group[table.ranked[::-1]]] = table.ranked[::-1]  # the last one written stays: the best
    texts = [variant_text(table, row) if row >= 0 else "" for row in best.tolist()]
    duration = np.where(best >= 0, table.duration[best], np.nan)
    first = table.ranked[:1]
    items: list[Item] = [
        Line(x=places, y=duration, unit="s", texts=texts),
        Points(x=values[first], y=table.duration[first], symbol="star", color="#fff"),
    ]
    y = Axis(label="duration [s]")
    return Panel(
        title="Shortest duration (star: the best)", x=Axis(label=name, hover=f"{name} = {{}}"), y=y, items=items
    )


def _spreads_widely(table: StudyTable) -> bool:
    durations = table.duration[table.ranked]
    return len(durations) > 0 and bool(durations[-1] > WIDE * durations[0])


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
