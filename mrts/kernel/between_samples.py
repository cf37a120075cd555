# SPDX-License-Identifier: MIT
"""A motion between its samples, in one foreign call (kernel/c/dense)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.binding import structure
from mrts.kernel.cell_library import CellLibrary

PATH = structure("dense/path_places.c", "mrts_joint_path")


def path_places(
    library: CellLibrary,
    path: tuple[Array, Array, Array, Array],
    weights: tuple[Array, Array, Array],
    speeds: tuple[Array, Array],
    geometry: Array,
    components: Sequence[int],
) -> tuple[Array, ...]:
    """Joints and object at p places inside each segment of a path, played at some speeds.

    Args:
        library: Of the cell.
        path: The parameter of the path, Shape (N,), and q and its derivatives by it, each Shape (N, m).
        weights: Where the places are in a segment, Shape (p,), what velocities and accelerations at its ends weigh
            there, Shape (p, 3, 4), and in the way over a whole segment, Shape (4,); `polynomial_weights` of
            mrts/following/denser_motion.py.
        speeds: The squared speed at the samples, Shape (N,), and half its slope at the start and at the end of each
            segment, a line in between, Shape (N - 1, 2).
        geometry: Of the cell.
        components: Those of a twist that a wrench of the cell has.

    Returns:
        The parameter of the path from the first place on, Shape (p (N - 1),), q, q̇, q̈, each Shape (p (N - 1), m), and
        of the object position, Shape (p (N - 1), 3), rotation, (…, 3, 3), twist and acceleration, each (…, 6).
    """
    given = [np.ascontiguousarray(array, dtype=np.float64) for array in (*path, weights[1], weights[0], weights[2])]
    along = PATH(*(array.ctypes.data for array in given), len(weights[0]))
    asked: list[NDArray[Any]] = [np.ascontiguousarray(array, dtype=np.float64) for array in (*speeds, geometry)]
    taken = np.array(components, dtype=np.int32)
    count = len(weights[0]) * (len(path[0]) - 1)
    shapes = [(), *[(library.joints,)] * 3, (3,), (3, 3), (6,), (6,)]
    found = [np.empty((count, *shape)) for shape in shapes]
    library.opened.mrts_path_places(count, along, *asked, taken, *found)
    for array in found:
        array.setflags(write=False)  # so that motions share them
    by_columns = found[5]  # as generated functions want them, so that nobody has to turn them over for those
    return *found[:5], by_columns.transpose(0, 2, 1), *found[6:]
