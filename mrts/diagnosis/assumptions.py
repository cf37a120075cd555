# SPDX-License-Identifier: MIT
"""What a cell leaves unsaid, and what is taken instead."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from mrts.cell.cell import Cell
from mrts.motors.joint_source import JointSource

WEIGHTLESS = "no mass in the URDF, so its links weigh nothing: torques come out too small, and speeds too high"
"""Said of joints whose links have no mass."""

POINT_MASSES = "a mass but no inertia in the URDF, so it counts as a point: turning it costs too little torque"
"""Said of links."""

NO_COLLISIONS = "collisions are not looked at: not of arms and hands with each other, the object or the room"
"""Said wherever somebody could think they were: of cells that are begun, checked, or laid out."""

NAMES_SHOWN = 12
"""Joints or links that a sentence names."""


def assumptions(cell: Cell, joints: Sequence[JointSource]) -> Iterator[str]:
    """A sentence for each thing that is assumed.

    Args:
        cell: The cell.
        joints: Of its arms in order.
    """
    of_urdf = {joint.robot: None for joint in joints if joint.torque_from == "URDF"}
    if of_urdf:
        yield f"torque limits: the effort limits of the URDF ({', '.join(of_urdf)}); 'torque' gives others"
    rules: list[tuple[str, Callable[[JointSource], bool]]] = [
        ("no velocity limit, so none is kept", lambda joint: joint.velocity is None),
        ("no position limit, so none is kept", lambda joint: not np.any(np.isfinite(joint.position))),
        (WEIGHTLESS, lambda joint: joint.carried_mass == 0),
        (
            "no friction given, so none counts: 'motors: {friction: …}'",
            lambda joint: joint.friction_from == "none given",
        ),
        ("friction is that of the URDF's <dynamics>, often a placeholder", lambda joint: joint.friction_from == "URDF"),
        ("no rotor inertia given, so none counts: 'motors: {armature: …}'", lambda joint: joint.armature is None),
    ]
    for text, applies in rules:
        concerned = [joint for joint in joints if applies(joint)]
        if concerned:
            yield f"{text} ({_named(concerned, joints)})"
    points: dict[str, list[str]] = {}
    for joint in joints:
        points.setdefault(joint.robot, []).extend(joint.point_links)
    if any(points.values()):
        named = (f"{robot}: {first_few(links)}" for robot, links in points.items() if links)
        yield f"{POINT_MASSES} ({'; '.join(named)})"
    yield "the object's centre of mass is the origin of its frame, and its inertia is about that"
    if not np.any(np.isfinite(cell.object_velocity_limit)):
        yield "the object may move at any speed: no 'object: {velocity: …}'"
    free = [
        robot.name
        for robot in cell.robots
        if not robot.contacts and not np.any(np.isfinite([robot.wrench_lower, robot.wrench_upper]))
    ]
    yield NO_COLLISIONS
    if free:
        yield f"hands hold whatever comes: no 'wrench' and no 'contact' ({', '.join(free)})"


def first_few(names: Sequence[str]) -> str:
    """The first of many names, and how many more there are.

    Args:
        names: Of joints or links.
    """
    shown = ", ".join(names[:NAMES_SHOWN])
    return shown if len(names) <= NAMES_SHOWN else f"{shown} and {len(names) - NAMES_SHOWN} more"


def _named(concerned: Sequence[JointSource], joints: Sequence[JointSource]) -> str:
    """Arms and joints in few words."""
    if len(concerned) == len(joints):
        return "all joints"
    parts = []
    for robot in dict.fromkeys(joint.robot for joint in concerned):
        own = [joint.joint for joint in concerned if joint.robot == robot]
        whole = len(own) == sum(joint.robot == robot for joint in joints)
        parts.append(f"all of {robot}" if whole else f"{robot}: {', '.join(own)}")
    return "; ".join(parts)
