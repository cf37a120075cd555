# SPDX-License-Identifier: MIT
"""Plots along time in the viewer's panel: the range of c², the use of each limit, the speed; needs the extra 'view'.

The cursor is a line over every plot that stands where one number says, which a style sheet of a few letters sets: so it
follows a motion at any rate, and the plots are sent only when they change.
"""

from typing import Any

import numpy as np
import viser

from mrts.base.printable import html_text
from mrts.plots.colours import END_COLOURS
from mrts.plots.labels import shortened
from mrts.plots.limit_plots import limits_plot
from mrts.plots.limit_shares import played
from mrts.plots.plot import Axis, Line, Panel, Rule
from mrts.plots.plotly_drawer import shown_samples
from mrts.plots.range_plots import c2_ends
from mrts.scaling.result import ScalingResult
from mrts.viewer.player_state import PlayerState

HEIGHT = 130
"""Of a plot [pixels]."""

HEADROOM = 1.06
"""Upper edge of the phase plane by the highest value in it."""

LETTERS = 32
"""Of a line's name."""

RENEWAL = 0.2
"""Time between new plots while a slider moves [s]: they are some hundred thousand numbers."""

OVER, FAINT = "#F03E3E", "#8888"

PHASE = "Phase plane: speed along the path"


def time_panels(result: ScalingResult) -> dict[str, Panel]:
    """What is plotted of a result with a trajectory, by title; the abscissa of the last is no time but the way."""
    done, found = played(result), result.range
    c2: list[Line | Rule] = [
        Line(x=done.time, y=getattr(found.samples, side), label=label, color=END_COLOURS[side])
        for side, label in (("upper", "at most"), ("lower", "at least"))
    ]
    c2.append(Rule(at=done.c2, label=f"chosen c² = {done.c2:.4g}", color=OVER))
    speed = np.sqrt(np.mean(done.dq**2, axis=1))
    way = np.concatenate([[0.0], np.cumsum(np.diff(done.time) * (speed[:-1] + speed[1:]) / 2)])
    x = Axis(label="time [s]", ends=(0.0, done.duration))
    panels = [
        Panel(title="Range of c² of each sample", x=x, y=Axis(ends=c2_ends(found)), items=c2),
        *(panel for row in limits_plot(result, "").rows for panel in row),
        Panel(
            title=PHASE,
            x=Axis(label="way [rad or m]", ends=(0.0, float(way[-1]) or 1.0)),
            y=Axis(ends=(0.0, HEADROOM * float(np.max(speed)) or 1.0)),
            items=[Line(x=way, y=speed, label="root mean square of the joints [rad/s or m/s], along their way")],
        ),
    ]
    return {panel.title: panel for panel in panels}


def uplot_props(panel: Panel, other: Panel | None = None) -> dict[str, Any]:
    """A panel as viser's plot: its lines and level rules.

    Args:
        panel: With the ends of both axes.
        other: That of another result, whose largest values are dashed.
    """
    lines = [item for item in panel.items if isinstance(item, Line)]
    lines.sort(key=lambda line: line.unit is not None)  # those without a name below the others
    if other is not None:
        theirs = [item for item in other.items if isinstance(item, Line)]
        y = np.max([line.y for line in theirs], axis=0)
        lines.append(Line(x=theirs[0].x, y=y, label="the other", color=FAINT, dash=1))
    end, (low, high) = _joint_end(panel, other), panel.y.ends or (0.0, 1.0)
    if other is not None and other.y.ends is not None:
        low, high = min(low, other.y.ends[0]), max(high, other.y.ends[1])
    rules = [item for item in panel.items if isinstance(item, Rule)]
    lines += [Line(x=np.array([0.0, end]), y=np.full(2, of.at), label=of.label, color=of.color) for of in rules]
    x = np.unique(np.concatenate([line.x[shown_samples(len(line.x), line.y)] for line in lines]))
    y = [np.interp(x, line.x, np.clip(line.y, low, high), left=np.nan, right=np.nan) for line in lines]
    series = [
        {"label": line.label, "stroke": line.color if line.label else FAINT, "width": 1.5, "points": {"show": False},
         **({"dash": (4, 4)} if line.label == "the other" else {})}
        for line in lines
    ]  # fmt: skip
    return {
        "data": (x, *y),
        "series": ({"label": panel.x.label}, *series),
        "scales": {"x": {"time": False, "range": (0.0, end)}, "y": {"range": (low, high)}},
        "title": panel.x.label if panel.title == PHASE else None,
    }


