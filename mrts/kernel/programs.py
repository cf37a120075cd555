# SPDX-License-Identifier: MIT
"""Small dense programs in C: batches of any size in one foreign call."""

import ctypes

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.binding import INFINITY, work_arrays
from mrts.kernel.c_text import BATCH, PROJECTIONS, SMOOTH, SMOOTH_LEVEL, one_text
from mrts.kernel.compiler import compiled_library

CORNERS = 64
"""Most corners of a projection, `MRTS_CORNERS` of projections.c."""

OPTIMAL, INFEASIBLE, MARGINAL, STOPPED = range(4)
"""The kernel's statuses, see linear_programs.h."""


opened_programs: dict[str, ctypes.CDLL] = {}
"""Libraries of programs, by file; one of a cell has `BATCH` too."""


def program_library(file: str) -> ctypes.CDLL:
    """The library of a file of programs, compiled when one of them is first asked, once for all cells."""
    if file not in opened_programs:
        text = SMOOTH_LEVEL * (file == SMOOTH) + one_text((file,))
        opened_programs[file] = compiled_library(f"mrts_{file.removesuffix('.c')}", text, (file,))
    return opened_programs[file]


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
    work = work_arrays(program_library(BATCH), "mrts_batch", k, rows)
    program_library(BATCH).mrts_solve_batch(count, k, rows, *arrays, x, dual, status, *work)
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
    work = work_arrays(program_library(BATCH), "mrts_batch", k, rows)
    program_library(BATCH).mrts_interval_batch(count, k, rows, *given, low, high, gap, *dual, status, *work)
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
    number, corners = np.zeros(count, dtype=np.int32), np.empty((count * CORNERS, 2))
    status = np.full(count, STOPPED, dtype=np.uint8)
    work = work_arrays(program_library(PROJECTIONS), "mrts_project_batch", k, len(taken))
    given = count, k, all_rows, len(taken), taken, A, lower, upper, scale, *bounds
    program_library(PROJECTIONS).mrts_project_batch(*given, number, corners, status, *work)
    return number, corners[: number.sum()], status


def half_planes(
    samples: tuple[Array, Array, Array],
    alone: NDArray[np.int32],
    scale: Array,
    projected: tuple[NDArray[np.int32], Array],
    most: Array,
    bound: float,
) -> tuple[NDArray[np.int64], Array, Array, Array]:
    """The half-planes n_u u + n_x x <= h of N samples: of rows of u and x alone, and of projections of the others.

    Args:
        samples: A, Shape (N, r, k), and its limits, Shape (N, r) each.
        alone: The rows of u and x alone, Shape (s,).
        scale: What columns are multiplied by, 0 for what does not move, Shape (N, k).
        projected: Numbers of corners and the corners of all, as of `projections`.
        most: Largest x that was asked for, Shape (N,).
        bound: An x that none reaches.

    Returns:
        Those of sample i are start[i] .. start[i + 1] - 1, Shape (N + 1,); n_u, n_x, h of all, Shape (E, 3); least
        and largest x, each Shape (N,).
    """
    (count, rows, k), (number, corners) = samples[0].shape, projected
    start = np.zeros(count + 1, dtype=np.int64)
    planes, low, high = np.empty((len(corners) + 2 * count * (len(alone) + 1), 3)), np.empty(count), np.empty(count)
    given = count, k, rows, len(alone), alone, *samples, scale, number, corners, most, bound
    program_library(PROJECTIONS).mrts_half_planes(*given, start, planes, low, high)
    return start, planes[: start[-1]], low, high


def scales(
    samples: tuple[Array, Array, Array],
    rows: NDArray[np.int32],
    caps: NDArray[np.int32],
    length: float,
    ends: tuple[float, float],
    bound: float | None,
) -> tuple[float, Array, tuple[Array, Array], Array]:
    """What the columns of N samples of a path are multiplied by before they are projected.

    Args:
        samples: A, Shape (N, r, k), and its limits, Shape (N, r) each.
        rows: Those that count.
        caps: Those that bound x from above.
        length: Of the path: over it u changes x by 2 u times that.
        ends: x at the ends of the path.
        bound: An x that none reaches; None finds one.

    Returns:
        The bound; the scale, 0 of unknowns that move no row, Shape (N, k); the bounds of `projections`; and the largest
        x that caps allow, Shape (N,), infinity where none bounds it.
    """
    count, all_rows, k = samples[0].shape
    found, scale, cap = np.full(1, bound or 0.0), np.zeros((count, k)), np.zeros(count)
    bounds = np.zeros((count, 2)), np.zeros((count, 2))
    given = count, k, all_rows, len(rows), len(caps), np.concatenate([rows, caps]), *samples, length, max(ends)
    work = work_arrays(program_library(PROJECTIONS), "mrts_project_batch", k, len(rows))
    program_library(PROJECTIONS).mrts_scales(*given, found, scale, *bounds, cap, *work)
    return float(found[0]), scale, bounds, cap


def fastest_speeds(
    step: Array, rise: Array, start: NDArray[np.int64], planes: Array, lower: Array, upper: Array, first: float
) -> tuple[int, Array]:
    """Shrink bounds of x to the controllable sets, from the last sample back to the first; then go as fast as they let.

    `step` is the length of each segment and `rise` by how much u rises along it, Shape (n - 1,); `start` and
    `planes` are those of `half_planes`. The bounds `lower` and `upper`, Shape (n,), are changed in place.

    Returns:
        The sample that has no controllable x, -1 if all have one; and then the largest at every sample, from the one
        nearest to `first` on, Shape (n,).
    """
    x, work = np.full(len(step) + 1, first), np.empty(8 * len(planes) + 14 * len(lower))
    given = len(step), step, rise, start, planes, lower, upper, x, work
    return int(program_library(PROJECTIONS).mrts_fastest(*given)), x
