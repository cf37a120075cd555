# SPDX-License-Identifier: MIT
"""A cell's generated C and our kernel in one shared library: whole trajectories in one foreign call."""

import ctypes
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.manifest import FunctionRecord, Manifest
from mrts.kernel.binding import bind, structure
from mrts.kernel.c_text import CELL_FILES, SELDOM, TRACKING_FILES
from mrts.kernel.foreign_arrays import INFINITY, keep_freed_memory, work_arrays
from mrts.kernel.programs import Programs, offer_programs
from mrts.kernel.sample_terms import SampleTerms

LIMITS = structure("rows.h", "mrts_limits")


class SparseLimits:
    """Rows over torques and wrenches in compressed form, as C reads them.

    Args:
        matrix: Of all torques and all wrenches, Shape (r, m + n w), or of the wrenches in object axes as well, Shape
            (r, m + 2 n w).
        lower: Shape (r,), minus infinity where unbounded.
        upper: Shape (r,), infinity where unbounded.
        group: Of each row, such as "N m": a limit of zero is measured by the largest of its group.
        base: Rotation of each base in the world, its columns those of `axes`, Shape (n, 3, 3); None where no row is in
            object axes.
        axes: x, y, z (0, 1, 2) in the order in which a triple of a wrench has them.

    Attributes:
        rows: r.
        entries: Row and column of each entry that is kept, each Shape (e,).
        values: Of the entries, Shape (e,).

    Raises:
        ValueError: If a lower limit is not at most the upper one.
    """

    def __init__(
        self,
        *,
        matrix: Array,
        lower: Array,
        upper: Array,
        group: Sequence[str],
        base: Array | None = None,
        axes: Sequence[int] = (0, 1, 2),
    ) -> None:
        if not np.all(lower <= upper):
            raise ValueError(f"rows {np.flatnonzero(~(lower <= upper)).tolist()}: a lower limit is above its upper one")
        self.rows = len(matrix)
        self.entries = row, column = np.nonzero(matrix)
        self.values = np.ascontiguousarray(matrix[row, column])
        start = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=self.rows))])
        units = list(dict.fromkeys(group))
        self._arrays: list[NDArray[Any]] = [
            np.ascontiguousarray(start, dtype=np.int32),
            np.ascontiguousarray(column, dtype=np.int32),
            self.values,
            np.ascontiguousarray(np.maximum(lower, -INFINITY)),
            np.ascontiguousarray(np.minimum(upper, INFINITY)),
            np.array([units.index(unit) for unit in group], dtype=np.int32),
        ]
        if base is not None:
            self._arrays += [np.ascontiguousarray(base), np.array(axes, dtype=np.int32)]
        self.structure = LIMITS(self.rows, *[array.ctypes.data for array in self._arrays])


class MotionLibrary:
    """The library of one cell, as far as following a motion takes it.

    Args:
        manifest: Manifest of the cell.
        library: Path of the shared library.
        seldom: Gives the library of a function that this one lacks, by short name.

    Attributes:
        opened: The library.
        records: Its generated functions by short name.
        robots: Number of them.
        joints: Of all arms.

    Raises:
        OSError: If it cannot be opened.
        AttributeError: If it lacks a function.
    """

    _files = TRACKING_FILES

    def __init__(self, manifest: Manifest, library: Path, seldom: Callable[[str], ctypes.CDLL] | None = None) -> None:
        self.opened, self._seldom = bind(ctypes.CDLL(str(library)), self._files), seldom
        self.records = manifest.functions
        self.robots = len(manifest.robots)
        self.joints = sum(len(robot.joints) for robot in manifest.robots)

    def map(self, name: str, samples: int, inputs: dict[str, Array]) -> dict[str, Array]:
        """Evaluate a generated function at all samples; see `mrts.cell.functions.CellFunctions`."""
        record = self.records[name]
        given, strides = sample_inputs(record, samples, inputs)
        outputs = {item.name: np.empty((samples, item.shape[1], item.shape[0])) for item in record.outputs}
        sizes = (ctypes.c_longlong * len(outputs))(*[item.shape[0] * item.shape[1] for item in record.outputs])
        filled = pointers(list(outputs.values()))
        if name == "wrench_form":  # in lanes, a third of the time
            self.opened.mrts_forms(samples, pointers(given), strides, filled, sizes)
        else:
            given_as = len(given), pointers(given), strides
            self.opened.mrts_map(self.address(name), samples, *given_as, len(outputs), filled, sizes)
        return {name: _by_rows(value) for name, value in outputs.items()}

    def address(self, function: str) -> ctypes.c_void_p:
        """Of a generated function, by its short name."""
        held_by = self.opened if self._seldom is None or function not in SELDOM else self._seldom(function)
        return ctypes.cast(getattr(held_by, self.records[function].symbol), ctypes.c_void_p)


