# SPDX-License-Identifier: MIT
"""How much of every limit is used all along the trajectory, as a map of per cents."""

import numpy as np

from mrts.base.arrays import Array
from mrts.drawing.colours import COLOURS
from mrts.drawing.labels import shortened_apart
from mrts.report.limiting import LimitingRows
from mrts.report.markup import plot_text
from mrts.report.plots import Plot, layout, numbers
from mrts.scaling.limit_use import used_shares
from mrts.scaling.result import ScalingResult
from mrts.timing.smooth_piece import BINDING as AT_LIMIT

MOST_ROWS = 24
"""Limits that are drawn, those of which most is used."""

MOST_TIMES = 200
"""Columns of the map; each has the largest use of the samples in it."""

ROW_HEIGHT = 22
"""[px]."""

BELOW, REACHED, SETTING = 99.9, 100.0, 100.4
"""What is drawn of a limit that is not quite reached, of one that is, and of one that is where the speed is set [%]."""

SCALE = (
    *((0.0, "#fff"), (0.5, "#9fcbe6"), (99.95 / SETTING, "#0072B2")),
    *((99.95 / SETTING, COLOURS[4]), (100.2 / SETTING, COLOURS[4])),
    *((100.2 / SETTING, COLOURS[1]), (1.0, COLOURS[1])),
)

TITLE = "Orange: at the limit where the speed is set. Yellow: at the limit through the distribution"


def limit_map(result: ScalingResult, limiting: LimitingRows) -> Plot:
    """The map, of the limits of which most is used, those that set the speed first.

    Args:
        result: A result with a trajectory.
        limiting: Which rows set its speed, and where.

    Raises:
        ValueError: If there is no trajectory.
    """
    if result.trajectory is None:
        raise ValueError("there is no trajectory to draw")
    names, shares = used_shares(result.trajectory)
    time = result.trajectory.time
    reached = shares >= 1 - AT_LIMIT
    percents = np.where(reached, REACHED, np.minimum(100 * shares, BELOW))
    percents[reached & limiting.forced] = SETTING
    most = np.max(shares, axis=0)
    order = sorted(range(len(names)), key=lambda row: (names[row] not in limiting.setting, -most[row]))[:MOST_ROWS]
    edges, columns = _columns(time, percents[:, order])
    labels = shortened_apart([names[row].short for row in order])
    shape = layout("time [s]", "", (len(order) - 0.5, -0.5))
    shape["hovermode"] = "closest"
    shape["xaxis"] |= {"showgrid": False, "range": numbers(time[[0, -1]])}
    shape["yaxis"] |= {
        "tickvals": list(range(len(order))),
        "ticktext": [plot_text(label) for label in labels],
        "tickfont": {"size": 11},
        "automargin": True,
        "fixedrange": True,
        "showgrid": False,
    }
    cells = {
        "type": "heatmap",
        "x": numbers(edges),
        "y": list(range(len(order))),
        "z": np.round(columns.T, 1).tolist(),
        "zmin": 0,
        "zmax": SETTING,
        "colorscale": [list(step) for step in SCALE],
        "colorbar": {"title": {"text": "%"}, "thickness": 12},
        "hovertemplate": "%{z:.0f} %<br>t = %{x:.4g} s<extra>%{y}</extra>",
        "ygap": 1,
    }
    return Plot("limit-map", TITLE, [cells], shape, 110 + ROW_HEIGHT * len(order), "played")


def _columns(time: Array, shares: Array) -> tuple[Array, Array]:
    """Edges of columns of about one width, and the largest share of the samples that touch each."""
    count = min(len(time) - 1, MOST_TIMES)
    starts = np.unique(np.searchsorted(time, np.linspace(time[0], time[-1], count + 1)[:-1], side="right") - 1)
    edges = np.append(time[starts], time[-1])
    ends = np.append(starts[1:], len(time) - 1)
    largest = [np.max(shares[start : end + 1], axis=0) for start, end in zip(starts, ends, strict=True)]
    return edges, np.stack(largest)
