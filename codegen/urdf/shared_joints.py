# SPDX-License-Identifier: MIT
"""Robots that are arms of one machine: none may move a joint that another moves as well, or takes to stand still."""

from collections.abc import Mapping, Sequence
from itertools import combinations, permutations
from pathlib import Path
from typing import TYPE_CHECKING

from mrts_codegen.urdf.robot_model import frame_in_root

from mrts.base.errors import InputError
from mrts.base.rigid_transform import SAME_PLACE, RigidTransform, in_one_place

if TYPE_CHECKING:
    from mrts_codegen.cell_model import BuiltRobot


def check_machines(path: Path, arms: Sequence["BuiltRobot"]) -> tuple[tuple[str, str], ...]:
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


def _moving(arm: "BuiltRobot") -> dict[str, float]:
    return dict(zip(arm.robot.joints, arm.robot.posture.tolist(), strict=True))


def _still(arm: "BuiltRobot") -> set[str]:
    """Joints that could move, but are taken to stand still by an arm."""
    below = arm.urdf.joints_to(arm.model.tip_link)
    names = {joint.name for joint in below if joint.moves}
    return names.union(arm.robot.held).difference(arm.robot.joints)


def _root(arm: "BuiltRobot", positions: Mapping[str, float]) -> RigidTransform:
    """Root of the URDF in the world, where the joints up to the base link stand at given positions."""
    return arm.robot.T_world_base @ frame_in_root(arm.urdf, arm.model.base_link, positions).inverse()


def _of_one_machine(first: "BuiltRobot", second: "BuiltRobot") -> bool:
    """Whether two arms of one URDF are of one machine, with the joints between their bases at zero or as postured."""
    held = {**first.robot.held, **second.robot.held}
    moving = {**_moving(first), **_moving(second)}
    return any(in_one_place(_root(first, positions), _root(second, positions)) for positions in (held, moving | held))


def _check_pair(path: Path, first: "BuiltRobot", second: "BuiltRobot") -> None:
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
