# SPDX-License-Identifier: MIT
"""Plots along time as SVG: the range of c², and how much of each limit is used; and the speed along the path.

The cursor is a line in every plot that stands where one number says, which a style sheet of a few letters sets: so it
follows a motion at any rate, and the plots are sent only when they change.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite

import numpy as np

from mrts.base.arrays import Array
from mrts.base.printable import html_text
from mrts.drawing.colours import COLOURS, END_COLOURS
from mrts.drawing.round_numbers import round_down
from mrts.plots.labels import shortened
from mrts.plots.limit_plots import LimitShares, limit_shares
from mrts.plots.range_plots import c2_ends
from mrts.scaling.range import ScalingRange
from mrts.scaling.scaled_trajectory import ScaledTrajectory

WIDTH, HEIGHT = 360, 104
"""Of a plot, in its own units; it is drawn as wide as the panel."""

LEFT, RIGHT, TOP, BOTTOM = 40, 8, 6, 18
"""Free around it."""

NAMED = 4
"""Lines with a colour and a name: those that come nearest to their limits."""

HIGHEST = 1.6
"""Shares of limits beyond are at the upper edge."""

ROOM = 1.06
"""Upper edge of a plot whose shares keep their limits."""

MOST_POINTS = 400
"""Of a line: more than pixels are not seen. Of those at one place the largest is kept."""

LETTERS = 26
"""Of a line's name."""

OVER = "#F03E3E"
CURSOR, ALONG = "--mrts-cursor", "--mrts-along"
"""Where the cursor stands along time, and along the path."""

