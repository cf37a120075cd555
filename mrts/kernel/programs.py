# SPDX-License-Identifier: MIT
"""Small dense programs in C: batches of any size in one foreign call."""

import ctypes

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.binding import INFINITY, work_arrays
from mrts.kernel.c_text import PROGRAM_FILES, one_text
from mrts.kernel.compiler import compiled_library

CORNERS = 64
"""Most corners of a projection, `MRTS_CORNERS` of projections.c."""

OPTIMAL, INFEASIBLE, MARGINAL, STOPPED = range(4)
"""The kernel's statuses, see linear_programs.h."""


_opened: list[ctypes.CDLL] = []


def offer_programs(library: ctypes.CDLL) -> None:
    """Take the programs from a cell's library, unless one is open: what is compiled once need not be again."""
    if not _opened:
        _opened.append(library)


def _library() -> ctypes.CDLL:
    if not _opened:
        _opened.append(compiled_library("mrts_programs", one_text(PROGRAM_FILES), PROGRAM_FILES))
    return _opened[0]


def solve_batch(
    H: Array | None, g: Array, A: Array, lower: Array, upper: Array
) -> tuple[Array, Array, NDArray[np.uint8]]:
    """Minimise ½ xᵀHx + gᵀx in every program of a batch.

    H has Shape (N, k, k) and is positive definite, or is None for gᵀx alone, g has Shape (N, k), A (N, r, k), the
    limits of rows and then unknowns (N, r + k).

    Returns:
        Minimisers, Shape (N, k), multipliers of rows and unknowns, Shape (N, r + k), positive at an upper limit,
        and statuses, Shape (N,).
    """
    count, rows, k = A.shape
    arrays = [array if array is None else np.clip(array, -INFINITY, INFINITY) for array in (H, g, A, lower, upper)]
    x, dual, status = np.zeros((count, k)), np.zeros((count, rows + k)), np.zeros(count, dtype=np.uint8)
    work = work_arrays(_library(), "mrts_batch", k, rows)
    _library().mrts_solve_batch(count, k, rows, *arrays, x, dual, status, *work)
    return x, dual, status


def speed_intervals(
    A: Array, lower: Array, upper: Array, column: Array, speed: Array, most: Array
) -> tuple[Array, Array, Array, Array, NDArray[np.uint8]]:
    """The highest interval of speeds c <= most of every sample, whose rows have a term in c beside one in c².

    A, Shape (N, r, k), has c² last and each unknown multiplied by its `column`, Shape (N, k). The limits and what
    c = 1 adds to the rows, `speed`, have Shape (N, r). `most` is the largest c², infinity for any, Shape (N,).

    Returns:
        Least and largest c², infinity where nothing bounds it, one in the gap below, 0 where there is none, each
        Shape (N,); multipliers of the rows at both ends, Shape (2, N, r), positive at an upper limit; statuses.
    """
    count, rows, k = A.shape
    given = [np.clip(array, -INFINITY, INFINITY) for array in (A, lower, upper, column, speed, most)]
    low, high, gap = np.zeros((3, count))
    dual, status = np.zeros((2, count, rows)), np.full(count, STOPPED, dtype=np.uint8)
    work = work_arrays(_library(), "mrts_batch", k, rows)
    _library().mrts_interval_batch(count, k, rows, *given, low, high, gap, *dual, status, *work)
    high[high >= INFINITY] = np.inf
    return low, high, gap, dual, status


def projections(
    A: Array,
    lower: Array,
    upper: Array,
    scale: Array,
    bounds: tuple[Array, Array],
    rows: NDArray[np.int32] | None = None,
) -> tuple[NDArray[np.int32], Array, NDArray[np.uint8]]:
    """Project every polytope of a batch onto its last two unknowns, from inside.

    A has Shape (N, r, k), its limits (N, r). `scale` is what its columns are multiplied by first, Shape (N, k),
    `bounds` the least and largest values of the last two unknowns, finite, Shape (N, 2) each. Rows that count are
    all, or `rows`, Shape (s,).

    Returns:
        Numbers of corners, Shape (N,), 0 where there is no projection; the corners of all, those of each counter-
        clockwise, Shape (E, 2); and statuses, Shape (N,).
    """
    count, all_rows, k = A.shape
    taken = np.arange(all_rows, dtype=np.int32) if rows is None else rows
    number, corners = np.zeros(count, dtype=np.int32), np.empty((count, CORNERS, 2))
    status = np.full(count, STOPPED, dtype=np.uint8)
    work = work_arrays(_library(), "mrts_project_batch", k, len(taken))
    given = count, k, all_rows, len(taken), taken, A, lower, upper, scale, *bounds
    _library().mrts_project_batch(*given, number, corners, status, *work)
    return number, corners[np.arange(CORNERS) < number[:, None]], status


def half_planes(
    number: NDArray[np.int32], corners: Array, unit: Array, cap: Array, box: float, near: float
) -> tuple[NDArray[np.int64], Array, Array, Array]:
    """The half-planes n_u u + n_x x <= h of N polygons over u and x.

    Args:
        number: Of corners of each, Shape (N,).
        corners: Of all, those of each counter-clockwise, Shape (E, 2).
        unit: What u and x are counted in, infinity for what does not move, Shape (N, 2).
        cap: Largest x that was asked for, Shape (N,).
        box: Largest u that was asked for, without its sign.
        near: Share of both from which an edge is one of theirs, which is none of the polygon.

    Returns:
        Those of polygon i are start[i] .. start[i + 1] - 1, Shape (N + 1,); n_u, n_x, h of all, Shape (E, 3); least
        and largest x, 0 of a polygon without corners, each Shape (N,).
    """
    count = len(number)
    start, planes = np.zeros(count + 1, dtype=np.int64), np.empty((len(corners) + 2 * count, 3))
    low, high = np.zeros((2, count))
    _library().mrts_half_planes(count, number, corners, unit, cap, box, near, start, planes, low, high)
    return start, planes[: start[-1]], low, high


def effects(A: Array, rows: NDArray[np.int32]) -> Array:
    """The largest coefficient of each unknown of A, Shape (N, r, k), in some rows, unsigned, Shape (N, k)."""
    count, all_rows, k = A.shape
    effect = np.zeros((count, k))
    _library().mrts_effects(count, k, all_rows, len(rows), rows, A, effect)
    return effect


def backward(step: Array, rise: Array, start: NDArray[np.int64], planes: Array, lower: Array, upper: Array) -> int:
    """Shrink bounds of x to the controllable sets, from the last sample back to the first.

    `step` is the length of each segment and `rise` by how much u rises along it, Shape (n - 1,); `start` and
    `planes` are those of `half_planes`. The bounds `lower` and `upper`, Shape (n,), are changed in place.

    Returns:
        The sample that has none, -1 if all have one.
    """
    arrays = (step, rise, start, planes, lower, upper, _segment_work(start))
    return int(_library().mrts_backward(len(step), *arrays))


def forward(
    step: Array,
    rise: Array,
    start: NDArray[np.int64],
    planes: Array,
    lower: Array,
    upper: Array,
    first: float,
) -> Array:
    """The largest controllable x at every sample, from `first` on, Shape (n,); arguments as in `backward`."""
    x = np.zeros(len(step) + 1)
    x[0] = first
    arrays = (step, rise, start, planes, lower, upper, x, _segment_work(start))
    _library().mrts_forward(len(step), *arrays)
    return x


def _segment_work(start: NDArray[np.int64]) -> Array:
    return np.empty(8 * (int((start[1:] - start[:-1]).max()) + 1))
