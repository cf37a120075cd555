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
    frame, wait = next(frames)
    drawn = _numbers(frame, palette)
    with path.open("wb") as file:
        header, _ = GifImagePlugin.getheader(_image(drawn, palette), info={"loop": 0})
        file.writelines(header)
        part, corner = drawn, (0, 0)
        for frame, lasting in frames:
            following = _numbers(frame, palette)
            changed = following != drawn
            if not np.any(changed) and wait + lasting <= LONGEST_WAIT:
                wait += lasting
                continue
            _write_part(file, _image(part, palette), corner, wait)
            part, corner = _changed_part(following, changed)
            drawn, wait = following, lasting
        _write_part(file, _image(part, palette), corner, wait)
        file.write(b";")


def _palette(some: Sequence[Frame]) -> Image.Image:
    """A picture with the palette of a film."""
    room = COLOURS_OF_GIF - len(KEPT) - 1
    chosen = Image.fromarray(np.concatenate(some)).quantize(room, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    found = (chosen.getpalette() or [])[: 3 * room]
    kept = [channel for colour in KEPT for channel in colour]
    colours = [*kept, *found]
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours + list(KEPT[0]) * (COLOURS_OF_GIF - len(colours) // 3))
    return palette


def _numbers(frame: Frame, palette: Image.Image) -> Numbers:
    """A picture in the colours of a palette; none is `AS_BEFORE`, which looks like the first."""
    numbers = np.array(Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE))
    numbers[numbers >= AS_BEFORE] = 0
    return numbers


def _changed_part(following: Numbers, changed: NDArray[np.bool_]) -> tuple[Numbers, tuple[int, int]]:
    """The rectangle of a picture in which something changed, with what did not left out, and its upper left corner."""
    rows, columns = (np.flatnonzero(np.any(changed, axis=axis)) for axis in (1, 0))
    if not rows.size:
        return np.full((1, 1), AS_BEFORE, dtype=np.uint8), (0, 0)
    part = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    return np.where(changed[part], following[part], AS_BEFORE).astype(np.uint8), (int(columns[0]), int(rows[0]))


def _image(numbers: Numbers, palette: Image.Image) -> Image.Image:
    image = Image.fromarray(numbers, "L")
    image.putpalette(palette.getpalette() or [])
    return image


def _write_part(file: IO[bytes], image: Image.Image, corner: tuple[int, int], wait: int) -> None:
    file.writelines(
        GifImagePlugin.getdata(image, corner, duration=wait, transparency=AS_BEFORE, disposal=OVER_THE_LAST)
    )
