# SPDX-License-Identifier: MIT
"""Text in pictures: always whole, smaller where it would not fit."""

from functools import lru_cache
from pathlib import Path

from PIL import ImageDraw, ImageFont

from mrts.base.printable import cut

SMALLEST = 8
"""Of letters; what does not fit then is cut in its middle [pixels]."""

INK, FAINT, GRID = (36, 42, 50), (104, 112, 122), (216, 220, 226)


@lru_cache(maxsize=64)
def font(size: int, *, bold: bool = False) -> ImageFont.FreeTypeFont:
    """DejaVu Sans, which matplotlib brings; it has the letters of formulas.

    Args:
        size: Of letters [pixels].
        bold: Whether it is bold.
    """
    import matplotlib as mpl  # noqa: PLC0415 (half a second, only for pictures)

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)


def fitting(text: str, size: int, width: float, *, bold: bool = False) -> tuple[str, ImageFont.FreeTypeFont]:
    """A text and a font in which it is not wider than given.

    Args:
        text: One line.
        size: Of letters, where there is room for them [pixels].
        width: At most [pixels].
        bold: Whether it is bold.
    """
    for smaller in range(size, SMALLEST, -1):
        if font(smaller, bold=bold).getlength(text) <= width:
            return text, font(smaller, bold=bold)
    least = font(SMALLEST, bold=bold)
    for kept in range(len(text), 2, -1):
        if least.getlength(cut(text, kept)) <= width:
            return cut(text, kept), least
    return "…", least


def put_text(
    picture: ImageDraw.ImageDraw,
    place: tuple[float, float],
    text: str,
    size: int,
    width: float,
    *,
    anchor: str = "ls",
    bold: bool = False,
    colour: tuple[int, int, int] = INK,
) -> None:
    """Write one line.

    Args:
        picture: Where.
        place: Of its anchor [pixels].
        text: The line.
        size: Of letters, where there is room for them [pixels].
        width: At most [pixels].
        anchor: As pillow has them: `ls` is left on the base line.
        bold: Whether it is bold.
        colour: Of it.
    """
    shown, chosen = fitting(text, size, width, bold=bold)
    picture.text(place, shown, fill=colour, font=chosen, anchor=anchor)
