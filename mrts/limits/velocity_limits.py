# SPDX-License-Identifier: MIT
"""Limits of the joints' and the object's velocities: at every sample they bound c² from above."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import ActiveRow, RowName

TIE = 1e-7
"""Velocities that are this close to the one nearest to its limit bind with it."""

REST = 1e-12
"""A velocity below this share of its largest along the motion is rounding of rest."""


@dataclass(frozen=True)
class VelocityLimits:
    """What each velocity is of its limit along a given motion; s limits at N samples.

    Attributes:
        names: One a limit.
        limit: Shape (s,) [rad/s or m/s].
        share: |velocity| of the given motion over its limit, Shape (N, s).
    """

    names: tuple[RowName, ...]
    limit: Array
    share: Array

    def largest_c2(self) -> Array:
        """Largest c² that keeps all of them, infinity where nothing moves, Shape (N,)."""
        fastest = np.max(self.share, axis=1, initial=0.0)
        with np.errstate(divide="ignore"):
            return np.asarray(1 / fastest**2, dtype=np.float64)

    def binding(self, sample: int) -> tuple[ActiveRow, ...]:
        """Those that bound c² at a sample; none at rest."""
        share = self.share[sample]
        fastest = np.max(share, initial=0.0)
        if fastest == 0:
            return ()
        return tuple(
            ActiveRow(self.names[index], "upper", float(self.limit[index]))
            for index in np.flatnonzero(share >= (1 - TIE) * fastest)
        )


def velocity_limits(cell: Cell, motion: CoordinatedMotion) -> VelocityLimits:
    """The velocity limits of a cell along a motion; those that are infinite are left out, all if not enforced.

    Args:
        cell: The cell.
        motion: Its motion.
    """
    names = [
        RowName("velocity", robot.name, joint, "m/s" if kind == "prismatic" else "rad/s")
        for robot in cell.robots
        for joint, kind in zip(robot.joints, robot.joint_types, strict=True)
    ]
    names += [RowName("velocity", "object", "linear", "m/s"), RowName("velocity", "object", "angular", "rad/s")]
    limit = np.concatenate([*(robot.velocity_limit for robot in cell.robots), cell.object_velocity_limit])
    twist = motion.object.twist
    speeds = [np.linalg.norm(part, axis=1) for part in (twist[:, :3], twist[:, 3:])]
    kept = np.flatnonzero(np.isfinite(limit)) if cell.enforces_velocity_limits else np.zeros(0, dtype=int)
    speed = np.column_stack([np.abs(motion.dq), *speeds])[:, kept]
    speed[speed <= REST * np.max(speed, axis=0, initial=0.0)] = 0.0
    return VelocityLimits(tuple(names[index] for index in kept), limit[kept], speed / limit[kept])
