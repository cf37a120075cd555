# SPDX-License-Identifier: MIT
"""How points of an arm move (kernel/c/point_motion.h)."""

from collections.abc import Sequence

import numpy as np

from mrts.base.arrays import Array
from mrts.kernel.cell_library import CellLibrary


def chain_point(
    library: CellLibrary, *, axes: Array, points: Array, slides: Sequence[bool], at_zero: Array, rates: Sequence[Array]
) -> tuple[Array, Array]:
    """Velocity p' and acceleration p'' of a point that a chain of joints moves, base axes, each Shape (N, 3).

    Args:
        library: Of any cell.
        axes: Of the k joints that move the point, with all of them at zero, base axes, of length 1, Shape (k, 3).
        points: One on each axis, likewise, Shape (k, 3) [m].
        slides: Whether each joint is prismatic.
        at_zero: The point, likewise, Shape (3,) [m].
        rates: q, q' and q'' of these joints, each Shape (N, k).
    """
    samples, joints = rates[0].shape
    chain = [np.ascontiguousarray(of) for of in (axes, points)]
    given = [np.ascontiguousarray(of) for of in (at_zero, *rates)]
    velocity, acceleration = np.empty((2, samples, 3))
    types = np.array(slides, dtype=np.int32)
    library.opened.mrts_arm_points(samples, joints, *chain, types, *given, velocity, acceleration)
    return velocity, acceleration
