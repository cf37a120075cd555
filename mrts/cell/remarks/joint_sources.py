# SPDX-License-Identifier: MIT
"""What is known of every joint of a cell, and where it is from."""

from math import inf
from typing import TYPE_CHECKING

from mrts.cell.motors.joint_source import JointSource

if TYPE_CHECKING:
    from mrts.cell.cell import Cell


def joint_sources(cell: "Cell") -> tuple[JointSource, ...]:
    """What is known of the joints of all arms in order."""
    sources = []
    for robot in cell.robots:
        motors, source = robot.motors, robot.source
        for j, joint in enumerate(robot.joints):
            velocity, armature = float(robot.velocity_limit[j]), float(motors.armature[j])
            some = "URDF" if motors.coulomb[j] or motors.viscous[j] else "none given"
            sources.append(
                JointSource(
                    robot=robot.name,
                    joint=joint,
                    unit=robot.position_units[j],
                    position=(float(robot.position_lower[j]), float(robot.position_upper[j])),
                    velocity=None if velocity == inf else velocity,
                    torque=(float(robot.torque_lower[j]), float(robot.torque_upper[j])),
                    torque_from="URDF" if robot.has_urdf_torque else "cell file",
                    friction_from=some if robot.has_urdf_friction else "cell file",
                    armature=armature or None,
                    carried_mass=source.carried_mass[j],
                    point_links=source.point_links[j],
                )
            )
    return tuple(sources)
