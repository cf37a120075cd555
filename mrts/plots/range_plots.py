# SPDX-License-Identifier: MIT
"""c²⁻(t) and c²⁺(t), the range over the motion, which limits bind where."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.colours import COLOURS
from mrts.limits.rows import STANDSTILL, ActiveRow, Side
from mrts.plots.card import answer_card
from mrts.plots.plot import (
    ADMISSIBLE,
    CONFLICT,
    END_COLOURS,
    MARGIN,
    Axis,
    Band,
    Item,
    Line,
    Panel,
    Plot,
    Points,
    level,
    look,
    one_panel,
    rectangles,
    time_axis,
    upright,
)
from mrts.program.sample_ranges import RangeStatus
from mrts.scaling.range import ScalingRange
from mrts.scaling.scale import ScalingResult

LANE_HEIGHT = 0.72
"""Of a bar, in lanes."""

MOST_LANES = 14
"""Lanes of one end of the range; rows beyond share the last."""

GIVEN_TIME = "time of the given motion [s]"

ABOVE_THE_RANGE = 4.0
"""c²⁺(t) near rest can be thousands of times the range over the motion; it is followed up to this many times."""

SIDES: dict[Side, str] = {"upper": "c²⁺", "lower": "c²⁻"}

LaneKind = Literal["upper", "lower", "conflict"]

LANE_WORDS: dict[LaneKind, str] = {
    "conflict": "in conflict",
    "upper": "binds at c²⁺(t)",
    "lower": "binds at c²⁻(t)",
}


@dataclass(frozen=True)
class Lane:
    """Where a row binds, Shape (N,), of which kind, and whether it sets the range; rare rows share a lane."""

    kind: LaneKind
    label: str
    sets: bool
    binds: NDArray[np.bool_]


def range_plot(result: ScalingResult) -> Plot:
    """c²⁻(t) and c²⁺(t) above the rows that bind; what no c² satisfies is marked."""
    found = result.range
    rows = [[_range_panel(found)]]
    lanes = binding_lanes(found)
    if lanes:
        rows.append([_lane_panel(found, lanes)])
    title = f"{result.cell.name}: {answer_card(result).outcome}"
    return Plot(name="c2_range", title=title, rows=rows, shared=True, clock="given")


def _range_panel(found: ScalingRange) -> Panel:
    samples, (low, high) = found.samples, c2_ends(found)
    x, y = time_axis(samples.time, GIVEN_TIME), Axis(label="c² [1]", ends=(low, high))
    items: list[Item] = []
    infeasible = np.array([status is RangeStatus.INFEASIBLE for status in samples.status])
    if without := spans(samples.time, infeasible):
        items.append(rectangles(without, low, high, label="no c² at all"))
    if found.status.admits_motion:
        ends = (np.full(2, end) for end in (found.lower.c2, min(found.upper.c2, 2 * high)))
        items.append(Band(x=samples.time[[0, -1]], lower=next(ends), upper=next(ends), color=ADMISSIBLE, opacity=0.15,
                          label=f"range {found.text()}"))  # fmt: skip
    for side, name in SIDES.items():
        values, end, color = getattr(samples, side), getattr(found, side), END_COLOURS[side]
        texts = ["\n".join(row.label for row in found.binding(sample, side)) for sample in range(len(values))]
        dash = int(side == "lower")
        items.append(Line(x=samples.time, y=values, label=f"{name}(t)", color=color, dash=dash, texts=texts))
        if end.time is None or (side == "lower" and end.c2 <= 0):
            continue
        if found.status is RangeStatus.EMPTY:
            items.append(level(end.c2, x, color=color, dash=3))
        at, c2, text = np.array([end.time]), np.array([end.c2]), f"{name} = {end.c2:.4g}"
        items.append(Points(x=at, y=c2, color=color, texts=[text], below=side == "upper"))
    if samples.conflicts:
        worst = max(samples.conflicts, key=lambda conflict: conflict.widening)
        items.append(upright(worst.time, y, label="worst conflict", color=CONFLICT, dash=3))
    note = "no limit depends on the speed" if found.status is RangeStatus.UNBOUNDED else ""
    return Panel(x=x, y=y, items=items, note=note)


def _lane_panel(found: ScalingRange, lanes: Sequence[Lane]) -> Panel:
    time = found.samples.time
    names = Axis(
        names=[lane.label for lane in lanes],
        colors=[END_COLOURS[lane.kind] for lane in lanes],
        strong=[lane.sets for lane in lanes],
        ends=(len(lanes) - 0.4, -0.6),
    )
    items: list[Item] = []
    for kind, word in LANE_WORDS.items():
        bars = [(row, span) for row, lane in enumerate(lanes) if lane.kind == kind for span in spans(time, lane.binds)]
        if bars:
            row = np.array([row for row, _ in bars])
            sides = row - LANE_HEIGHT / 2, row + LANE_HEIGHT / 2
            items.append(rectangles([span for _, span in bars], *sides, color=END_COLOURS[kind], label=word))
    ends = [end.time for end in (found.lower, found.upper) if end.time is not None and end.c2 > 0]
    items += [upright(at, names, color=CONFLICT, dash=3) for at in ends]
    strong = " (bold: sets the range)" if any(lane.sets for lane in lanes) else ""
    title = f"Limits that bind: ↑ at the upper, ↓ at the lower side{strong}"
    return Panel(title=title, x=time_axis(time, GIVEN_TIME), y=names, items=items)


def c2_ends(found: ScalingRange) -> tuple[float, float]:
    """Ends of an axis that shows c²⁻(t), c²⁺(t) and the range over the motion."""
    upper, lower = (side[np.isfinite(side)] for side in (found.samples.upper, found.samples.lower))
    ends = [end.c2 for end in (found.lower, found.upper) if np.isfinite(end.c2)]
    wanted = max([*ends, float(np.min(upper)) if upper.size else 0.0, 0.0])
    highest = max([*upper.tolist(), *lower.tolist(), 0.0])
    top = (min(highest, ABOVE_THE_RANGE * wanted) if wanted > 0 else highest) or 1.0
    return -MARGIN * top, (1 + MARGIN) * top


def binding_lanes(found: ScalingRange) -> list[Lane]:
    """The rows that bind along a motion: those that set the range over the motion first, then the most frequent.

    c² >= 0 alone at the lower ends of all samples is no news and takes no lane.
    """
    samples = found.samples
    conflicts: list[tuple[ActiveRow, ...]] = [()] * len(samples.time)
    for conflict in samples.conflicts:
        conflicts[conflict.sample] = conflict.rows
    lanes = _lanes("conflict", conflicts, ())
    for side in SIDES:
        rows = [found.binding(sample, side) for sample in range(len(samples.time))]
        own = _lanes(side, rows, getattr(found, side).rows)
        lanes += [] if {lane.label for lane in own} <= {str(STANDSTILL)} else own
    return lanes


def _lanes(kind: LaneKind, rows: Sequence[tuple[ActiveRow, ...]], first: Sequence[ActiveRow]) -> list[Lane]:
    binds: dict[str, NDArray[np.bool_]] = {}
    for sample, of_sample in enumerate(rows):
        for row in of_sample:
            binds.setdefault(row.label, np.zeros(len(rows), dtype=bool))[sample] = True
    place = {label: number for number, label in enumerate(dict.fromkeys(row.label for row in first))}
    order = sorted(binds, key=lambda label: (place.get(label, len(place)), -np.count_nonzero(binds[label]), label))
    lanes = [Lane(kind, label, label in place, binds[label]) for label in order]
    if len(lanes) > MOST_LANES:
        rest = lanes[MOST_LANES - 1 :]
        together = np.any([lane.binds for lane in rest], axis=0)
        lanes[MOST_LANES - 1 :] = [Lane(kind, f"{len(rest)} others", sets=False, binds=together)]
    return lanes


def spans(time: Array, where: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Start and end [s] of spans of samples that count, Shape (N,), each reaching half way to its neighbours."""
    edges = np.concatenate([time[:1], (time[1:] + time[:-1]) / 2, time[-1:]])
    steps = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(int)))
    return [(float(edges[start]), float(edges[end])) for start, end in steps.reshape(-1, 2)]


def load_plot(results: Mapping[str, ScalingResult]) -> Plot:
    """c²⁺(t) of results by label, such as "nominal" and "guaranteed", and how fast each lets the motion be played."""
    items: list[Item] = []
    for index, (label, result) in enumerate(results.items()):
        found = result.range
        time, end, admits = found.samples.time, found.upper, found.status.admits_motion
        reach = f"c²⁺ = {end.c2:.4g}" if np.isfinite(end.c2) and admits else found.status.value
        items.append(Line(x=time, y=found.samples.upper, label=f"{label} ({reach})", **look(index)))
        if end.time is not None:
            at, c2 = np.array([end.time]), np.array([end.c2])
            items.append(Points(x=at, y=c2, color=COLOURS[index % len(COLOURS)]))
    y = Axis(label="largest c² [1]", ends=(0.0, max(c2_ends(result.range)[1] for result in results.values())))
    panel = Panel(title="Largest c² at each sample", x=time_axis(time, GIVEN_TIME), y=y, items=items)
    return one_panel("loads", panel, "given")
