# SPDX-License-Identifier: MIT
"""Large arrays in memory that earlier ones gave back: fresh pages cost as much as what is computed into them."""

import weakref
from collections import deque
from collections.abc import Sequence
from math import prod

import numpy as np

from mrts.base.arrays import Array

SMALLEST, LARGEST = 20, 24
"""Blocks of 2^20 to 2^24 bytes are kept: the C library reuses smaller ones itself, larger ones would hold too much."""

SPARE = 2
"""Blocks of each size that wait at most, 62 MB in all."""

_spare: dict[int, deque[bytearray]] = {power: deque(maxlen=SPARE) for power in range(SMALLEST, LARGEST + 1)}


def arrays_in_reused_memory(shapes: Sequence[tuple[int, ...]]) -> list[Array]:
    """Arrays of any content, whose memory serves others once nothing refers to any of them.

    Args:
        shapes: Of each.
    """
    sizes = [prod(shape) for shape in shapes]
    power = (8 * sum(sizes) - 1).bit_length()
    if power not in _spare:
        return [np.empty(shape) for shape in shapes]
    try:
        block = _spare[power].pop()
    except IndexError:
        block = bytearray(1 << power)
    # views keep an array over foreign memory, so it goes when the last of them has gone
    whole = np.frombuffer(block, dtype=np.float64)
    weakref.finalize(whole, _spare[power].append, block).atexit = False
    ends = np.cumsum(sizes).tolist()
    return [whole[end - size : end].reshape(shape) for end, size, shape in zip(ends, sizes, shapes, strict=True)]
