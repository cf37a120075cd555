# SPDX-License-Identifier: MIT
"""What a user should know of a cell: likely mistakes, links without a mass, and what is assumed."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import Remark
from mrts.base.formats.record import WHOLE_TURN
from mrts.base.rigid_transform import plane_normal
from mrts.base.words import first_names
from mrts.cell.cell import Cell
from mrts.cell.record import BodyShape, mesh_surface
from mrts.cell.robot import DEGREES_SUSPECTED, PRINTED_TOLERANCE, Robot

WIDE = 10.0
"""Lengths of an arm that no object's radius of gyration has."""

OF_SHAPE = 1 / 17, 1.5
"""Least and largest radius of gyration as a share of how far the shape, which may leave parts out, reaches."""

HEAVY = 30.0
"""Times the weight that the motors of all arms together hold at arm's length: the mass is in grams."""

ANY_JOINT = 100.0
"""Effort that no arm has in its last joint as in its first [N m]: published URDFs give 100, 300, 1000, 5e4."""

FEWEST_JOINTS = 3
"""Revolute joints from which on equal efforts are no accident."""

EARTHLY = (9.0, 10.5)
"""Sizes of a gravity that is meant to be the earth's [m/s²]."""

STRAIGHT = 0.9
"""Share of gravity along one axis from which on that is the vertical."""

WEIGHTLESS = "no mass in the URDF, so its links weigh nothing: torques come out too small, and speeds too high"

POINT_MASSES = "a mass but no inertia in the URDF, so it counts as a point: turning it costs too little torque"

NO_COLLISIONS = "collisions are not looked at: not of arms and hands with each other, the object or the room"
"""Said wherever somebody could think they were: of cells that are begun, checked, or laid out."""


COLLISIONS_UNKNOWN = "no-collisions"
"""Code of the remark that says so."""


JOINT_ASSUMPTIONS: tuple[tuple[str, str, Callable[[Robot], NDArray[np.bool_]]], ...] = (
    (
        "no-effort-limit",
        "no effort limit, so a cell gives 'torque'; mrts new assumes one",
        lambda robot: robot.torque_upper == np.inf,
    ),
    ("no-velocity-limit", "no velocity limit, so none is kept", lambda robot: robot.velocity_limit == np.inf),
    (
        "no-position-limit",
        "no position limit, so none is kept",
        lambda robot: (robot.position_lower == -np.inf) & (robot.position_upper == np.inf),
    ),
    (
        "no-friction",
        "no friction given, so none counts: 'motors: {friction: …}'",
        lambda robot: np.array([source == "none given" for source in friction_sources(robot)]),
    ),
    (
        "no-armature",
        "no rotor inertia given, so none counts: 'motors: {armature: …}'",
        lambda robot: robot.motors.armature == 0,
    ),
)

NAMES_SHOWN = 12


def cell_remarks(cell: Cell) -> Iterator[Remark]:
    """All that is to know of a cell: what its files and its numbers as they are now lead to."""
    yield from cell.remarks
    yield from _gravity(cell.gravity)
    for robot in cell.robots:
        yield from urdf_remarks(robot)
        yield from _posture(robot)
        yield from _efforts(robot)
    yield from _load(cell)
    yield from missing_masses(cell.robots)
    of_urdf = [robot.name for robot in cell.robots if robot.source.effort is not None]
    if of_urdf:
        text = f"torque limits: the effort limits of the URDF ({', '.join(of_urdf)}); 'torque' gives others"
        yield Remark.assumed("torque-of-urdf", text)
    yield from joint_assumptions(cell.robots)
    yield from _assumptions(cell)


def torque_source(robot: Robot) -> str:
    """Where its torque limits are from: "URDF" or "cell file"."""
    return "URDF" if robot.source.effort is not None else "cell file"


def friction_sources(robot: Robot) -> list[str]:
    """Where the friction of each joint is from: "cell file", "URDF", or "none given", which counts as 0."""
    if robot.source.friction is None:
        return ["cell file"] * len(robot.joints)
    return ["URDF" if some else "none given" for some in robot.motors.coulomb + robot.motors.viscous]


