# SPDX-License-Identifier: MIT
"""How soon and how far on a plan stops, along its time."""

import numpy as np

from mrts.override.stops import Stops
from mrts.plots.plot import Axis, Line, Panel, Plot, time_axis, value_ends


def stops_plot(stops: Stops) -> Plot:
    """Time and way of the longest stop from every place of a plan."""
    drawn = (("stop time", "ms", 1e3 * stops.stop_time), ("stop distance", "mm", 1e3 * stops.distance))
    rows = []
    for name, unit, y in drawn:
        ends = value_ends(y[np.isfinite(y)], np.empty(0))
        y_axis = Axis(label=f"{name} [{unit}]", ends=ends)
        rows.append([Panel(x=time_axis(stops.time), y=y_axis, items=[Line(x=stops.time, y=y, unit=unit)])])
    return Plot(name="stops", title=f"{stops.cell}: {stops.sentence()}", rows=rows, shared=True, clock="played")