class CellLibrary(MotionLibrary):
    """The library of one cell.

    Args:
        manifest: Manifest of the cell.
        library: Path of the shared library.
        seldom: As of `MotionLibrary`.

    Attributes:
        programs: The programs that it holds.
        unknowns: Wrenches of all arms but the last, and c².
        wrenches: Components of all wrenches.

    Raises:
        OSError: If it cannot be opened.
        AttributeError: If it lacks a function.
    """

    _files = CELL_FILES

    def __init__(self, manifest: Manifest, library: Path, seldom: Callable[[str], ctypes.CDLL] | None = None) -> None:
        keep_freed_memory()
        super().__init__(manifest, library, seldom)
        self.programs = Programs(self.opened)
        self.unknowns = len(manifest.wrench_components) * (len(manifest.robots) - 1) + 1
        self.wrenches = len(manifest.wrench_components) * len(manifest.robots)
        offer_programs(self.programs)

    def over_samples(
        self,
        name: str,
        samples: int,
        inputs: dict[str, Array],
        limits: SparseLimits,
        terms: SampleTerms,
        asked: Sequence[Array],
        outputs: Sequence[NDArray[Any]],
        for_all: tuple[Any, ...] = (),
    ) -> None:
        """Call a C function of whole trajectories of N samples.

        `asked` is what it takes of each sample, `for_all` what it takes besides, `outputs` what it fills; inputs are
        those of the wrench form, by name.
        """
        each = [np.ascontiguousarray(values) for values in asked]
        given, strides = sample_inputs(self.records["wrench_form"], samples, inputs)
        work = work_arrays(self.opened, name, limits.rows)
        where = samples, pointers(given), strides, limits.structure, terms.structure()
        failed = getattr(self.opened, name)(*where, *each, *for_all, *outputs, *work)
        assert not failed  # noqa: S101 (`SparseLimits` has looked at the limits)


def sample_inputs(record: FunctionRecord, samples: int, inputs: dict[str, Array]) -> tuple[list[Array], Any]:
    """Inputs as the generated C reads them (matrices by columns), and how far apart samples lie (0: one for all).

    Raises:
        ValueError: If an input has another shape: the C would read past its end.
    """
    given, strides = [], []
    for argument in record.inputs:
        rows, columns = argument.shape
        value = np.asarray(inputs[argument.name], dtype=np.float64)
        alone = value.shape == (rows,) and columns == 1
        if not alone and (columns > 1 or value.shape != (samples, rows)):
            if value.size != samples * rows * columns or len(value) != samples:
                raise ValueError(f"{argument.name} has Shape {value.shape}, not {(samples, rows, columns)}")
            value = value.reshape(samples, rows, columns).transpose(0, 2, 1)
        given.append(np.ascontiguousarray(value))
        strides.append(0 if alone else rows * columns)
    return given, (ctypes.c_longlong * len(strides))(*strides)


def _by_rows(value: Array) -> Array:
    return value[:, 0, :] if value.shape[1] == 1 else value.transpose(0, 2, 1)


def pointers(arrays: list[Array]) -> Any:
    """An array of pointers."""
    return (ctypes.c_void_p * len(arrays))(*[array.ctypes.data for array in arrays])