def _joint_end(panel: Panel, other: Panel | None) -> float:
    return max(each.x.ends[1] for each in (panel, other) if each is not None and each.x.ends is not None)


def names_html(panel: Panel) -> str:
    """The names of its lines in their colours, and how many have none."""
    named = [item for item in panel.items if isinstance(item, Line | Rule)]
    texts = [
        f'<span style="color:{item.color}">●</span>&nbsp;{html_text(shortened(item.label, LETTERS))}&ensp;'
        for item in named
        if item.label
    ]
    more = sum(isinstance(item, Line) and not item.label for item in named)
    return " ".join(texts) + (f"and {more} more" if more else "")


class PlotPanel:
    """Plots that follow what is shown, with a cursor at its time.

    Attributes:
        cursor: The style sheet that says where it stands.
    """

    def __init__(self, gui: viser.GuiApi, tab: viser.GuiTabHandle, other: tuple[str, ScalingResult] | None) -> None:
        self._gui, self._tab = gui, tab
        self.cursor, self._compared = gui.add_html(""), gui.add_html("")
        self._plots: dict[str, tuple[viser.GuiHtmlHandle, viser.GuiUplotHandle, viser.GuiHtmlHandle]] = {}
        self._other = other
        self._others = {} if other is None else time_panels(other[1])
        self._wanted: PlayerState | None = None
        self._shown: dict[str, Panel] = {}
        self._since, self._at = RENEWAL, (0.0, 0.0)

    def show_answer(self, state: PlayerState | None) -> None:
        """Plot an answer as soon as the last plots have been seen; None empties them."""
        self._wanted = state
        if state is None:
            self._show({})

    def show_moment(self, state: PlayerState) -> None:
        """Take the chosen sample; the cursor moves with the next step, apart from what the scene sends together."""
        if self._shown:
            *_, timed, phase = self._shown.values()
            (line,) = (item for item in phase.items if isinstance(item, Line))
            way = float(line.x[min(state.sample, len(line.x) - 1)])
            end, farthest = (_joint_end(panel, self._others.get(panel.title)) for panel in (timed, phase))
            self._at = state.time / end, way / farthest

    def step(self, elapsed: float) -> None:
        """Plot what waits."""
        self._since += elapsed
        if self._wanted is not None and self._since >= RENEWAL:
            state, self._wanted, self._since = self._wanted, None, 0.0
            self._show(time_panels(state.played))
            if self._other is not None:
                self._compared.content = compared_html(state.played, *self._other)
            self.show_moment(state)
        style = f"<style>:root {{ --mrts-cursor: {self._at[0]:.4f}; --mrts-along: {self._at[1]:.4f}; }}</style>"
        if style != self.cursor.content:
            self.cursor.content = style

    def _show(self, panels: dict[str, Panel]) -> None:
        self._shown = panels
        for name, handles in self._plots.items():
            for handle in handles:
                handle.visible = name in panels
        for name, panel in panels.items():
            props = uplot_props(panel, self._others.get(name))
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


def compared_html(shown: ScalingResult, name: str, other: ScalingResult) -> str:
    """How much faster or slower than another."""
    own, their = (result.trajectory.duration for result in (shown, other) if result.trajectory is not None)
    faster = f"{their / own:.3g} × as fast as" if their >= own else f"{own / their:.3g} × as slow as"
    return (
        f'<div data-plot="compared" class="names">Shown: {own:.4g} s, {faster} <b>{html_text(shortened(name))}</b> '
        f"with {their:.4g} s (dashed).</div>"
    )
