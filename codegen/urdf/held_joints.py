# SPDX-License-Identifier: MIT
"""Joints that a cell holds still (`fixed` in the cell file): that they can be, and where they stand."""

from pathlib import Path

from mrts.base.errors import InputError, did_you_mean
from mrts.base.formats.urdf import Urdf, UrdfJoint


def held_positions(path: Path, key: str, urdf_path: Path, urdf: Urdf, fixed: dict[str, float]) -> dict[str, float]:
    """Positions of the joints that stand still: those of `fixed`, and what moves with them (mimic) [rad or m]."""
    joints = {joint.name: joint for joint in urdf.joints.values()}
    for name, position in fixed.items():
        _check_joint(path, f"{key}.{name}", urdf_path, joints, name, position)
    held = {name: float(position) for name, position in fixed.items()}
    for _ in joints:  # a follower of a follower takes another round
        followers = {
            joint.name: held[joint.mimic.joint] * joint.mimic.multiplier + joint.mimic.offset
            for joint in joints.values()
            if joint.mimic is not None and joint.mimic.joint in held and joint.moves
        }
        if followers.items() <= held.items():
            break
        held |= followers
    for name in held.keys() - fixed.keys():
        joints[name].check(urdf_path)
    return held


def _check_joint(
    path: Path, key: str, urdf_path: Path, joints: dict[str, UrdfJoint], name: str, position: float
) -> None:
    if name not in joints:
        movable = [joint.name for joint in joints.values() if joint.moves]
        rule = (
            f"{urdf_path.name} has no such joint{did_you_mean(name, movable)} Those that move are {', '.join(movable)}."
        )
        raise InputError(path, rule, key=key)
    joint = joints[name]
    if not joint.moves:
        still = "does not move anyway: leave it out" if joint.type == "fixed" else "has no single position"
        raise InputError(path, f"this joint is of type '{joint.type}' and {still}.", key=key)
    joint.check(urdf_path)
    if joint.mimic is not None:
        raise InputError(path, f"it moves with '{joint.mimic.joint}'; hold that joint, and it follows.", key=key)
    if not joint.lower <= position <= joint.upper:
        unit = "m" if joint.type == "prismatic" else "rad"
        rule = f"must be within the joint's limits, [{joint.lower:g}, {joint.upper:g}] {unit}."
        raise InputError(path, rule, key=key, value=position)
