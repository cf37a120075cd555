# SPDX-License-Identifier: MIT
"""Convex programs of smooth timing in C (mrts/kernel/c/smooth): memory, shapes, one foreign call a program."""

import ctypes
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.binding import bind, structure
from mrts.kernel.c_text import SMOOTH_FILES, smooth_source
from mrts.kernel.compiler import find_compiler, library_or_rebuilt
from mrts.kernel.foreign_arrays import INFINITY, interruptible

FOUND = 0
"""The kernel's status of an answer, `MRTS_SMOOTH_FOUND` of interior_point.h."""

_SIZES = ("nodes", "rows", "free", "width", "changes", "jerks")
PROGRAM = structure("smooth/smooth_program.h", "mrts_smooth_program")


@dataclass(frozen=True)
class PathRows:
    """Arrays of a path as the kernel takes them, contiguous and of its types.

    Attributes:
        sizes: By the names of `mrts_smooth_program`.
        arrays: Likewise; what is absent is null.
    """

    sizes: dict[str, int]
    arrays: dict[str, NDArray[Any]]


def path_rows(free: Array, columns: NDArray[np.int_], **arrays: Array) -> PathRows:
    """A path for the kernel.

    Args:
        free: Coefficients of F, Shape (n, r, f).
        columns: First and one past the last column that a row has, Shape (r, 2).
        **arrays: Those of `mrts_smooth_program` that a step does not change, by name, Shape (n, r) if not said there;
            `change` Shape (r,), infinite where there is none.
    """
    n, r, f = free.shape
    columns = _used(free, columns)
    first, count = columns[:, 0], columns[:, 1] - columns[:, 0]
    taken = _places(columns, f)
    limited = np.flatnonzero(np.isfinite(arrays["change"]))
    given = {
        **{name: array for name, array in arrays.items() if name not in ("root", "weight") or np.any(array)},
        "entry": free.reshape(n, r * f)[:, taken],
        "change": arrays["change"][limited],
        "lower": np.maximum(arrays["lower"], -INFINITY),
        "upper": np.minimum(arrays["upper"], INFINITY),
    }
    numbers = {name: np.ascontiguousarray(array, dtype=np.float64) for name, array in given.items()}
    indices = {"first": first, "count": count, "place": np.cumsum(count) - count, "limited": limited}
    sizes = (n, r, f, len(taken), len(limited), arrays["jerk"].shape[0])
    return PathRows(
        dict(zip(_SIZES, sizes, strict=True)),
        {**numbers, **{name: np.ascontiguousarray(array, dtype=np.int32) for name, array in indices.items()}},
    )


def _places(columns: NDArray[np.int_], f: int) -> NDArray[np.int_]:
    """Of the columns that rows have among all coefficients of a node, (r, f)."""
    first, count = columns[:, 0], columns[:, 1] - columns[:, 0]
    within = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    places: NDArray[np.int_] = np.repeat(np.arange(len(columns)) * f + first, count) + within
    return places


def _used(free: Array, columns: NDArray[np.int_]) -> NDArray[np.int_]:
    """The columns of each row from the first to the last that is not 0 at every node, Shape (r, 2)."""
    n, r, f = free.shape
    places = _places(columns, f)
    rows, found = np.divmod(places[np.any(free.reshape(n, r * f)[:, places], axis=0)], max(f, 1))
    used = np.tile([f, 0], (r, 1))
    np.minimum.at(used[:, 0], rows, found)
    np.maximum.at(used[:, 1], rows, found + 1)
    used[used[:, 0] > used[:, 1]] = 0
    return used


@dataclass(frozen=True)
class Solved:
    """How a program ended.

    Attributes:
        found: Whether there is an answer.
        share: By which limits of changes and jerks are passed.
        iterations: How many it took.
        work: What to start from in a program on the same rows, with the same weights, that is near.
    """

    found: bool
    share: float
    iterations: int
    work: Array


def solve_smooth(
    rows: PathRows,
    x: Array,
    u: Array,
    free: Array,
    *,
    around: Array,
    time: float = 0.0,
    effort: float = 0.0,
    longest: float = np.inf,
    uneven: float = 0.0,
    relaxed: float = 0.0,
    timed: bool = False,
    moving: bool = False,
    given: tuple[bool, bool] = (False, False),
    held: tuple[bool, bool] = (False, False),
    last: Array | None = None,
) -> Solved:
    """Solve a program; the answer is written to x, u and free. See `mrts_smooth_program`.

    Args:
        rows: The path.
        x: Read where it is given, Shape (n,).
        u: Shape (n,).
        free: F, read where it is given, Shape (n, f).
        around: x > 0 where tangents are laid, contiguous, Shape (n,).
        time: Weight of the duration.
        effort: Weight of the effort.
        longest: Largest duration.
        uneven: Weight of the jumps of u.
        relaxed: Weight of a share by which all limits of changes and jerks are relaxed; 0 relaxes none.
        timed: x and u are given: F alone is looked for.
        moving: Tangents are laid anew in each iteration.
        given: Whether x is given at the first and the last node.
        held: Whether F is.
        last: Work of an answer that is started from.

    Returns:
        How it ended.

    Raises:
        CompilerError: If there is no compiler, or it fails.
    """
    library = _library()
    program = PROGRAM(
        **rows.sizes,
        **{name: array.ctypes.data for name, array in rows.arrays.items()},
        time=time,
        effort=effort,
        longest=min(longest, INFINITY),
        uneven=uneven,
        relaxed=relaxed,
        timed=timed,
        moving=moving,
        again=last is not None,
        around=around.ctypes.data,
        given_start=given[0],
        given_end=given[1],
        held_start=held[0],
        held_end=held[1],
    )
    program.kept = around, rows  # by a call that is left behind
    share, iterations = ctypes.c_double(), ctypes.c_int()
    work = np.empty(library.mrts_smooth_work(program)) if last is None else last

    def solve() -> int:
        reached = ctypes.byref(share), ctypes.byref(iterations)
        return int(library.mrts_smooth_solve(program, x, u, free, *reached, work))

    status = interruptible(solve)
    return Solved(status == FOUND, share.value, iterations.value, work)


@lru_cache(maxsize=1)
def _library() -> ctypes.CDLL:
    """The programs in a library of their own, compiled on first use."""
    return library_or_rebuilt(
        find_compiler(), "mrts_smooth", smooth_source(), lambda library: bind(ctypes.CDLL(str(library)), SMOOTH_FILES)
    )
