# SPDX-License-Identifier: MIT
"""Frames of a film: clips side by side, each with its limits' use along time, and one clock for all."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

from mrts.base.errors import InputError
from mrts.base.printable import cut, printable
from mrts.plots.limit_shares import limit_shares
from mrts.plots.plot import COLOURS
from mrts.scene.arm_meshes import Warn
from mrts.scene.cell_view import look_at
from mrts.scene.renderer import Clip, Frame, SceneRenderer, silent
from mrts.scene.scene import OVER_LIMIT, rgba

WIDTHS = {1: 720, 2: 480, 3: 360, 4: 300}
"""Of a clip by the number of clips [pixels]."""

SHAPE = 0.74
"""Height of a scene by its width."""

HEADING, PLOT, FOOT = 72, 112, 30
"""Heights of the parts of a frame [pixels]."""

LEFT, RIGHT, TOP, BOTTOM = 40, 14, 8, 20
"""Free around a plot [pixels]."""

DPI = 72
"""A point is a pixel."""

TITLE, TEXT, SMALL = 15, 12, 10
"""Of letters [pixels]."""

LETTER, SPACE = 0.56, 6
"""Width of a letter by its size, about; and letters that a name in a legend takes beside its own."""

INK, FAINT, GRID = "#242a32", "#68707a", "#d8dce2"

ARROW = 0.3
"""Longest force, as a share of the cell's size."""

HIGHEST = 1.5
"""Shares of limits beyond are at the plot's upper edge."""

HEADROOM = 1.08
"""Upper edge of a plot whose shares keep their limits."""

KIND_COLOURS = tuple(COLOURS[place] for place in (2, 3, 6, 4, 5, 0, 1))
"""Of lines, by kind of limit: last come those of the first two arms."""


