# SPDX-License-Identifier: MIT
"""A GIF, written picture by picture: none is kept but the last."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image, ImageColor

from mrts.drawing.colours import COLOURS
from mrts.film.frames import LIMIT_COLOUR, Frame
from mrts.film.lettering import INK
from mrts.film.stage import FORCE

COLOURS_OF_GIF = 128
"""More make a GIF larger, and are hardly seen; the last stands for what is as in the picture before."""

KEPT = [(255, 255, 255), INK, FORCE, LIMIT_COLOUR, *(ImageColor.getrgb(colour) for colour in COLOURS)]
"""Colours that a GIF has as they are: of lines too thin to weigh among thousands of pixels."""

STEP = 4
"""Of 255: pillow looks for the nearest colour of a palette to a colour that is rounded down to such steps."""

WEIGHT = 2 / 3
"""Exponent of the pixels of a colour, for how much it counts: with 1 arms would get what the background leaves."""

AS_BEFORE = COLOURS_OF_GIF - 1
"""Number of the colour that is none."""

OVER_THE_LAST = 1
"""How each picture follows the one before: it stands below."""

LONGEST_WAIT = 655_350
"""Of one picture, which a GIF counts in hundredths of a second and two bytes [ms]."""

Numbers = NDArray[np.uint8]
"""Of colours, Shape (height, width)."""


def write_gif(path: Path, frames: Iterator[tuple[Frame, int]], some: Sequence[Frame]) -> None:
    """Write a GIF that plays for ever.

    It has one palette for all pictures, so that what stands still is the same in all, and is stored once.

    Args:
        path: The file.
        frames: At least one, all of one size, with the time that each stands [ms].
        some: A few of them, whose colours it has.
    """
    palette = _palette(some)
    colours = _looked_up(palette)
    frame, wait = next(frames)
    drawn = _numbers(frame, colours)
    with path.open("wb") as file:
        header, _ = GifImagePlugin.getheader(_image(drawn, palette), info={"loop": 0})
        file.writelines(header)
        part, corner = drawn, (0, 0)
        for frame, lasting in frames:
            following = _numbers(frame, colours)
            changed = following != drawn
            if not np.any(changed) and wait + lasting <= LONGEST_WAIT:
                wait += lasting
                continue
            _write_part(file, _image(part, palette), corner, wait)
            part, corner = _changed_part(following, changed)
            drawn, wait = following, lasting
        _write_part(file, _image(part, palette), corner, wait)
        file.write(b";")


def _palette(some: Sequence[Frame]) -> list[int]:
    """Red, green and blue of each colour of a film."""
    room = COLOURS_OF_GIF - len(KEPT) - 1
    boxes, pixels = np.unique(np.concatenate(some).reshape(-1, 3) // STEP, axis=0, return_counts=True)
    colours = boxes.astype(int) * STEP + STEP // 2
    free = np.all([np.max(np.abs(colours - kept), axis=1) > STEP for kept in KEPT], axis=0)
    weights = np.ceil(pixels[free] ** WEIGHT).astype(int)
    weighed = np.repeat(colours[free], weights, axis=0).astype(np.uint8)
    chosen = Image.fromarray(weighed[None]).quantize(room, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    found = (chosen.getpalette() or [])[: 3 * room]
    kept = [channel for colour in KEPT for channel in colour]
    rest = COLOURS_OF_GIF - (len(kept) + len(found)) // 3
    return [*kept, *found, *rest * KEPT[0]]


def _looked_up(palette: list[int]) -> Image.Image:
    """A picture whose palette finds the number of the nearest colour."""
    image = Image.new("P", (1, 1))
    image.putpalette([channel // STEP * STEP for channel in palette])
    return image


def _numbers(frame: Frame, colours: Image.Image) -> Numbers:
    """A picture in numbers of colours; none is `AS_BEFORE`, which looks like the first."""
    numbers = np.array(Image.fromarray(frame).quantize(palette=colours, dither=Image.Dither.NONE))
    numbers[numbers >= AS_BEFORE] = 0
    return numbers


def _changed_part(following: Numbers, changed: NDArray[np.bool_]) -> tuple[Numbers, tuple[int, int]]:
    """The rectangle of a picture in which something changed, with what did not left out, and its upper left corner."""
    rows, columns = (np.flatnonzero(np.any(changed, axis=axis)) for axis in (1, 0))
    if not rows.size:
        return np.full((1, 1), AS_BEFORE, dtype=np.uint8), (0, 0)
    part = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    return np.where(changed[part], following[part], AS_BEFORE).astype(np.uint8), (int(columns[0]), int(rows[0]))


def _image(numbers: Numbers, palette: list[int]) -> Image.Image:
    image = Image.fromarray(numbers, "L")
    image.putpalette(palette)
    return image


def _write_part(file: IO[bytes], image: Image.Image, corner: tuple[int, int], wait: int) -> None:
    file.writelines(
        GifImagePlugin.getdata(image, corner, duration=wait, transparency=AS_BEFORE, disposal=OVER_THE_LAST)
    )
