# SPDX-License-Identifier: MIT
"""Plots along time in the viewer's panel: the range of c², the use of each limit, the speed; needs the extra 'view'.

The cursor is a line over every plot that stands where one number says, which a style sheet of a few letters sets: so it
follows a motion at any rate, and the plots are sent only when they change.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import viser

from mrts.base.arrays import Array
from mrts.base.printable import html_text
from mrts.plots.colours import COLOURS, END_COLOURS
from mrts.plots.labels import shortened
from mrts.plots.limit_shares import LimitShares, limit_shares
from mrts.plots.range_plots import c2_ends
from mrts.scaling.range import ScalingRange
from mrts.scaling.scaled_trajectory import ScaledTrajectory
from mrts.viewer.player_state import PlayerState
from mrts.viewer.plots.other_result import Others
from mrts.viewer.workbench.answer import Answer

HEIGHT = 130
"""Of a plot [pixels]."""

NAMED = 4
"""Lines with a colour and a name: those that come nearest to their limits."""

HIGHEST = 160.0
"""Shares of limits beyond are at the upper edge [%]."""

HEADROOM = 1.06
"""Upper edge of a plot by the highest value in it."""

MOST_POINTS = 400
"""Of a line: more than pixels are not seen. Of those at one place the largest is kept."""

LETTERS = 26
"""Of a line's name."""

RENEWAL = 0.2
"""Time between new plots while a slider moves [s]: they are some hundred thousand numbers."""

OVER, FAINT = "#F03E3E", "#8888"

PLOT_STYLE = """<style>
:root { --mrts-cursor: 0; --mrts-along: 0; }
.u-over::after { content: ""; position: absolute; top: 0; bottom: 0; border-left: 1.2px solid currentColor; }
.u-over::after { left: calc(var(--mrts-cursor) * 100%); }
.uplot:has(.u-title) .u-over::after { left: calc(var(--mrts-along) * 100%); }
.uplot .u-title { font: 9px sans-serif; }
.uplot-container { opacity: var(--mrts-answer, 1); border: none !important; }
[data-plot].title { font-size: 12px; font-weight: bold; padding: 8px 9px 0; }
[data-plot].names { font-size: 11px; line-height: 15px; padding: 0 9px; overflow-wrap: anywhere; }
</style>"""


@dataclass(frozen=True)
class PlottedMotion:
    """A motion with what is plotted of it.

    Attributes:
        name: For people.
        time: As it is played, Shape (N,) [s].
        c2: That is chosen.
        range: Of the motion.
        shares: Of its limits.
        speed: Along the path as it is played, the root mean square of the joints' speeds, Shape (N,) [rad/s or m/s].
    """

    name: str
    time: Array
    c2: float
    range: ScalingRange
    shares: Sequence[LimitShares]
    speed: Array

    @classmethod
    def of(cls, name: str, done: ScaledTrajectory, found: ScalingRange) -> "PlottedMotion":
        """A motion as it is played.

        Args:
            name: For people.
            done: How it is played.
            found: Its range.
        """
        speed = np.sqrt(np.mean(done.dq**2, axis=1))
        return cls(name, done.time, done.c2, found, limit_shares(done), speed)

    @cached_property
    def way(self) -> Array:
        """Along the path, from its start, Shape (N,) [rad or m]."""
        steps = np.diff(self.time) * (self.speed[:-1] + self.speed[1:]) / 2
        return np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def duration(self) -> float:
        """[s]."""
        return float(self.time[-1])


@dataclass(frozen=True)
class Curve:
    """A line of a plot.

    Attributes:
        name: For people.
        x: Shape (k,).
        y: Likewise.
        colour: As a page has it.
        dashed: Whether it is of the other result.
    """

    name: str
    x: Array
    y: Array
    colour: str
    dashed: bool = False


