# SPDX-License-Identifier: MIT
"""What a cell leaves unsaid, and what is taken instead."""

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mrts.base.remark import Remark
from mrts.cell.motors.joint_source import JointSource

if TYPE_CHECKING:
    from mrts.cell.cell import Cell

WEIGHTLESS = "no mass in the URDF, so its links weigh nothing: torques come out too small, and speeds too high"
"""Said of joints whose links have no mass."""

POINT_MASSES = "a mass but no inertia in the URDF, so it counts as a point: turning it costs too little torque"
"""Said of links."""

NO_COLLISIONS = "collisions are not looked at: not of arms and hands with each other, the object or the room"
"""Said wherever somebody could think they were: of cells that are begun, checked, or laid out."""

NAMES_SHOWN = 12
"""Joints or links that a sentence names."""


def missing_masses(joints: Sequence[JointSource]) -> Iterator[Remark]:
    """That links have no mass, or a mass but no inertia, in the URDF."""
    weightless = [joint for joint in joints if joint.carried_mass == 0]
    if weightless:
        yield Remark("links-without-mass", f"{WEIGHTLESS} ({_named(weightless, joints)})")
    points: dict[str, list[str]] = {}
    for joint in joints:
        points.setdefault(joint.robot, []).extend(joint.point_links)
    if any(points.values()):
        named = (f"{robot}: {first_few(links)}" for robot, links in points.items() if links)
        yield Remark("links-without-inertia", f"{POINT_MASSES} ({'; '.join(named)})")


def assumptions(cell: "Cell", joints: Sequence[JointSource]) -> Iterator[Remark]:
    """A remark on each thing that is taken for granted."""
    of_urdf = {joint.robot: None for joint in joints if joint.torque_from == "URDF"}
    if of_urdf:
        text = f"torque limits: the effort limits of the URDF ({', '.join(of_urdf)}); 'torque' gives others"
        yield _assumed("torque-of-urdf", text)
    rules: list[tuple[str, str, Callable[[JointSource], bool]]] = [
        ("no-velocity-limit", "no velocity limit, so none is kept", lambda joint: joint.velocity is None),
        (
            "no-position-limit",
            "no position limit, so none is kept",
            lambda joint: joint.position == (-np.inf, np.inf),
        ),
        (
            "no-friction",
            "no friction given, so none counts: 'motors: {friction: …}'",
            lambda joint: joint.friction_from == "none given",
        ),
        (
            "no-armature",
            "no rotor inertia given, so none counts: 'motors: {armature: …}'",
            lambda joint: joint.armature is None,
        ),
    ]
    for code, text, applies in rules:
        concerned = [joint for joint in joints if applies(joint)]
        if concerned:
            yield _assumed(code, f"{text} ({_named(concerned, joints)})")
    yield _assumed(
        "com-at-origin", "the object's centre of mass is the origin of its frame, and its inertia is about that"
    )
    if not np.any(np.isfinite(cell.object_velocity_limit)):
        yield _assumed("no-object-velocity", "the object may move at any speed: no 'object: {velocity: …}'")
    free = [
        robot.name
        for robot in cell.robots
        if not robot.contacts and not np.any(np.isfinite([robot.wrench_lower, robot.wrench_upper]))
    ]
    yield _assumed("no-collisions", NO_COLLISIONS)
    if free:
        yield _assumed(
            "no-wrench-limit", f"hands hold whatever comes: no 'wrench' and no 'contact' ({', '.join(free)})"
        )


def _assumed(code: str, text: str) -> Remark:
    return Remark(code, text, severity="assumption")


def first_few(names: Sequence[str]) -> str:
    """The first of many names, and how many more there are."""
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
