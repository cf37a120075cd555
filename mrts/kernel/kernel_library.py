# SPDX-License-Identifier: MIT
"""Our kernel of small dense programs, compiled by itself: batches of any size in one foreign call."""

import ctypes
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import CompilerError
from mrts.kernel.compiler import find_compiler
from mrts.kernel.library_cache import library_in_cache

Library = TypeVar("Library")

KERNEL_FILES = ("dense_programs.h", "linear_programs.c", "quadratic_programs.c", "batch.c")
EXPORT = '__attribute__((visibility("default")))'

CORNERS = 64
"""Most corners of a projection, `MRTS_CORNERS` of projection.c."""

CHUNK = 256
"""Samples between cold starts: chunks are dealt to threads whole, so their number does not change a result."""

MOST_THREADS = 2
"""More than this gains little: the work of a sample is a few microseconds."""

OPTIMAL, INFEASIBLE, MARGINAL, STOPPED = range(4)
"""The kernel's statuses, see dense_programs.h."""


class KernelLibrary:
    """Our kernel by itself: batches of small dense programs.

    Args:
        library: Path of the shared library.

    Raises:
        OSError: If it cannot be loaded.
        AttributeError: If it lacks a function.
    """

    def __init__(self, library: Path) -> None:
        self.loaded = ctypes.CDLL(str(library))
        for name in ("mrts_lp_batch", "mrts_qp_batch"):
            getattr(self.loaded, name)

    def linear_programs(self, g: Array, A: Array, lower: Array, upper: Array) -> tuple[Array, Array, NDArray[np.uint8]]:
        """Minimise gᵀx in every program of a batch; shapes as in `quadratic_programs`."""
        return self._batch("mrts_lp_batch", [g, A, lower, upper])

    def quadratic_programs(
        self, H: Array, g: Array, A: Array, lower: Array, upper: Array
    ) -> tuple[Array, Array, NDArray[np.uint8]]:
        """Minimise ½ xᵀHx + gᵀx in every program of a batch.

        Args:
            H: Positive definite, Shape (N, k, k).
            g: Shape (N, k).
            A: Shape (N, r, k).
            lower: Of the rows and then the unknowns, Shape (N, r + k).
            upper: Likewise.

        Returns:
            Minimisers, Shape (N, k), multipliers of rows and unknowns, Shape (N, r + k), positive at an upper limit,
            and statuses, Shape (N,).
        """
        return self._batch("mrts_qp_batch", [H, g, A, lower, upper])

    def projections(self, A: Array, lower: Array, upper: Array) -> tuple[NDArray[np.int32], Array, NDArray[np.uint8]]:
        """Project every polytope of a batch onto its last two unknowns, from inside.

        Args:
            A: Shape (N, r, k).
            lower: Of the rows and then the unknowns, Shape (N, r + k); the last two unknowns need limits.
            upper: Likewise.

        Returns:
            Numbers of corners, Shape (N,), the corners counter-clockwise, Shape (N, 64, 2), and statuses, Shape (N,).
        """
        count, rows, k = A.shape
        arrays = [np.ascontiguousarray(np.clip(array, -1e300, 1e300)) for array in (A, lower, upper)]
        number, corners = np.zeros(count, dtype=np.int32), np.zeros((count, CORNERS, 2))
        status = np.full(count, STOPPED, dtype=np.uint8)

        def project(first: int) -> None:
            work = np.zeros(k * k + 4 * k + (CORNERS + 1) * (2 + 2 * k))
            iwork = np.zeros(rows + (7 + CORNERS) * k, dtype=np.int32)
            outputs: list[NDArray[Any]] = [number, corners, status]
            pointers = [pointer(array[first:]) for array in [*arrays, *outputs]]
            self.loaded.mrts_project_batch(
                ctypes.c_longlong(min(CHUNK, count - first)), k, rows, *pointers, pointer(work), pointer(iwork)
            )

        with ThreadPoolExecutor(min(MOST_THREADS, os.cpu_count() or 1)) as pool:
            list(pool.map(project, range(0, count, CHUNK)))
        return number, corners, status

    def backward(self, step: Array, start: NDArray[np.int64], planes: Array, low: Array, high: Array) -> int:
        """Shrink bounds of x to the controllable sets, from the last sample back to the first.

        Args:
            step: Length of each segment, Shape (n - 1,).
            start: The half-planes of sample i are start[i] .. start[i + 1] - 1, Shape (n + 1,).
            planes: Shape (E, 3).
            low: Least x; changed in place, Shape (n,).
            high: Largest x; changed in place, Shape (n,).

        Returns:
            The sample that has none, -1 if all have one.
        """
        run = self.loaded.mrts_backward
        run.restype = ctypes.c_longlong
        arrays = (step, start, planes, low, high, _segment_work(start))
        return int(run(ctypes.c_longlong(len(step)), *(pointer(array) for array in arrays)))

    def forward(
        self, step: Array, start: NDArray[np.int64], planes: Array, low: Array, high: Array, first: float
    ) -> Array:
        """The largest controllable x at every sample, from `first` on, Shape (n,); arguments as in `backward`."""
        x = np.zeros(len(step) + 1)
        x[0] = first
        arrays = (step, start, planes, low, high, x, _segment_work(start))
        self.loaded.mrts_forward(ctypes.c_longlong(len(step)), *(pointer(array) for array in arrays))
        return x

    def _batch(self, name: str, arrays: list[Array]) -> tuple[Array, Array, NDArray[np.uint8]]:
        count, rows, k = arrays[-3].shape
        arrays = [np.ascontiguousarray(np.clip(array, -1e300, 1e300)) for array in arrays]
        x, dual, status = np.zeros((count, k)), np.zeros((count, rows + k)), np.zeros(count, dtype=np.uint8)
        work, iwork = np.zeros(3 * k * k + 9 * k), np.zeros(rows + 7 * k + 1, dtype=np.int32)
        pointers = [pointer(array) for array in (*arrays, x, dual, status, work, iwork)]
        getattr(self.loaded, name)(ctypes.c_longlong(count), k, rows, *pointers)
        return x, dual, status


