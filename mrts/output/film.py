# SPDX-License-Identifier: MIT
"""Films of played motions side by side, with their limits' use along time and one clock, and pictures of one moment."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from PIL import Image

from mrts.base.atomic_file import write_atomically
from mrts.base.colours import COLOURS
from mrts.base.errors import InputError, Progress, cut, printable
from mrts.plots.trajectory_plots import limit_shares
from mrts.scene.arm_meshes import Warn
from mrts.scene.cell_view import look_at
from mrts.scene.renderer import Clip, Frame, SceneRenderer
from mrts.scene.scene import OVER_LIMIT, PACES, rgba, suited_pace

RATES = {".gif": 20, ".mp4": 30}
"""Frames a second: of a GIF a whole number of hundredths, which it counts in."""

BEFORE, AFTER = 0.4, 1.2
"""What stands still before and after the motion [s]."""

SAMPLES = 6
"""Frames along a film in which the colours of a GIF are looked for."""

LONGEST = 3600
"""Frames of a film: three minutes of a GIF, and minutes to draw."""

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

    `pace` says how fast the film plays, in words. The thread that made it calls `close`.

    Attributes:
        duration: Of the longest [s].
        size: Width and height of a frame [pixels].

    Raises:
        InputError: If there are too many clips, or none, or nothing to draw them by.
    """

    def __init__(self, clips: Sequence[Clip], pace: str = "", warn: Warn = lambda _text: None) -> None:
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
        size = self._width, self._height
        with ExitStack() as opened:
            made = (SceneRenderer(clip, view, camera, size, scale, warn) for clip in clips)
            self._renderers = [opened.enter_context(closing(renderer)) for renderer in made]
            self.close = opened.pop_all().close
        self._draw_surroundings(pace)

    def frame(self, time: float) -> Frame:
        """The clips at a time since the start [s]; one that has ended stands at its end."""
        canvas = self._canvas
        canvas.restore_region(self._still)
        for clip, cursor in zip(self._clips, self._cursors, strict=True):
            cursor.set_xdata([min(time, clip.trajectory.duration)] * 2)
            self._figure.draw_artist(cursor)
        self._clock.set_text(f"t = {min(time, self.duration):.3f} s")
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
        shares = [limit_shares(clip.trajectory, clip.rates) for clip in self._clips]
        titles = {of.kind: of.title.lower() for each in shares for of in each}
        colours = {kind: KIND_COLOURS[place % len(KIND_COLOURS)] for place, kind in enumerate(titles)}
        used = max((float(np.max(of.share, initial=0.0)) for each in shares for of in each), default=1.0)
        self._cursors = []
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
            for of in each:
                largest = np.minimum(np.max(of.share, axis=1), top)
                axes.plot(clip.trajectory.time, largest, color=colours[of.kind], linewidth=1.6)
            self._cursors += axes.plot([0, 0], [0, top], color=INK, linewidth=1, animated=True)
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
        if (limit := clip.deciding) is not None:
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


def write_film(
    clips: Sequence[Clip],
    path: Path,
    warn: Warn = lambda _text: None,
    progress: Progress = lambda _done, _total: None,
) -> None:
    """Write a film of motions side by side, whole or not at all.

    All start together; one that ends first stands and waits. The film is slowed down to last some seconds, and says so.

    Args:
        clips: One to four.
        path: The file, .gif or .mp4.
        warn: Told which arm is drawn without its meshes, and why.
        progress: Told how many frames are drawn.

    Raises:
        InputError: If the film would be too long, or the file cannot be written.
    """
    ending = path.suffix.lower()
    rate, longest = RATES[ending], max(clip.trajectory.duration for clip in clips)
    pace = suited_pace(longest)
    frames = int(np.ceil(longest / pace * rate)) + 1
    if frames > LONGEST:
        rule = f"a film has at most {LONGEST} frames, this motion would take {frames}."
        raise InputError("--video", f"{rule} Cut the motion into parts.", value=str(path))
    times = np.minimum(np.arange(frames) * pace / rate, longest).tolist()
    shown = [times[0]] * round(BEFORE * rate) + times + [longest] * round(AFTER * rate)
    words = PACES[pace] if pace == 1 else f"{PACES[pace]} of real time"
    with closing(Composition(clips, words, warn)) as composition:

        def drawn() -> Iterator[Frame]:
            frame, last = composition.frame(times[0]), times[0]
            for number, time in enumerate(shown):
                progress(number, len(shown))
                frame, last = (frame if time == last else composition.frame(time)), time
                yield frame

        def write(temporary: Path) -> None:
            if ending == ".mp4":
                _write_mp4(temporary, drawn(), composition.size, rate)
            else:
                some = [composition.frame(times[number]) for number in np.linspace(0, frames - 1, SAMPLES).astype(int)]
                _write_gif(temporary, drawn(), np.concatenate(some), rate)

        write_atomically(path, write)


def write_picture(clips: Sequence[Clip], path: Path, time: float, warn: Warn = lambda _text: None) -> None:
    """Write a PNG of motions side by side at a played time [s]; other arguments and errors as of `write_film`."""
    with closing(Composition(clips, warn=warn)) as composition:
        picture = Image.fromarray(composition.frame(time))
    write_atomically(path, lambda temporary: picture.save(temporary, "PNG", optimize=True))


def _write_mp4(path: Path, frames: Iterator[Frame], size: tuple[int, int], rate: int) -> None:
    from imageio_ffmpeg import write_frames  # noqa: PLC0415 (not for a GIF)

    options = ["-crf", "20", "-f", "mp4", "-movflags", "+faststart"]
    coder = write_frames(
        path, size, fps=rate, codec="libx264", quality=None, macro_block_size=1, output_params=options,
        ffmpeg_log_level="error",
    )  # fmt: skip
    with closing(coder):
        coder.send(None)
        for frame in frames:
            coder.send(frame)


def _write_gif(path: Path, frames: Iterator[Frame], some: Frame, rate: int) -> None:
    """One palette for all frames, of some of them below each other, so that what stands still is stored once."""
    palette = Image.fromarray(some).quantize(255, dither=Image.Dither.NONE)
    images = (Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
    next(images).save(path, "GIF", save_all=True, append_images=images, duration=1000 // rate, loop=0)