def urdf_remarks(robot: Robot) -> Iterator[Remark]:
    """Remarks on the position limits of a robot's URDF."""
    lower, upper = robot.position_lower, robot.position_upper
    stuck = [name for name, least, most in zip(robot.joints, lower, upper, strict=True) if least == most]
    if stuck:
        yield Remark.hint(
            "limits-equal",
            f"robot '{robot.name}' cannot move {', '.join(stuck)}: the upper position limit is the lower one, as "
            "exporters write it that were told none. Give the joint's own limits, or the type 'continuous'; the cell "
            "file's 'fixed' holds a joint on purpose.",
        )
    far = robot.turns & np.isfinite(lower) & np.isfinite(upper) & (np.maximum(-lower, upper) > DEGREES_SUSPECTED)
    if np.any(far):
        worst = int(np.argmax(far))
        yield Remark.hint(
            "limits-degrees",
            f"robot '{robot.name}' may turn {robot.joints[worst]} from {lower[worst]:g} to {upper[worst]:g} rad: the "
            "position limits of its URDF seem to be in degrees.",
        )


def link_lengths(robot: Robot) -> Array:
    """From joint to joint and to the tip, Shape (n,) [m]."""
    corners = np.concatenate([robot.points, robot.T_base_tip.p[None]])
    return np.asarray(np.linalg.norm(np.diff(corners, axis=0), axis=1))


def _gravity(gravity: Array) -> Iterator[Remark]:
    size, axis = float(np.linalg.norm(gravity)), int(np.argmax(np.abs(gravity)))
    if EARTHLY[0] <= size <= EARTHLY[1] and gravity[axis] > STRAIGHT * size:
        up = "xyz"[axis]
        text = f"gravity points along +{up}, so things fall that way. If {up} points upward, its sign is wrong."
        yield Remark.hint("gravity-upward", text)


def _posture(robot: Robot) -> Iterator[Remark]:
    far = robot.turns & (np.abs(robot.posture) > WHOLE_TURN)
    if np.any(far):
        yield Remark.hint(
            "posture-degrees",
            f"the posture of robot '{robot.name}' has {robot.joints[int(np.argmax(far))]} beyond a whole turn: "
            "is it in degrees? It must be in rad.",
        )
        return
    lower, upper, given = robot.position_lower, robot.position_upper, robot.posture
    outside = (given < lower - PRINTED_TOLERANCE) | (given > upper + PRINTED_TOLERANCE)
    for place in np.flatnonzero(outside & (lower < upper))[:1]:
        limits = f"[{lower[place]:.4g}, {upper[place]:.4g}]"
        text = f"the posture of robot '{robot.name}' has {robot.joints[place]} at {given[place]:.4g}, outside {limits}."
        yield Remark.hint("posture-outside", text)


def _efforts(robot: Robot) -> Iterator[Remark]:
    efforts = {*robot.torque_upper.tolist()}
    turning = np.count_nonzero(robot.turns) >= FEWEST_JOINTS
    if torque_source(robot) == "URDF" and turning and len(efforts) == 1:
        effort = efforts.pop()
        if ANY_JOINT <= effort < np.inf:
            yield Remark(
                "effort-placeholders",
                f"the URDF of robot '{robot.name}' allows {effort:g} N m in every joint, which looks like a "
                "placeholder: give the data sheet's as 'torque'",
            )


