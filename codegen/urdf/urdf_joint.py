# SPDX-License-Identifier: MIT
"""One joint of a URDF: its axis, its limits, and where it puts its child."""

from math import cos, sin
from pathlib import Path

import numpy as np
from mrts_codegen.urdf.urdf_file import UrdfJoint

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.rigid_transform import RigidTransform, snap_rotation

MOVING_TYPES = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic"}

NO_LIMIT = 1e9
"""A limit of this size or more (1e16, the largest float, inf) says "none" [rad, m, N m, N, rad/s, m/s]: no motor gives
a giganewton, and none of the URDFs that people publish has a real limit above 1e5."""


def unit_axis(path: Path, joint: UrdfJoint) -> Array:
    """Direction of a joint's axis in its own frame, Shape (3,)."""
    length = float(np.sqrt(sum(joint.axis * joint.axis)))
    if not 0 < length < np.inf:
        raise InputError(path, "must not be zero.", key=f"joint '{joint.name}' axis", value=joint.axis.tolist())
    return np.asarray(joint.axis / length)


def position_limits(path: Path, joint: UrdfJoint) -> tuple[float, float]:
    """Lower and upper position limit [rad or m], infinite where there is none."""
    if joint.type == "continuous":
        return -np.inf, np.inf
    lower, upper = (None if value is None or abs(value) >= NO_LIMIT else value for value in (joint.lower, joint.upper))
    if lower is not None and upper is not None and lower > upper:
        raise InputError(
            path,
            f"its lower limit {lower:g} exceeds its upper limit {upper:g}. Correct them; a joint without limits is "
            "'continuous', or has none of the two.",
            key=f"joint '{joint.name}'",
        )
    return -np.inf if lower is None else float(lower), np.inf if upper is None else float(upper)


def velocity_limit(path: Path, joint: UrdfJoint) -> float | None:
    """Largest velocity [rad/s or m/s], None if the URDF says nothing."""
    velocity = joint.velocity
    if velocity is not None and velocity < 0:
        raise InputError(path, "must be >= 0.", key=f"joint '{joint.name}' velocity limit", value=velocity)
    return float(velocity) if velocity and velocity < NO_LIMIT else None


def friction(path: Path, joint: UrdfJoint) -> tuple[float, float]:
    """Dry friction [N m or N] and damping [N m s/rad or N s/m] of a joint, 0 where the URDF says nothing."""
    for name in ("friction", "damping"):
        if not 0 <= getattr(joint, name) < NO_LIMIT:
            key = f"joint '{joint.name}', <dynamics> {name}"
            raise InputError(path, f"must be >= 0 and below {NO_LIMIT:.0e}.", key=key, value=getattr(joint, name))
    return joint.friction, joint.damping


def joint_pose(path: Path, joint: UrdfJoint, position: float = 0.0) -> RigidTransform:
    """Frame of the child link in the frame of the parent link, where the joint stands at a position [rad or m]."""
    T = joint.origin
    if position == 0:
        return T
    axis = unit_axis(path, joint)
    if MOVING_TYPES[joint.type] == "prismatic":
        return T @ RigidTransform(np.eye(3), position * axis)
    return T @ RigidTransform(_rotation_about(axis, position), np.zeros(3))


def _rotation_about(axis: Array, angle: float) -> Array:
    """Rodrigues' formula, Shape (3, 3)."""
    c, s = cos(angle), sin(angle)
    x, y, z = axis
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return snap_rotation(c * np.eye(3) + s * skew + (1 - c) * axis[:, None] * axis[None, :])