@dataclass(frozen=True)
class TimePlot:
    """A plot with its caption.

    Attributes:
        kind: "c2", a kind of limits, or "phase".
        title: For people.
        curves: The last are drawn over the others.
        reach: Upper ends of both axes.
        low: Lower end of the upright one.
        names: What the lines are, as HTML.
        along: What the level axis is where it is no time; empty of time.
    """

    kind: str
    title: str
    curves: Sequence[Curve]
    reach: tuple[float, float]
    names: str
    low: float = 0.0
    along: str = ""

    @property
    def data(self) -> tuple[Array, ...]:
        """All abscissae, and the ordinate of every curve there, NaN beyond its ends."""
        x = np.unique(np.concatenate([curve.x for curve in self.curves]))
        clipped = [np.clip(curve.y, self.low, self.reach[1]) for curve in self.curves]
        values = [
            np.interp(x, curve.x, y, left=np.nan, right=np.nan) for curve, y in zip(self.curves, clipped, strict=True)
        ]
        return (x, *values)

    @property
    def props(self) -> dict[str, Any]:
        """Of viser's plot."""
        lines = [
            {"label": curve.name, "stroke": curve.colour, "width": 1.5, "points": {"show": False},
             **({"dash": (4, 4)} if curve.dashed else {})}
            for curve in self.curves
        ]  # fmt: skip
        return {
            "data": self.data,
            "series": ({"label": self.along or "time [s]"}, *lines),
            "scales": {"x": {"time": False, "range": (0.0, self.reach[0])}, "y": {"range": (self.low, self.reach[1])}},
            "title": self.along or None,
        }


def time_plots(motion: PlottedMotion, other: PlottedMotion | None = None) -> list[TimePlot]:
    """All plots of a motion.

    Args:
        motion: The motion.
        other: Another to compare it with: the largest shares of its limits are dashed.
    """
    longest = max(motion.duration, other.duration if other else 0.0)
    others = {of.kind: of for of in other.shares} if other else {}
    plots = [_range_plot(motion, other, longest)]
    for of in motion.shares:
        beside = (other, others[of.kind]) if other and of.kind in others else None
        plots.append(_share_plot(motion, of, beside, longest))
    return [*plots, _phase_plot(motion, other)]


class PlotPanel:
    """Plots that follow what is shown, with a cursor at its time.

    Args:
        gui: Where.
        tab: Of the panel, which is open.
        others: Results with their names; the first is compared with what is shown.

    Attributes:
        cursor: The style sheet that says where it stands.
    """

    def __init__(self, gui: viser.GuiApi, tab: viser.GuiTabHandle, others: Others = ()) -> None:
        self._gui, self._tab = gui, tab
        gui.add_html(PLOT_STYLE)
        self.cursor, self._compared = gui.add_html(""), gui.add_html("")
        self._plots: dict[str, tuple[viser.GuiHtmlHandle, viser.GuiUplotHandle, viser.GuiHtmlHandle]] = {}
        self._other = None
        for name, result in others[:1]:
            if (done := result.trajectory) is not None:
                self._other = PlottedMotion.of(name, done, result.range)
        self._wanted: PlayerState | None = None
        self._shown: PlottedMotion | None = None
        self._since, self._at = RENEWAL, (0.0, 0.0)

    def show_answer(self, answer: Answer) -> None:
        """Plot an answer as soon as the last plots have been seen."""
        self._wanted = answer.state
        if answer.state is None:
            self._show([])

    def show_moment(self, state: PlayerState) -> None:
        """Take the chosen sample; the cursor moves with the next step, apart from what the scene sends together."""
        if (shown := self._shown) is None:
            return
        both = (shown, self._other) if self._other else (shown,)
        longest = max(state.trajectory.duration, *(one.duration for one in both))
        farthest = max(float(one.way[-1]) for one in both)
        way = float(np.interp(state.time, shown.time, shown.way))
        self._at = state.time / longest, way / farthest if farthest > 0 else 0.0

    def step(self, elapsed: float) -> None:
        """Plot what waits.

        Args:
            elapsed: Since the last call [s].
        """
        self._since += elapsed
        if self._wanted is not None and self._since >= RENEWAL:
            state, self._wanted, self._since = self._wanted, None, 0.0
            self._shown = PlottedMotion.of("shown", state.trajectory, state.result.range)
            self._show(time_plots(self._shown, self._other))
            if self._other is not None:
                self._compared.content = compared_html(self._shown, self._other)
            self.show_moment(state)
        style = f"<style>:root {{ --mrts-cursor: {self._at[0]:.4f}; --mrts-along: {self._at[1]:.4f}; }}</style>"
        if style != self.cursor.content:
            self.cursor.content = style

    def _show(self, plots: Sequence[TimePlot]) -> None:
        for handles in self._plots.values():
            for handle in handles:
                handle.visible = False
        for plot in plots:
            if plot.kind not in self._plots:
                with self._tab:
                    self._plots[plot.kind] = (
                        self._gui.add_html(""),
                        self._gui.add_uplot(
                            **plot.props, height=HEIGHT, legend={"show": False}, padding=(6, 10, 0, 0),
                            cursor={"drag": {"x": False, "y": False}}, axes=({"size": 24}, {"size": 44}),
                        ),
                        self._gui.add_html(""),
                    )  # fmt: skip
            title, drawn, names = self._plots[plot.kind]
            title.content = f'<div data-plot="{html_text(plot.kind)}" class="title">{html_text(plot.title)}</div>'
            names.content = f'<div data-plot="names" class="names">{plot.names}</div>'
            for name, value in plot.props.items():
                setattr(drawn, name, value)
            title.visible = drawn.visible = names.visible = True


