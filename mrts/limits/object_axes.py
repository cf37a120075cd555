# SPDX-License-Identifier: MIT
"""Contact wrenches in the object's axes, in which what a hand can exert stays the same along a motion."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.cell.hands import triple_axes
from mrts.following.coordinated_motion import CoordinatedMotion


@dataclass(frozen=True, eq=False)
class ObjectAxes:
    """What turns the wrenches of n arms from the axes of their bases into the object's at N samples, triple by triple.

    A spatial wrench has two triples, forces and moments, a planar one a single triple of two forces and a moment.

    Attributes:
        rotation: R of the object, Shape (N, 3, 3).
        base: Rotation of each base in the world, its columns those of `axes`, Shape (n, 3, 3).
        axes: x, y, z (0, 1, 2) in the order in which a triple has them.
    """

    rotation: Array
    base: Array
    axes: tuple[int, ...]

    @cached_property
    def turn(self) -> Array:
        """The matrices of a triple, Rᵀ R_base, Shape (N, n, 3, 3)."""
        rows = self.rotation.transpose(0, 2, 1)[:, None, self.axes]
        return np.asarray(rows @ self.base, dtype=np.float64)

    def turned(self, wrench: Array) -> Array:
        """Wrenches in object axes, of the same shape.

        Args:
            wrench: All wrenches in base axes, or columns of a matrix that maps to them, Shape (N, n w, …).
        """
        count, arms = len(wrench), len(self.base)
        triples = wrench.reshape(count, arms, -1, 3, int(np.prod(wrench.shape[2:])))
        turned: Array = self.turn[:, :, None] @ triples
        return turned.reshape(wrench.shape)

    def at(self, samples: NDArray[np.int_] | slice) -> "ObjectAxes":
        """The same at some samples only."""
        return replace(self, rotation=self.rotation[samples])

    def fit(self, cell: Cell, motion: CoordinatedMotion) -> bool:
        """Whether these are the axes of a cell along a motion."""
        theirs = object_axes(cell, motion)
        pairs = ((self.rotation, theirs.rotation), (self.base, theirs.base))
        return self.axes == theirs.axes and all(
            ours is others or np.array_equal(ours, others) for ours, others in pairs
        )


def object_axes(cell: Cell, motion: CoordinatedMotion) -> ObjectAxes:
    """The axes of a cell's wrenches along a motion."""
    axes = triple_axes(cell.wrench_components)
    base = np.array([robot.T_world_base.R[:, axes] for robot in cell.robots])
    return ObjectAxes(motion.object.rotation, base, tuple(axes))
