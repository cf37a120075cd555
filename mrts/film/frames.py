# SPDX-License-Identifier: MIT
"""Frames of a film: takes side by side, each with its limits' use along time, and one clock for all."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.printable import printable
from mrts.drawing.colours import COLOURS
from mrts.film.lettering import FAINT, GRID, INK, fitting, font, put_text
from mrts.film.stage import ARMS, Stage, Take, Warn, silent
from mrts.plots.limit_plots import limit_shares

FINER = 2
"""Pixels that are drawn for one that is shown, in both directions: edges become smooth."""

COLUMNS = {1: 720, 2: 480, 3: 360, 4: 300}
"""Width of a take by the number of takes [shown pixels]."""

SHAPE = 0.74
"""Height of a scene by its width."""

HEADING, PLOT, FOOT = 100, 224, 60
"""Heights of the parts of a frame [drawn pixels]."""

FIRST_LINE, SECOND_LINE = 42, 82
"""Of the heading: where its letters stand [drawn pixels]."""

TEXT, SMALL, TINY = 30, 24, 20
"""Of letters [drawn pixels]."""

LEFT, RIGHT, TOP, BOTTOM = 80, 28, 20, 44
"""Free around a plot [drawn pixels]."""

CLOCK = 220
"""Of the time at the frame's lower right corner [drawn pixels]."""

HIGHEST = 1.5
"""Shares of limits beyond are at the plot's upper edge."""

ROOM = 1.08
"""Upper edge of a plot whose shares keep their limits."""

LIMIT_COLOUR = (200, 30, 30)

KIND_COLOURS = tuple(COLOURS[place] for place in (2, 3, 6, 4, 5, 0, 1))
"""Of lines, by kind of limit: last come the colours that the first two arms are near to."""

Frame = NDArray[np.uint8]
"""Shape (height, width, 3)."""


@dataclass(frozen=True)
class _Place:
    """A rectangle of the frame [pixels]."""

    left: int
    top: int
    right: int
    bottom: int