PLOT_STYLE = f"""<style>
:root {{ {CURSOR}: 0px; {ALONG}: 0px; }}
[data-plot] svg {{ display: block; width: 100%; height: auto; }}
[data-plot] text {{ font: 9px sans-serif; fill: currentColor; }}
[data-plot] .title {{ font-size: 12px; font-weight: bold; padding: 8px 9px 0; }}
[data-plot] .names, [data-plot].names {{ font-size: 11px; line-height: 15px; padding: 0 9px; overflow-wrap: anywhere; }}
[data-plot] .cursor {{ stroke: currentColor; stroke-width: 1.2; transform: translateX(var({CURSOR})); }}
[data-plot] .cursor.along {{ transform: translateX(var({ALONG})); }}
[data-plot] .grid {{ stroke: #8886; stroke-width: 0.7; }}
[data-plot] .limit {{ stroke: {OVER}; stroke-width: 0.8; stroke-dasharray: 4 2; }}
[data-plot] .line {{ fill: none; stroke-width: 1.4; stroke-linejoin: round; }}
[data-plot] .more {{ stroke: #8889; stroke-width: 0.8; }}
[data-plot] .other {{ stroke: currentColor; stroke-width: 1.2; stroke-dasharray: 3 3; }}
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


def cursor_html(share: float, along: float) -> str:
    """Where the cursor stands in all plots.

    Args:
        share: Of the width of a plot along time, 0 at its left edge.
        along: Of that along the path.
    """
    width = WIDTH - LEFT - RIGHT
    return f"<style>:root {{ {CURSOR}: {share * width:.1f}px; {ALONG}: {along * width:.1f}px; }}</style>"


def plots_html(motion: PlottedMotion, other: PlottedMotion | None = None) -> str:
    """All plots of a motion.

    Args:
        motion: The motion.
        other: Another to compare it with: the largest shares of its limits are dashed.
    """
    longest = max(motion.duration, other.duration if other else 0.0)
    parts = [_range_plot(motion, other, longest)]
    others = {of.kind: of for of in other.shares} if other else {}
    for of in motion.shares:
        beside = (other, others[of.kind]) if other and of.kind in others else None
        parts.append(_share_plot(motion, of, beside, longest))
    parts.append(_phase_plot(motion, other))
    compared = f'<div data-plot="compared" class="names">{_compared(motion, other)}</div>' if other else ""
    return f"{compared}{''.join(parts)}"


def _compared(motion: PlottedMotion, other: PlottedMotion) -> str:
    ratio = other.duration / motion.duration
    faster = f"{ratio:.3g} × as fast as" if ratio >= 1 else f"{1 / ratio:.3g} × as slow as"
    return (
        f"Shown: {motion.duration:.4g} s, {faster} <b>{html_text(shortened(other.name))}</b> with "
        f"{other.duration:.4g} s (dashed)."
    )


def _range_plot(motion: PlottedMotion, other: PlottedMotion | None, longest: float) -> str:
    found = motion.range
    ends = _Axes((0.0, longest), c2_ends(found))
    lines = []
    for values, side in ((found.samples.upper, "upper"), (found.samples.lower, "lower")):
        lines.append(ends.line(motion.time, values, f'class="line" stroke="{END_COLOURS[side]}"', f"c² {side} end"))
    if other is not None:
        lines.append(ends.line(other.time, other.range.samples.upper, 'class="line other"', f"{other.name}: upper end"))
    if ends.low <= motion.c2 <= ends.high:
        height = ends.height(motion.c2)
        lines.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{height:.1f}" y2="{height:.1f}" class="limit"/>')
    ticks = [(value, f"{value:.3g}") for value in _round_ticks(ends.high)]
    names = (
        f'<span style="color:{END_COLOURS["upper"]}">at most</span>, <span style="color:{END_COLOURS["lower"]}">at '
        f'least</span>, and <span style="color:{OVER}">chosen c² = {motion.c2:.4g}</span>'
    )
    return _plot("c2", "Range of c² of each sample", ends, ticks, lines, names)


def _share_plot(
    motion: PlottedMotion, of: LimitShares, beside: tuple[PlottedMotion, LimitShares] | None, longest: float
) -> str:
    used = max([float(np.max(of.share)), *([float(np.max(beside[1].share))] if beside else [])])
    ends = _Axes((0.0, longest), (0.0, ROOM * min(max(used, 1.0), HIGHEST)))
    lines, names = [], []
    for place, line in reversed(list(enumerate(of.ranked))):  # those with a colour above the others
        most = float(np.max(of.share[:, line]))
        label = f"{of.labels[line]}: at most {_percent(most)}"
        colour = COLOURS[place] if place < NAMED else None
        style = f'class="line" stroke="{colour}"' if colour else 'class="line more"'
        lines.append(ends.line(motion.time, of.share[:, line], style, label))
        if colour:
            dot = f'<span style="color:{colour}">●</span>'
            percent = _percent(most).replace(" ", "&nbsp;")
            names.append(f"{dot}&nbsp;{html_text(shortened(of.labels[line], LETTERS))}&nbsp;{percent}")
    if beside is not None:
        lines.append(ends.line(beside[0].time, beside[1].largest, 'class="line other"', f"{beside[0].name}: largest"))
    height = ends.height(1.0)
    lines.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{height:.1f}" y2="{height:.1f}" class="limit"/>')
    more = len(of.labels) - NAMED
    text = " ".join(f"{name}&ensp;" for name in reversed(names)) + (f"and {more} more" if more > 0 else "")
    ticks = [(share, f"{100 * share:.0f} %") for share in (0.0, 0.5, 1.0)]
    return _plot(of.kind, f"{of.title}, share of the limit", ends, ticks, lines, text)


def _phase_plot(motion: PlottedMotion, other: PlottedMotion | None) -> str:
    """The phase plane: how fast the joints go, where along the path."""
    both = [motion, other] if other else [motion]
    reach = max(float(np.max(one.speed)) for one in both) or 1.0
    ends = _Axes((0.0, max(float(one.way[-1]) for one in both) or 1.0), (0.0, ROOM * reach), "rad or m")
    lines = [ends.line(motion.way, motion.speed, f'class="line" stroke="{COLOURS[0]}"', "speed along the path")]
    if other is not None:
        lines.append(ends.line(other.way, other.speed, 'class="line other"', f"{other.name}: speed along the path"))
    ticks = [(value, f"{value:.3g}") for value in _round_ticks(reach)]
    text = "Root mean square of the joints [rad/s or m/s], along the way that it makes"
    return _plot("phase", "Phase plane: speed along the path", ends, ticks, lines, text)


def _plot(
    name: str, title: str, ends: "_Axes", ticks: Sequence[tuple[float, str]], lines: Sequence[str], names: str
) -> str:
    bottom = HEIGHT - BOTTOM
    drawn = []
    for value, text in ticks:
        height = ends.height(value)
        drawn.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{height:.1f}" y2="{height:.1f}" class="grid"/>')
        drawn.append(f'<text x="{LEFT - 4}" y="{height + 3:.1f}" text-anchor="end">{text}</text>')
    for share, anchor in ((0.0, "start"), (0.5, "middle"), (1.0, "end")):
        across = LEFT + share * (WIDTH - LEFT - RIGHT)
        text = f"{share * ends.longest:.3g} {ends.unit}"
        drawn.append(f'<text x="{across:.1f}" y="{HEIGHT - 5}" text-anchor="{anchor}">{text}</text>')
    kind = "cursor" if ends.unit == "s" else "cursor along"
    cursor = f'<line x1="{LEFT}" x2="{LEFT}" y1="{TOP}" y2="{bottom}" class="{kind}"/>'
    svg = f'<svg viewBox="0 0 {WIDTH} {HEIGHT}">{"".join(drawn)}{"".join(lines)}'
    return (
        f'<div data-plot="{html_text(name)}"><div class="title">{html_text(title)}</div>{svg}{cursor}</svg>'
        f'<div class="names">{names}</div></div>'
    )


class _Axes:
    """Where times, or ways along the path, and values are in a plot."""

    def __init__(self, times: tuple[float, float], values: tuple[float, float], unit: str = "s") -> None:
        self.longest, self.unit = times[1], unit
        self.low, self.high = values

    def height(self, value: float) -> float:
        """From the top."""
        return HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * (value - self.low) / (self.high - self.low)

    def line(self, time: Array, values: Array, style: str, title: str) -> str:
        """A line with what a pointer above it is told; beyond the axis it runs along the edge."""
        chosen_time, chosen = _thinned(time, np.clip(values, self.low, self.high))
        across = LEFT + (WIDTH - LEFT - RIGHT) * chosen_time / self.longest
        points = " ".join(
            f"{x:.1f},{self.height(float(value)):.1f}" for x, value in zip(across.tolist(), chosen, strict=True)
        )
        return f'<polyline {style} points="{points}"><title>{html_text(title)}</title></polyline>'


def _thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """A line of not too many points; of neighbours that become one the largest stays."""
    if len(time) <= MOST_POINTS:
        return time, values
    starts = np.unique(np.linspace(0, len(time) - 1, MOST_POINTS).astype(int))
    return time[starts], np.maximum.reduceat(values, starts)


def _round_ticks(high: float) -> list[float]:
    """0 and a round number in the upper half of the axis, and its half."""
    if not (isfinite(high) and high > 0):
        return [0.0]
    top = round_down(high, (1, 2, 4, 5, 8))
    return [0.0, top / 2, top]


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share < 10 else "far beyond"  # noqa: PLR2004 (a thousand per cent tell nothing)