def _load(cell: Cell) -> Iterator[Remark]:
    lengths = [max(_arm_length(robot), 1e-3) for robot in cell.robots]
    held = sum(float(np.max(robot.torque_upper)) / length for robot, length in zip(cell.robots, lengths, strict=True))
    weight = float(np.linalg.norm(cell.gravity)) * cell.mass
    if weight > HEAVY * held > weight / 1000:
        text = f"the object weighs {weight:.4g} N, and the motors hold about {held:.3g} N: is its mass in g, not kg?"
        yield Remark.hint("mass-grams", text)
        return
    normals = np.linalg.eigh(cell.inertia)[1] if cell.plane is None else plane_normal(cell.plane)[:, None]
    radius = float(np.sqrt(np.max(np.sum(normals * (cell.inertia @ normals), axis=0)) / cell.mass))
    if radius > WIDE * max(lengths):
        yield Remark.hint(
            "inertia-unit",
            f"the object's inertia is that of a body {radius:.3g} m wide on each side of its axis (the radius of "
            "gyration): it must be in kg m², with a mass in kg. 1 kg mm² is 1e-6 kg m², 1 g mm² is 1e-9 kg m².",
        )
    elif cell.object_shape is not None:
        reach = _reach(cell, cell.object_shape)
        if not OF_SHAPE[0] * reach <= radius <= OF_SHAPE[1] * reach:
            yield Remark.hint(
                "inertia-unlike-shape",
                f"the object's inertia has a radius of gyration of {radius:.3g} m, its shape reaches {reach:.3g} m: "
                "without 'inertia', a 'shape' gives that of a uniform body.",
            )


def _reach(cell: Cell, shape: BodyShape) -> float:
    """How far a shape reaches from the object's origin at most [m]."""
    if shape.mesh is not None:
        corners = mesh_surface(shape, cell.surfaces)[0]
    else:
        of = shape.cylinder
        corners = np.array(shape.box)[None] / 2 if of is None else np.array([[of.radius, of.radius, of.length / 2]])
    return float(np.max(np.linalg.norm(corners, axis=1))) + float(np.linalg.norm(shape.pose.xyz))


def _arm_length(robot: Robot) -> float:
    """From the first joint to the tip along the links, and what prismatic joints add where they have limits [m]."""
    stroke = (robot.position_upper - robot.position_lower)[~robot.turns]
    return float(np.sum(link_lengths(robot)) + np.sum(stroke[np.isfinite(stroke)]))


def missing_masses(robots: Sequence[Robot]) -> Iterator[Remark]:
    """Warnings on links without a mass or an inertia."""
    if weightless := _named(robots, lambda robot: np.array(robot.source.carried_mass) == 0):
        yield Remark("links-without-mass", f"{WEIGHTLESS} ({weightless})")
    points = {robot.name: [link for links in robot.source.point_links for link in links] for robot in robots}
    if any(points.values()):
        named = (f"{robot}: {first_names(links, NAMES_SHOWN)}" for robot, links in points.items() if links)
        yield Remark("links-without-inertia", f"{POINT_MASSES} ({'; '.join(named)})")


def joint_assumptions(robots: Sequence[Robot]) -> Iterator[Remark]:
    """What is taken for granted of joints of which neither URDF nor cell file says it."""
    for code, text, applies in JOINT_ASSUMPTIONS:
        if named := _named(robots, applies):
            yield Remark.assumed(code, f"{text} ({named})")


def _assumptions(cell: Cell) -> Iterator[Remark]:
    text = "the object's centre of mass is the origin of its frame, and its inertia is about that"
    yield Remark.assumed("com-at-origin", text)
    if not np.any(np.isfinite(cell.object_velocity_limit)):
        yield Remark.assumed("no-object-velocity", "the object may move at any speed: no 'object: {velocity: …}'")
    yield Remark.assumed(COLLISIONS_UNKNOWN, NO_COLLISIONS)
    free = [
        robot.name
        for robot in cell.robots
        if not robot.contacts and not np.any(np.isfinite([robot.wrench_lower, robot.wrench_upper]))
    ]
    if free:
        text = f"hands hold whatever comes: no 'wrench' and no 'contact' ({', '.join(free)})"
        yield Remark.assumed("no-wrench-limit", text)


def _named(robots: Sequence[Robot], applies: Callable[[Robot], NDArray[np.bool_]]) -> str:
    """The joints to which something applies, in words; empty if to none."""
    chosen = [applies(robot) for robot in robots]
    if robots and all(map(np.all, chosen)):
        return "all joints"
    return "; ".join(
        f"all of {robot.name}" if np.all(of) else f"{robot.name}: {', '.join(np.array(robot.joints)[of])}"
        for robot, of in zip(robots, chosen, strict=True)
        if np.any(of)
    )