class Composition:
    """Frames of takes, drawn when they are asked for.

    Args:
        takes: One to four.
        pace: How fast the film plays, in words; empty where nothing plays.
        backward: As in `Stage`.
        warn: Likewise.

    Attributes:
        takes: As given.
        duration: Of the longest [s].

    Raises:
        InputError: If there are too many takes, or none.
    """

    def __init__(
        self,
        takes: Sequence[Take],
        pace: str = "",
        backward: Array | None = None,
        warn: Warn = silent,
    ) -> None:
        if len(takes) not in COLUMNS:
            raise InputError("takes", f"must be one to {max(COLUMNS)}: more have no room.", value=len(takes))
        self.takes, self._pace = tuple(takes), pace
        self.duration = max(take.trajectory.duration for take in takes)
        self._column = FINER * COLUMNS[len(takes)]
        self._scene = self._column, int(self._column * SHAPE)
        self._size = self._column * len(takes), HEADING + self._scene[1] + PLOT + FOOT
        self._stage = Stage(takes, self._scene, backward, warn)
        self._shares = [limit_shares(take.trajectory) for take in takes]
        self._kinds = list(dict.fromkeys(shares.kind for of_take in self._shares for shares in of_take))
        used = max((float(np.max(of.share, initial=0.0)) for each in self._shares for of in each), default=1.0)
        self._highest = min(max(used, 1.0), HIGHEST) * ROOM
        self._still = self._without_time()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of a frame [pixels]."""
        return self._size[0] // FINER, self._size[1] // FINER

    def frame(self, time: float) -> Frame:
        """The takes at a time of their own motion.

        Args:
            time: Since the start; a take that has ended stands at its end [s].
        """
        image = self._still.copy()
        picture = ImageDraw.Draw(image)
        for number, take in enumerate(self.takes):
            scene = self._stage.picture(take, time)
            image.paste(Image.fromarray(scene.astype(np.uint8)), (number * self._column, HEADING))
            self._put_cursor(picture, number, time)
        text = f"t = {min(time, self.duration):.2f} s"
        put_text(picture, (self._size[0] - RIGHT, self._size[1] - 22), text, SMALL, CLOCK, anchor="rs")
        return np.asarray(image.resize(self.size, Image.Resampling.LANCZOS))

    def _without_time(self) -> Image.Image:
        """What is the same in all frames."""
        image = Image.new("RGB", self._size, (255, 255, 255))
        picture = ImageDraw.Draw(image)
        for number, take in enumerate(self.takes):
            left, done, room = number * self._column + RIGHT, take.trajectory, self._column - 2 * RIGHT
            put_text(picture, (left, FIRST_LINE), printable(take.title), TEXT, room, bold=True)
            text = f"{done.duration:.3g} s"
            if number > 0:
                text += f", {self.takes[0].trajectory.duration / done.duration:.3g} × as fast"
            put_text(picture, (left, SECOND_LINE), text, SMALL, room / 2, colour=FAINT)
            self._put_arms(picture, left + room, take, room / 2)
            self._put_plot(picture, number)
        self._put_legend(picture)
        return image

    def _put_legend(self, picture: ImageDraw.ImageDraw) -> None:
        """What the lines of all plots are, in letters that leave room for the clock."""
        titles = {of.kind: of.title.lower() for each in self._shares for of in each}
        head, pace = "nearest to a limit: ", f"played at {self._pace}" if self._pace else ""
        room, marks = self._size[0] - LEFT - CLOCK - RIGHT, 68 * len(self._kinds)
        words = "".join([head, *titles.values(), pace])
        size = next(
            (size for size in range(SMALL, TINY // 2, -1) if font(size).getlength(words) + marks <= room), TINY // 2
        )
        here, line = float(LEFT), self._size[1] - 22
        put_text(picture, (here, line), head, size, room, colour=FAINT)
        here += font(size).getlength(head)
        for kind, title in titles.items():
            picture.line([(here, line - size / 3), (here + 28, line - size / 3)], self._colour(kind), 6)
            put_text(picture, (here + 36, line), title, size, room)
            here += 68 + font(size).getlength(title)
        put_text(picture, (here, line), pace, size, room, colour=FAINT)

    def _put_arms(self, picture: ImageDraw.ImageDraw, right: float, take: Take, room: float) -> None:
        """The arms' names beside squares of their colours, in the heading on the right."""
        names = [printable(robot.name) for robot in take.cell.robots]
        mark, free = 0.8 * SMALL, 0.9 * SMALL
        each = room / len(names) - mark - 1.4 * free
        shown = [fitting(name, SMALL, each) for name in names]
        here = right - sum(letters.getlength(name) for name, letters in shown) - len(shown) * (mark + 1.4 * free) + free
        for (name, letters), colour in zip(shown, cycle(ARMS)):
            picture.rectangle([here, SECOND_LINE - mark, here + mark, SECOND_LINE], colour)
            picture.text((here + mark + 0.4 * free, SECOND_LINE), name, fill=INK, font=letters, anchor="ls")
            here += mark + 1.4 * free + letters.getlength(name)

    def _put_plot(self, picture: ImageDraw.ImageDraw, number: int) -> None:
        place = self._plot(number)
        for share in (0.0, 0.5, 1.0):
            height, colour = self._height(place, share), LIMIT_COLOUR if share == 1 else GRID
            picture.line([(place.left, height), (place.right, height)], colour, 2)
            text = f"{100 * share:.0f} %"
            put_text(picture, (place.left - 10, height), text, TINY, LEFT, anchor="rm", colour=FAINT)
        for share, anchor in ((0.0, "lt"), (0.5, "mt"), (1.0, "rt")):
            across = self._across(place, share * self.duration)
            text = f"{share * self.duration:.3g} s"
            put_text(picture, (across, place.bottom + 10), text, TINY, CLOCK, anchor=anchor, colour=FAINT)
        time = self.takes[number].trajectory.time
        for of in self._shares[number]:
            across, height = self._across(place, time), self._height(place, of.largest)
            line = list(zip(across.tolist(), height.tolist(), strict=True))
            picture.line(line, self._colour(of.kind), 4, joint="curve")

    def _put_cursor(self, picture: ImageDraw.ImageDraw, number: int, time: float) -> None:
        place, done = self._plot(number), self.takes[number].trajectory
        now = min(time, done.duration)
        across = float(self._across(place, now))
        picture.line([(across, place.top), (across, place.bottom)], INK, 2)
        for of in self._shares[number]:
            height = float(self._height(place, np.interp(now, done.time, of.largest)))
            picture.ellipse([across - 7, height - 7, across + 7, height + 7], self._colour(of.kind))

    def _plot(self, number: int) -> _Place:
        left, top = number * self._column, HEADING + self._scene[1]
        return _Place(left + LEFT, top + TOP, left + self._column - RIGHT, top + PLOT - BOTTOM)

    def _across(self, place: _Place, time: Array | float) -> Any:
        """Where times are, from the left [drawn pixels]."""
        return place.left + (place.right - place.left) * np.asarray(time) / self.duration

    def _height(self, place: _Place, share: Array | float) -> Any:
        """Where shares of limits are, from the top [drawn pixels]."""
        return place.bottom - (place.bottom - place.top) * np.minimum(np.asarray(share) / self._highest, 1.0)

    def _colour(self, kind: str) -> str:
        return KIND_COLOURS[self._kinds.index(kind) % len(KIND_COLOURS)]