def compared_html(motion: PlottedMotion, other: PlottedMotion) -> str:
    """How much faster or slower than the other."""
    ratio = other.duration / motion.duration
    faster = f"{ratio:.3g} × as fast as" if ratio >= 1 else f"{1 / ratio:.3g} × as slow as"
    return (
        '<div data-plot="compared" class="names">'
        f"Shown: {motion.duration:.4g} s, {faster} <b>{html_text(shortened(other.name))}</b> with "
        f"{other.duration:.4g} s (dashed).</div>"
    )


def _range_plot(motion: PlottedMotion, other: PlottedMotion | None, longest: float) -> TimePlot:
    found, (low, high) = motion.range, c2_ends(motion.range)
    curves = [
        Curve("at most", *_thinned(motion.time, found.samples.upper), END_COLOURS["upper"]),
        Curve("at least", *_thinned(motion.time, found.samples.lower), END_COLOURS["lower"]),
    ]
    if other is not None:
        curves.append(Curve(other.name, *_thinned(other.time, other.range.samples.upper), FAINT, dashed=True))
    if low <= motion.c2 <= high:
        curves.append(Curve("chosen c²", np.array([0.0, longest]), np.full(2, motion.c2), OVER))
    names = (
        f'<span style="color:{END_COLOURS["upper"]}">at most</span>, <span style="color:{END_COLOURS["lower"]}">at '
        f'least</span>, and <span style="color:{OVER}">chosen c² = {motion.c2:.4g}</span>'
    )
    return TimePlot("c2", "Range of c² of each sample", curves, (longest, high), names, low)


def _share_plot(
    motion: PlottedMotion, of: LimitShares, beside: tuple[PlottedMotion, LimitShares] | None, longest: float
) -> TimePlot:
    curves, names = [], []
    for place, line in reversed(list(enumerate(of.ranked))):  # those with a colour above the others
        most, colour = float(np.max(of.share[:, line])), COLOURS[place] if place < NAMED else FAINT
        curves.append(Curve(of.labels[line], *_thinned(motion.time, 100 * of.share[:, line]), colour))
        if place < NAMED:
            dot = f'<span style="color:{colour}">●</span>'
            percent = _percent(most).replace(" ", "&nbsp;")
            names.append(f"{dot}&nbsp;{html_text(shortened(of.labels[line], LETTERS))}&nbsp;{percent}")
    if beside is not None:
        curves.append(Curve(beside[0].name, *_thinned(beside[0].time, 100 * beside[1].largest), FAINT, dashed=True))
    curves.append(Curve("limit", np.array([0.0, longest]), np.full(2, 100.0), OVER))
    used = max(float(np.max(curve.y)) for curve in curves)
    more = len(of.labels) - NAMED
    text = " ".join(f"{name}&ensp;" for name in reversed(names)) + (f"and {more} more" if more > 0 else "")
    return TimePlot(of.kind, f"{of.title}, % of the limit", curves, (longest, HEADROOM * min(used, HIGHEST)), text)


def _phase_plot(motion: PlottedMotion, other: PlottedMotion | None) -> TimePlot:
    """The phase plane: how fast the joints go, where along the path."""
    curves = [Curve("speed along the path", motion.way, motion.speed, COLOURS[0])]
    if other is not None:
        curves.append(Curve(other.name, other.way, other.speed, FAINT, dashed=True))
    farthest, fastest = (max(float(np.max(getattr(curve, axis))) for curve in curves) or 1.0 for axis in "xy")
    text = "Root mean square of the joints [rad/s or m/s], along the way that it makes"
    title = "Phase plane: speed along the path"
    return TimePlot("phase", title, curves, (farthest, HEADROOM * fastest), text, along="way [rad or m]")


def _thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """A line of not too many points; of neighbours that become one the largest stays."""
    if len(time) <= MOST_POINTS:
        return time, values
    starts = np.unique(np.linspace(0, len(time) - 1, MOST_POINTS).astype(int))
    return time[starts], np.maximum.reduceat(values, starts)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share < 10 else "far beyond"  # noqa: PLR2004 (a thousand per cent tell nothing)