def _segment_work(start: NDArray[np.int64]) -> Array:
    """Room for the half-planes of a segment: those of two samples, and two for its end."""
    return np.zeros(3 * (2 * int(np.max(np.diff(start))) + 2))


def load_or_rebuild(command: tuple[str, ...], name: str, source: str, load: Callable[[Path], Library]) -> Library:
    """Load a library from the cache; a damaged one is compiled again.

    Args:
        command: Compiler, from `find_compiler`.
        name: Of its files.
        source: Its C text.
        load: Raises OSError where the file cannot be loaded, AttributeError where it lacks a function.

    Raises:
        CompilerError: If the compiler fails, or makes what cannot be loaded.
    """
    try:
        return load(library_in_cache(command, name, source))
    except (OSError, AttributeError):
        pass
    try:
        return load(library_in_cache(command, name, source, rebuild=True))
    except (OSError, AttributeError) as error:
        raise CompilerError(
            f"what compiler {' '.join(command)} made of {name} cannot be loaded: {error}. Set CC to a working one."
        ) from None


def kernel_library(command: tuple[str, ...]) -> KernelLibrary:
    """The kernel without a cell, compiled on first use.

    Raises:
        CompilerError: If the compiler fails.
    """
    files = (*KERNEL_FILES, "projection.c", "reachability.c")
    return load_or_rebuild(command, "mrts_kernel", kernel_text(files), KernelLibrary)


@lru_cache(maxsize=1)
def default_kernel() -> KernelLibrary:
    """The kernel by the compiler that is found.

    Raises:
        CompilerError: If there is none, or it fails.
    """
    command = find_compiler()
    if command is None:
        raise CompilerError(
            "our kernel needs a C compiler. Install one (Debian: apt-get install gcc libc6-dev) or set CC."
        )
    return kernel_library(command)


def kernel_text(names: Sequence[str]) -> str:
    """C text of some files of mrts/kernel, in order, ready to compile."""
    return f"#include <math.h>\n#define MRTS_EXPORT {EXPORT}\n" + "\n".join(kernel_file(name) for name in names)


def kernel_file(name: str) -> str:
    """Text of one file of mrts/kernel/c."""
    return (files("mrts") / "kernel" / "c" / name).read_text(encoding="utf-8")


def pointer(array: NDArray[Any]) -> ctypes.c_void_p:
    """Address of an array's first entry."""
    return ctypes.c_void_p(array.ctypes.data)
