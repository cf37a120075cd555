# SPDX-License-Identifier: MIT
"""'Hold it here, now': grasps from where the hands are."""

from collections.abc import Sequence

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import check_type
from mrts.base.formats.record import Pose
from mrts.base.input_file import plain
from mrts.base.rigid_transform import RigidTransform, snap_rotation
from mrts.cell.cell import Cell
from mrts.following.bodies import tip_at_posture


def hold_here(cell: Cell, xyz: Sequence[float] | Array, rpy: Sequence[float] | Array = (0.0, 0.0, 0.0)) -> Cell:
    """The same cell with every hand holding the object where the hand is now: at its robot's `posture`.

    Args:
        cell: The cell; its postures say where the hands are.
        xyz: Where the object is: position of its frame in the world, Shape (3,) [m].
        rpy: Roll, pitch, yaw in URDF's convention, Shape (3,) [rad].

    Returns:
        The cell with other grasps. With a motion that starts at this pose, the arms start at their postures.

    Raises:
        InputError: If a value breaks a rule of the cell file, or a hand of a planar cell is out of the plane.
    """
    check_type("cell", cell, Cell)
    given = {"xyz": plain("hold_here", xyz), "rpy": plain("hold_here", rpy)}
    T_world_object = Pose.read("hold_here", given).transform
    grasps = {}
    for robot in cell.robots:
        held = T_world_object.inverse() @ tip_at_posture(robot)
        grasps[f"robots.{robot.name}.grasp"] = RigidTransform(snap_rotation(held.R), np.array(held.p))
    return cell.with_values(grasps)
