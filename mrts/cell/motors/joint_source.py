# SPDX-License-Identifier: MIT
"""What is known of a joint and of its motor, and where it is from."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class JointSource:
    """One joint of a cell.

    Attributes:
        robot: Name of its arm.
        joint: Its own.
        unit: "rad" or "m".
        position: Lower and upper limit, infinite where there is none [rad or m].
        velocity: Limit of the URDF, None where there is none [rad/s or m/s].
        torque: Lower and upper limit [N m or N].
        torque_from: "cell file" or "URDF".
        friction_from: "cell file", "URDF", or "none given", which counts as 0.
        armature: Rotor inertia on the joint side [kg m² or kg], None where none is given, which counts as 0.
        carried_mass: Of the links that it carries up to the next joint, 0 where the URDF gives none [kg].
        point_links: Those of these links that have a mass but no inertia in the URDF.
    """

    robot: str
    joint: str
    unit: str
    position: tuple[float, float]
    velocity: float | None
    torque: tuple[float, float]
    torque_from: str
    friction_from: str
    armature: float | None
    carried_mass: float
    point_links: tuple[str, ...]
