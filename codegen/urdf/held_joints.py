# SPDX-License-Identifier: MIT
"""Joints that stand still (`fixed` in the cell file), and robots that are arms of one machine.

None of these may move a joint that another moves as well, or takes to stand still.
"""

from collections.abc import Mapping, Sequence
from itertools import combinations, permutations
from pathlib import Path

from mrts_codegen.urdf.robot_model import BuiltRobot, frame_in_root

from mrts.base.errors import InputError, did_you_mean
from mrts.base.formats.urdf import Urdf, UrdfJoint
from mrts.base.rigid_transform import SAME_PLACE, RigidTransform, in_one_place


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


def check_machines(path: Path, arms: Sequence[BuiltRobot]) -> tuple[tuple[str, str], ...]:
    """Check that arms of one machine, one URDF in one place, agree on what moves.

    Each arm has joints of its own in the dynamics. A torso that two arms share would be there twice, each copy free to
    move without the other.

    Returns:
        Names of each two robots that are arms of one machine.
    """
    machines = []
    for first, second in combinations(arms, 2):
        if first.robot.source.sha256 == second.robot.source.sha256 and _of_one_machine(first, second):
            _check_pair(path, first, second)
            machines.append((first.robot.name, second.robot.name))
    return tuple(machines)


def _moving(arm: BuiltRobot) -> dict[str, float]:
    return dict(zip(arm.robot.joints, arm.robot.posture.tolist(), strict=True))


def _still(arm: BuiltRobot) -> set[str]:
    """Joints that could move, but are taken to stand still by an arm."""
    below = arm.urdf.joints_to(arm.model.tip_link)
    names = {joint.name for joint in below if joint.moves}
    return names.union(arm.robot.held).difference(arm.robot.joints)


def _root(arm: BuiltRobot, positions: Mapping[str, float]) -> RigidTransform:
    """Root of the URDF in the world, where the joints up to the base link stand at given positions."""
    return arm.robot.T_world_base @ frame_in_root(arm.urdf, arm.model.base_link, positions).inverse()


def _of_one_machine(first: BuiltRobot, second: BuiltRobot) -> bool:
    """Whether two arms of one URDF are of one machine, with the joints between their bases at zero or as postured."""
    held = {**first.robot.held, **second.robot.held}
    moving = {**_moving(first), **_moving(second)}
    return any(in_one_place(_root(first, positions), _root(second, positions)) for positions in (held, moving | held))


def _check_pair(path: Path, first: BuiltRobot, second: BuiltRobot) -> None:
    names = f"'{first.robot.name}' and '{second.robot.name}'"
    machine = f"robots {names} are arms of one machine (one URDF in one place)"
    shared = [name for name in _moving(first) if name in _moving(second)]
    if shared and {*shared} == {*_moving(first)} == {*_moving(second)}:
        same = f"robots {names} are one and the same arm: one URDF, one place, the same joints."
        raise InputError(path, f"{same} Give each its own 'base'.", key="robots")
    if shared:
        last = next(joint.child for joint in first.urdf.joints.values() if joint.name == shared[-1])
        held = ", ".join(f"{name}: POSITION" for name in shared)
        raise InputError(
            path,
            f"{machine} and both move its {_quoted(shared)}, which cannot follow two arms at once. Hold still what "
            f"they share, 'fixed: {{{held}}}' in both robots, or let both chains start past it: 'base_link: {last}', "
            "with 'base' where that link then is in the world.",
            key="robots",
        )
    for one, other in permutations((first, second)):
        torn = [name for name in _moving(one) if name in _still(other)]
        if torn:
            held = ", ".join(f"{name}: POSITION" for name in torn)
            raise InputError(
                path,
                f"{machine}: '{one.robot.name}' moves its {_quoted(torn)}, on which '{other.robot.name}' is taken to "
                f"stand still. Hold it still in both, 'fixed: {{{held}}}'.",
                key="robots",
            )
    for name, position in first.robot.held.items():
        if abs(second.robot.held.get(name, position) - position) > SAME_PLACE:
            raise InputError(
                path,
                f"{machine}, but its joint '{name}' is held at {position:g} by one and at "
                f"{second.robot.held[name]:g} by the other. Give it one position.",
                key="robots",
            )


def _quoted(names: list[str]) -> str:
    joints = ", ".join(f"'{name}'" for name in names)
    return f"joint{'s' if len(names) > 1 else ''} {joints}"
