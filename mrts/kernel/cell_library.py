# SPDX-License-Identifier: MIT
"""A cell's generated C and our kernel in one shared library: whole trajectories in one foreign call."""

import ctypes
from collections.abc import Callable, Collection
from functools import cache
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.manifest import OF_MOTION, FunctionRecord, Manifest
from mrts.kernel.binding import HEAD, POINTER, keep_freed_memory


class CellLibrary:
    """The libraries of one cell: `following`, what following a motion takes, and `opened`, all else over its samples.

    `unknowns` are the wrenches of all arms but the last, and c²; `wrenches` are those of all.

    Args:
        manifest: Manifest of the cell; where it has functions of the motion alone, nothing else is opened.
        part: Gives the library "motion", "cell", or one of a generated function that is in neither.
    """

    def __init__(self, manifest: Manifest, part: Callable[[str], ctypes.CDLL]) -> None:
        keep_freed_memory()
        self.records, self._part = manifest.functions, cache(part)
        self.following = part("motion")
        if "wrench_form" in self.records:
            self.opened = part("cell")
        self.robots, components = len(manifest.cell.robots), len(manifest.cell.wrench_components)
        self.joints = sum(len(robot.joints) for robot in manifest.cell.robots)
        self.unknowns, self.wrenches = components * (self.robots - 1) + 1, components * self.robots

    def map(self, name: str, samples: int, inputs: dict[str, Array], *, varying: bool = False) -> dict[str, Array]:
        """Evaluate a generated function at all samples; see `mrts.Cell.functions`.

        Where the speed varies, the maps of a formulation get the column of r̈ before that of ṙ², which is their last.
        """
        record = self.records[name]
        given, strides = sample_inputs(record, samples, inputs)
        outputs, sizes, ahead = dict[str, Array](), list[int](), list[int]()
        for short, (rows, columns) in record.outputs.items():
            ahead.append(rows if varying and short.endswith("_map") else 0)
            sizes.append(rows * columns + ahead[-1])
            outputs[short] = np.empty((samples, sizes[-1] // rows, rows))
        places = pointers(outputs.values())
        if name == "wrench_form":
            self.opened.mrts_forms(samples, varying, given, strides, places)
        else:
            still, moving = None, None
            if varying:
                moves = {"ddq": inputs["dq"], "object_acceleration": inputs["object_twist"]}
                rests = {of: np.zeros_like(inputs[of]) for of in ("dq", "object_twist")}
                still, _ = sample_inputs(record, samples, inputs | moves | rests)
                moving = pointers([np.empty(size) for size in sizes])
            of = self.address(name), samples, len(strides), given, still, strides
            self.following.mrts_map(*of, len(sizes), places, sizes, ahead, moving)
        for output, value in outputs.items():
            outputs[output] = value[:, 0] if value.shape[1] == 1 else value.transpose(0, 2, 1)
        return outputs

    def address(self, function: str) -> ctypes.c_void_p:
        """Of a generated function, by its short name."""
        held_by = self.following if function in OF_MOTION else self._part(function)
        return ctypes.cast(getattr(held_by, self.records[function].symbol), ctypes.c_void_p)


def sample_inputs(record: FunctionRecord, samples: int, inputs: dict[str, Array]) -> tuple[Any, list[int]]:
    """`pointers` to inputs as the generated C reads them (matrices by columns), and how far apart samples lie.

    They lie 0 apart where there is one for all.

    Raises:
        ValueError: If an input has another shape: the C would read past its end.
    """
    given, strides = list[Array](), list[int]()
    for name, (rows, columns) in record.inputs.items():
        value = np.asarray(inputs[name], dtype=np.float64)
        alone = value.shape == (rows,) and columns == 1
        if not alone and (columns > 1 or value.shape != (samples, rows)):
            if value.size != samples * rows * columns or len(value) != samples:
                raise ValueError(f"{name} has Shape {value.shape}, not {(samples, rows, columns)}")
            value = value.reshape(samples, rows, columns).transpose(0, 2, 1)
        given.append(np.ascontiguousarray(value))
        strides.append(0 if alone else rows * columns)
    return pointers(given), strides


def pointers(arrays: Collection[Array]) -> Any:
    """An array of pointers to arrays, which it keeps alive."""
    found: Any = (ctypes.c_void_p * len(arrays))(*[POINTER(id(array) + HEAD) for array in arrays])
    found.kept = arrays
    return found
