# SPDX-License-Identifier: MIT
"""Joints that a cell holds still (`fixed` in the cell file): that they can be, and where they stand."""

from pathlib import Path

from mrts_codegen.urdf.urdf_file import Urdf, UrdfJoint
from mrts_codegen.urdf.urdf_joint import MOVING_TYPES, position_limits

from mrts.base.errors import InputError, did_you_mean


def held_positions(path: Path, key: str, urdf_path: Path, urdf: Urdf, fixed: dict[str, float]) -> dict[str, float]:
    """Positions of the joints that stand still: those of `fixed`, and what moves with them (mimic) [rad or m]."""
    joints = {joint.name: joint for joint in urdf.joints}
    for name, position in fixed.items():
        _check_joint(path, f"{key}.{name}", urdf_path, joints, name, position)
    held = {name: float(position) for name, position in fixed.items()}
    for _ in joints:  # a follower of a follower takes another round
        followers = {
            joint.name: held[joint.mimic.joint] * joint.mimic.multiplier + joint.mimic.offset
            for joint in urdf.joints
            if joint.mimic is not None and joint.mimic.joint in held and joint.type in MOVING_TYPES
        }
        if followers.items() <= held.items():
            break
        held |= followers
    return held


def _check_joint(
    path: Path, key: str, urdf_path: Path, joints: dict[str, UrdfJoint], name: str, position: float
) -> None:
    if name not in joints:
        movable = [joint.name for joint in joints.values() if joint.type in MOVING_TYPES]
        rule = (
            f"{urdf_path.name} has no such joint{did_you_mean(name, movable)} Those that move are {', '.join(movable)}."
        )
        raise InputError(path, rule, key=key)
    joint = joints[name]
    if joint.type not in MOVING_TYPES:
        still = "does not move anyway: leave it out" if joint.type == "fixed" else "has no single position"
        raise InputError(path, f"this joint is of type '{joint.type}' and {still}.", key=key)
    if joint.mimic is not None:
        raise InputError(path, f"it moves with '{joint.mimic.joint}'; hold that joint, and it follows.", key=key)
    lower, upper = position_limits(urdf_path, joint)
    if not lower <= position <= upper:
        unit = "m" if joint.type == "prismatic" else "rad"
        raise InputError(
            path, f"must be within the joint's limits, [{lower:g}, {upper:g}] {unit}.", key=key, value=position
        )
