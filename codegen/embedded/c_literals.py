# SPDX-License-Identifier: MIT
"""Numbers and texts as C writes them."""

import math
import re
from collections.abc import Iterable
from typing import Literal

import numpy as np

Precision = Literal["double", "float"]

UNLIMITED: dict[Precision, str] = {"double": "1e300", "float": "1e30f"}
"""What stands for infinity: `MRTS_INFINITY` of the kernel."""

PLAIN = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 _-+./:^>=()")
"""Characters that mean themselves in a C string, trigraphs and format strings included."""


def c_number(value: float, precision: Precision) -> str:
    """A C literal that gives back the value, rounded to the precision.

    Args:
        value: Any but not-a-number; what the precision does not reach is unlimited.
        precision: Of the literal.
    """
    with np.errstate(over="ignore"):
        rounded = float(np.float32(value)) if precision == "float" else float(value)
    if not math.isfinite(rounded):
        return ("-" if rounded < 0 else "") + UNLIMITED[precision]
    text = f"{rounded:.9g}" if precision == "float" else repr(rounded)
    if not re.search(r"[.e]", text):
        text += ".0"
    return text + ("f" if precision == "float" else "")


def c_numbers(values: Iterable[float], precision: Precision) -> str:
    """Literals with commas between."""
    return ", ".join(c_number(float(value), precision) for value in values)


def c_string(text: str) -> str:
    """A C string literal of any text: what is not plain is written as octal escapes of its UTF-8 bytes."""
    return '"' + "".join(chr(byte) if chr(byte) in PLAIN else f"\\{byte:03o}" for byte in text.encode()) + '"'
