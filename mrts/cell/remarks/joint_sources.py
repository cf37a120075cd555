# SPDX-License-Identifier: MIT
"""What is known of every joint of a cell, and where it is from."""

from math import inf
from typing import TYPE_CHECKING

from mrts.cell.motors.joint_source import JointSource
from mrts.cell.robot import has_torque_of_urdf

if TYPE_CHECKING:
    from mrts.cell.cell import Cell


def joint_sources(cell: "Cell") -> tuple[JointSource, ...]:
    """What is known of the joints of all arms in order.

    Args:
        cell: The cell.
    """
    sources = []
    for robot, record in zip(cell.robots, cell.functions.manifest.robots, strict=True):
        torque_from = "URDF" if has_torque_of_urdf(robot, record) else "cell file"
        motors, units = robot.motors, robot.position_units
        pairs = ((robot.position_lower, robot.position_upper), (robot.torque_lower, robot.torque_upper))
        limits = (zip(lower.tolist(), upper.tolist(), strict=True) for lower, upper in pairs)
        of_motors = zip(motors.coulomb.tolist(), motors.viscous.tolist(), motors.armature.tolist(), strict=True)
        rows = zip(record.joints, units, *limits, robot.velocity_limit.tolist(), of_motors, strict=True)
        for joint, unit, position, torque, velocity, (coulomb, viscous, armature) in rows:
            some = "URDF" if coulomb or viscous else "none given"
            sources.append(
                JointSource(
                    robot=robot.name,
                    joint=joint.name,
                    unit=unit,
                    position=position,
                    velocity=None if velocity == inf else velocity,
                    torque=torque,
                    torque_from=torque_from,
                    friction_from=some if record.friction_from_urdf else "cell file",
                    armature=armature or None,
                    carried_mass=joint.carried_mass,
                    point_links=tuple(joint.point_links),
                )
            )
    return tuple(sources)
