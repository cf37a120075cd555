# SPDX-License-Identifier: MIT
"""A surface of triangles as text for JSON: a thousand numbers in a word each would be slow to read."""

import base64
import binascii
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.input_file import LARGEST_NUMBER

MOST_VERTICES = 6000
"""Of a surface that is drawn."""

CORNERS = 3
"""Numbers of a vertex, and vertices of a triangle."""


def packed_surface(vertices: Array, triangles: NDArray[np.integer[Any]]) -> tuple[str, str]:
    """Base64 of both by rows: vertices as 32-bit floating-point numbers, triangles as 16-bit indices of vertices.

    Args:
        vertices: Shape (V, 3) [m].
        triangles: Shape (T, 3).
    """
    parts = vertices.astype("<f4").tobytes(), triangles.astype("<u2").tobytes()
    return base64.b64encode(parts[0]).decode(), base64.b64encode(parts[1]).decode()


def unpacked_surface(vertices: str, triangles: str) -> tuple[Array, NDArray[np.int64]]:
    """Vertices, Shape (V, 3) [m], and triangles, Shape (T, 3), of texts of `packed_surface`.

    Raises:
        ValueError: If they are no surface; the message ends a sentence.
    """
    points, corners = _numbers(vertices, "<f4"), _numbers(triangles, "<u2")
    if not len(points) or not len(corners) or len(points) > MOST_VERTICES:
        raise ValueError(f"must have 1 to {MOST_VERTICES} vertices, and triangles")
    if not np.all(np.abs(points) <= LARGEST_NUMBER):
        raise ValueError("must have finite vertices")
    if np.max(corners) >= len(points):
        raise ValueError("must have triangles between its own vertices")
    return points.astype(np.float64), corners.astype(np.int64)


def _numbers(text: str, kind: str) -> NDArray[Any]:
    try:
        content = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        raise ValueError("must be given as base64") from None
    if len(content) % (CORNERS * np.dtype(kind).itemsize):
        raise ValueError("must have three numbers a row")
    return np.frombuffer(content, dtype=kind).reshape(-1, CORNERS)