class Composition:
    """Frames of one to four clips, seen from one place and with forces to one scale, drawn when they are asked for.

    `pace` says how fast the film plays, in words. It is closed by the thread that made it.

    Attributes:
        duration: Of the longest [s].
        size: Width and height of a frame [pixels].

    Raises:
        InputError: If there are too many clips, or none, or nothing to draw them by.
    """

    def __init__(self, clips: Sequence[Clip], pace: str = "", warn: Warn = silent) -> None:
        if len(clips) not in WIDTHS:
            raise InputError("clips", f"must be one to {max(WIDTHS)}: more have no room.", value=len(clips))
        self._clips = tuple(clips)
        self.duration = max(clip.trajectory.duration for clip in clips)
        width = WIDTHS[len(clips)]
        self._width, self._height = width, 2 * int(width * SHAPE / 2)  # an mp4 has even sides
        self.size = width * len(clips), HEADING + self._height + PLOT + FOOT
        scenes = [clip.scene for clip in clips]
        views = [look_at(scene) for scene in scenes]
        view = replace(views[0], points=np.concatenate([each.points for each in views]))
        camera = view.camera(self._width / self._height)
        strongest = max(scene.strongest[0] for scene in scenes)
        scale = ARROW * view.size / strongest if strongest > 0 else 0.0
        self._renderers: list[SceneRenderer] = []
        try:
            for clip in clips:
                drawn = SceneRenderer(clip, view, camera, (self._width, self._height), scale, warn)
                self._renderers.append(drawn)
        except BaseException:
            self.close()
            raise
        self._draw_surroundings(pace)

    def close(self) -> None:
        """Free what the renderers hold."""
        for renderer in self._renderers:
            renderer.close()

    def frame(self, time: float) -> Frame:
        """The clips at a time since the start [s]; one that has ended stands at its end."""
        canvas = self._canvas
        canvas.restore_region(self._still)
        for clip, (axes, cursor, dots, largest) in zip(self._clips, self._plots, strict=True):
            now = min(time, clip.trajectory.duration)
            cursor.set_xdata([now, now])
            heights = [np.interp(now, clip.trajectory.time, values) for values in largest]
            dots.set_offsets(np.column_stack([np.full(len(heights), now), np.minimum(heights, axes.get_ylim()[1])]))
            axes.draw_artist(cursor)
            axes.draw_artist(dots)
        self._clock.set_text(f"t = {min(time, self.duration):.2f} s")
        self._figure.draw_artist(self._clock)
        frame: Frame = np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
        for number, renderer in enumerate(self._renderers):
            left = number * self._width
            frame[HEADING : HEADING + self._height, left : left + self._width] = renderer.picture(time)
        return frame

    def _draw_surroundings(self, pace: str) -> None:
        width, height = self.size
        self._figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="white")
        canvas: Any = FigureCanvasAgg(self._figure)  # has no types
        self._canvas = canvas
        shares = [limit_shares(clip.trajectory) for clip in self._clips]
        titles = {of.kind: of.title.lower() for each in shares for of in each}
        colours = {kind: KIND_COLOURS[place % len(KIND_COLOURS)] for place, kind in enumerate(titles)}
        used = max((float(np.max(of.share, initial=0.0)) for each in shares for of in each), default=1.0)
        self._plots = []
        for number, (clip, each) in enumerate(zip(self._clips, shares, strict=True)):
            self._put_heading(number, clip)
            left = number * self._width + LEFT
            across = self._width - LEFT - RIGHT
            axes = self._figure.add_axes(
                (left / width, (FOOT + BOTTOM) / height, across / width, (PLOT - TOP - BOTTOM) / height)
            )
            top = min(max(used, 1.0), HIGHEST) * HEADROOM
            axes.set(xlim=(0, self.duration), ylim=(0, top), yticks=(0, 0.5, 1), yticklabels=("0 %", "50 %", "100 %"))
            ends = axes.set_xticks([0, self.duration], ["0 s", f"{self.duration:.3g} s"])
            ends[0].label1.set_horizontalalignment("left")
            ends[1].label1.set_horizontalalignment("right")
            axes.tick_params(length=0, labelsize=SMALL, labelcolor=FAINT)
            axes.spines[:].set_visible(False)
            axes.grid(axis="y", color=GRID, linewidth=1)
            axes.axhline(1.0, color=rgba(OVER_LIMIT), linewidth=1)
            largest = [np.max(of.share, axis=1) for of in each]
            for of, values in zip(each, largest, strict=True):
                axes.plot(clip.trajectory.time, np.minimum(values, top), color=colours[of.kind], linewidth=1.6)
            (cursor,) = axes.plot([0, 0], [0, top], color=INK, linewidth=1, animated=True)
            dots = axes.scatter(
                [0] * len(each), [0] * len(each), s=36, c=[colours[of.kind] for of in each], animated=True, zorder=3,
                clip_on=False,
            )  # fmt: skip
            self._plots.append((axes, cursor, dots, largest))
        self._put_foot(titles, colours, f"played at {pace}" if pace else "")
        self._clock = self._put(width - RIGHT, height - 10, "", TEXT, color=INK, ha="right", animated=True)
        self._canvas.draw()
        self._still = self._canvas.copy_from_bbox(self._figure.bbox)

    def _put_heading(self, number: int, clip: Clip) -> None:
        left, room, done = number * self._width + RIGHT, self._width - 2 * RIGHT, clip.trajectory
        self._put(left, 22, f"{done.cell.name}: {clip.title}", TITLE, 0.9 * room, color=INK, weight="bold")
        text = f"{done.duration:.3g} s"
        if number > 0:
            text += f", {self._clips[0].trajectory.duration / done.duration:.3g} × as fast"
        self._put(left, 42, text, TEXT, room, color=FAINT)
        if (limit := clip.card.deciding) is not None:
            used = f"limit: {limit.label}, {100 * limit.share:.0f} % at {limit.time:.2g} s"
            self._put(left, 60, used, TEXT, room, color=FAINT if limit.nearness != "reached" else rgba(OVER_LIMIT))

    def _put_foot(self, titles: dict[str, str], colours: dict[str, str], pace: str) -> None:
        width, height = self.size
        first, clock = "nearest to a limit:", 7 * TEXT
        self._put(LEFT, height - 10, first, TEXT, color=FAINT)
        self._put(width - RIGHT - clock, height - 10, pace, TEXT, color=FAINT, ha="right")
        left = LEFT + LETTER * TEXT * len(first)
        room = width - RIGHT - clock - LETTER * TEXT * len(pace) - left
        handles = [Line2D([], [], color=colours[kind], label=text) for kind, text in titles.items()]
        self._figure.legend(
            handles=handles, loc="center left", bbox_to_anchor=(left / width, 14 / height), ncols=len(handles),
            fontsize=min(TEXT, room / (LETTER * sum(len(text) + SPACE for text in titles.values()))),
            labelcolor="linecolor", handlelength=1, columnspacing=1, borderpad=0, borderaxespad=0, frameon=False,
        )  # fmt: skip

    def _put(self, across: float, down: float, text: str, size: int, room: float = np.inf, **style: Any) -> Text:
        """One line of text, cut in its middle where it would be wider than its room."""
        width, height = self.size
        shown = printable(text) if room == np.inf else cut(printable(text), int(room / (LETTER * size)))
        return self._figure.text(
            across / width, 1 - down / height, shown, fontsize=size, parse_math=False, va="baseline", **style
        )
