# SPDX-License-Identifier: MIT
"""Which joint positions a redundant arm takes of all that hold its grasp; kernel/c/tracking/null_space.c finds them.

Those nearest to a reference, near a limit measured in stretched joint positions: the minimiser of a distance H(q) on
the set that holds the grasp, so a function of the object's pose alone, whatever the samples and the speed (the extended
Jacobian method: Baillieul 1985; the gradient of H away from limits: Liégeois 1977). With the grasp's multipliers F

    h(q) - h(reference) = JᵀF,    h_j(q) = q_j + LIMIT_PUSH (x⁺⁵ - x⁻⁵),

where x⁺ and x⁻ grow from 0 to 1 over the zone beside the upper and the lower limit. Both equations, differentiated
along the path, give q' and q''.
"""

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot

LIMIT_ZONE = 0.5
"""Width of the zone beside each position limit, as a share of the joint's range: a narrow one brakes hard in it."""

WIDEST_ZONE = 3.0
"""Its largest width [rad or m], also that of a joint with a limit on one side only."""

NARROWEST_ZONE = 1e-3
"""Its smallest width [rad or m]: a joint whose limits coincide divides by it."""

LIMIT_PUSH = 20.0
"""What h adds at a limit [rad or m]: many times any distance to a reference, so that limits win over nearness."""

FOLD = 1e-3
"""Curvature of H on the set that holds the grasp (1 far from limits on a flat set) below which its minimum ends."""


def limit_zone(robot: Robot) -> Array:
    """Width of the zone beside each joint's position limits, Shape (n_i,) [rad or m]."""
    zone: Array = np.clip(LIMIT_ZONE * (robot.position_upper - robot.position_lower), NARROWEST_ZONE, WIDEST_ZONE)
    return zone


def stretched(robot: Robot, q: Array) -> Array:
    """h(q), Shape (T, n_i).

    Args:
        q: Its joint positions, Shape (T, n_i) [rad or m].
    """
    zone = limit_zone(robot)
    over = np.maximum((q - robot.position_upper) / zone + 1, 0)
    under = np.maximum((robot.position_lower - q) / zone + 1, 0)
    h: Array = q + LIMIT_PUSH * (over**5 - under**5)
    return h


def is_redundant(cell: Cell, robot: Robot) -> bool:
    """Whether an arm has more joints than its wrench has components."""
    return len(robot.joints) > len(cell.wrench_components)
