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

PROGRAM = structure("smooth/smooth_program.h", "mrts_smooth_program")

PathRows = dict[str, int | NDArray[Any]]
"""Sizes and arrays of a path by the names of `mrts_smooth_program`, contiguous and of its types; one that is absent is
null."""


def path_rows(free: Array, **arrays: Array) -> PathRows:
    """A path for the kernel.

    Args:
        free: Coefficients of F, Shape (n, r, f).
        **arrays: Those of `mrts_smooth_program` that a step does not change, by name, Shape (n, r) if not said there;
            `change` Shape (r,), infinite where there is none.
    """
    n, r, f = free.shape
    used = np.any(free, axis=0)  # of a row, what lies from the first column that is not 0 at every node to the last
    end = np.max(used * np.arange(1, f + 1), axis=1, initial=0)
    first = np.minimum(np.min(np.where(used, np.arange(f), f), axis=1, initial=f), end)
    taken = np.flatnonzero((np.arange(f) >= first[:, None]) & (np.arange(f) < end[:, None]))
    limited = np.flatnonzero(np.isfinite(arrays["change"]))
    given = {
        **{name: array for name, array in arrays.items() if name not in ("root", "weight") or np.any(array)},
        "entry": free.reshape(n, r * f)[:, taken],
        "change": arrays["change"][limited],
        "lower": np.maximum(arrays["lower"], -INFINITY),
        "upper": np.minimum(arrays["upper"], INFINITY),
    }
    count = end - first
    indices = {"first": first, "count": count, "place": np.cumsum(count) - count, "limited": limited}
    sizes = {"nodes": n, "rows": r, "free": f, "width": len(taken), "changes": len(limited)}
    return {
        **(sizes | {"jerks": len(arrays["jerk"])}),
        **{name: np.ascontiguousarray(array, dtype=np.float64) for name, array in given.items()},
        **{name: np.ascontiguousarray(array, dtype=np.int32) for name, array in indices.items()},
    }


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
        **{name: value if isinstance(value, int) else value.ctypes.data for name, value in rows.items()},
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
