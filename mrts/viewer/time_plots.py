# SPDX-License-Identifier: MIT
"""Plots along time in the viewer's panel: the range of c² and the use of each limit; needs the extra 'view'.

The cursor is a line over every plot that stands where one number says, which a style sheet of a few letters sets: so it
follows a motion at any rate, and the plots are sent only when they change.
"""

from typing import Any

import numpy as np
import viser

from mrts.base.errors import html_text
from mrts.control.simulate import Simulation
from mrts.plots.plan_plots import closed_loop_panel
from mrts.plots.plot import END_COLOURS, Axis, Line, Panel, level, shortened, time_axis
from mrts.plots.plotly_drawer import shown_samples
from mrts.plots.range_plots import c2_ends
from mrts.plots.trajectory_plots import limits_plot
from mrts.scaling.scale import ScalingResult
from mrts.viewer.workbench import Answer

HEIGHT = 130
"""Of a plot [pixels]."""

LETTERS = 32
"""Of a line's name."""

RENEWAL = 0.2
"""Time between new plots while a slider moves [s]: they are some hundred thousand numbers."""

OVER = "#F03E3E"


def time_panels(result: ScalingResult, simulation: Simulation | None = None) -> dict[str, Panel]:
    """What is plotted of a result with a trajectory, and of it in closed loop, by title."""
    done, found = result.done, result.range
    x = time_axis(done.time)
    c2 = [
        Line(x=done.time, y=getattr(found.samples, side), label=label, color=END_COLOURS[side])
        for side, label in (("upper", "at most"), ("lower", "at least"))
    ]
    c2.append(level(done.c2, x, label=f"chosen c² = {done.c2:.4g}", color=OVER))
    panels = [
        Panel(title="Range of c² of each sample", x=x, y=Axis(ends=c2_ends(found)), items=c2),
        *([] if simulation is None else [closed_loop_panel(simulation)]),
        *(panel for row in limits_plot(result).rows for panel in row),
    ]
    return {panel.title: panel for panel in panels}


def uplot_props(panel: Panel) -> dict[str, Any]:
    """A panel with the ends of both axes as viser's plot: its lines."""
    lines = [item for item in panel.items if isinstance(item, Line)]
    lines.sort(key=lambda line: line.unit is not None)  # those without a name below the others
    (start, end), (low, high) = panel.x.ends or (0.0, 1.0), panel.y.ends or (0.0, 1.0)
    x = np.unique(np.concatenate([line.x[shown_samples(len(line.x), line.y)] for line in lines]))
    y = [np.interp(x, line.x, np.clip(line.y, low, high)) for line in lines]
    series = [{"label": line.label, "stroke": line.color, "width": 1.5, "points": {"show": False}} for line in lines]
    return {
        "data": (x, *y),
        "series": ({"label": panel.x.label}, *series),
        "scales": {"x": {"time": False, "range": (start, end)}, "y": {"range": (low, high)}},
    }


def names_html(panel: Panel) -> str:
    """The names of its lines in their colours."""
    return " ".join(
        f'<span style="color:{item.color}">●</span>&nbsp;{html_text(shortened(item.label, LETTERS))}&ensp;'
        for item in panel.items
        if isinstance(item, Line) and item.label
    )


class PlotPanel:
    """Plots that follow what is shown, with a cursor at its time.

    Attributes:
        cursor: The style sheet that says where it stands.
        at: Where the next step puts it, as a share of the time: apart from what the scene sends together.
    """

    def __init__(self, gui: viser.GuiApi, tab: viser.GuiTabHandle) -> None:
        self._gui, self._tab = gui, tab
        self.cursor = gui.add_html("")
        self._plots: dict[str, tuple[viser.GuiHtmlHandle, viser.GuiUplotHandle, viser.GuiHtmlHandle]] = {}
        self._wanted: Answer | None = None
        self._since, self.at = RENEWAL, 0.0

    def show(self, answer: Answer) -> None:
        """Plot an answer as soon as the last plots have been seen."""
        self._wanted = answer

    def step(self, elapsed: float) -> None:
        """Plot what waits."""
        self._since += elapsed
        if self._wanted is not None and self._since >= RENEWAL:
            state, found = self._wanted.state, self._wanted.simulation
            simulation = found if isinstance(found, Simulation) else None
            self._show({} if state is None else time_panels(state.played, simulation))
            self._wanted, self._since = None, 0.0
        style = f"<style>:root {{ --mrts-cursor: {self.at:.4f}; }}</style>"
        if style != self.cursor.content:
            self.cursor.content = style

    def _show(self, panels: dict[str, Panel]) -> None:
        for name, handles in self._plots.items():
            for handle in handles:
                handle.visible = name in panels
        for name, panel in panels.items():
            props = uplot_props(panel)
            if name not in self._plots:
                text = html_text(", ".join(filter(None, [name, panel.y.label])))
                title = f'<div data-plot="{html_text(name)}" class="title">{text}</div>'
                with self._tab:
                    self._plots[name] = (
                        self._gui.add_html(title),
                        self._gui.add_uplot(
                            **props, height=HEIGHT, legend={"show": False}, padding=(6, 10, 0, 0),
                            cursor={"drag": {"x": False, "y": False}}, axes=({"size": 24}, {"size": 44}),
                        ),
                        self._gui.add_html(""),
                    )  # fmt: skip
            _, drawn, names = self._plots[name]
            names.content = f'<div data-plot="names" class="names">{names_html(panel)}</div>'
            for key, value in props.items():
                setattr(drawn, key, value)
