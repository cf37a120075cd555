# SPDX-License-Identifier: MIT
"""A surface of triangles as text for JSON, where a thousand numbers would be slow to read, and a coarser one."""

import base64
import binascii
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.input_file import LARGEST_NUMBER

MOST_VERTICES = 6000

MOST_DRAWN = 2000
"""Triangles of a surface that is drawn; a finer mesh is drawn coarser."""

CELLS = 96
"""Of the grid of a coarser surface along its longest side, at first."""

CORNERS = 3


def packed_surface(vertices: Array, triangles: NDArray[np.integer[Any]]) -> tuple[str, str]:
    """Base64 of both by rows: vertices as 32-bit floating-point numbers, triangles as 16-bit indices of vertices."""
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


def coarser_surface(
    points: Array, corners: NDArray[np.integer[Any]], most: int
) -> tuple[Array, NDArray[np.integer[Any]]]:
    """A surface of at most `most` triangles that looks alike: vertices in one cell of a grid become one, their mean.

    Vertices have Shape (V, 3) [m], triangles Shape (T, 3).
    """
    used, corners = np.unique(corners, return_inverse=True)
    points, corners = points[used], corners.reshape(-1, 3)
    longest, cells = float(np.max(np.ptp(points, axis=0))), CELLS
    coarse, few = points, corners
    while len(few) > most:
        places = np.floor((points - np.min(points, axis=0)) / longest * cells).astype(np.int64)
        _, group, size = np.unique(places, axis=0, return_inverse=True, return_counts=True)
        group = group.reshape(-1)
        coarse = np.stack([np.bincount(group, points[:, axis]) for axis in range(3)], axis=1) / size[:, None]
        few = group[corners]
        apart = (few[:, 0] != few[:, 1]) & (few[:, 1] != few[:, 2]) & (few[:, 2] != few[:, 0])
        _, first = np.unique(np.sort(few[apart], axis=1), axis=0, return_index=True)
        few = few[apart][first]
        cells = cells * 3 // 4
    if not len(few):  # every triangle lies in one cell of the grid, as of two small bodies that are far apart
        few = corners[np.argsort(_areas(points, corners), kind="stable")[-most:]]
        used, few = np.unique(few, return_inverse=True)
        coarse, few = points[used], few.reshape(-1, CORNERS)
    return coarse, few


def _areas(points: Array, corners: NDArray[np.integer[Any]]) -> Array:
    """Twice those of triangles, Shape (T,) [m²]."""
    a, b, c = points[corners.T]
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1))
