# SPDX-License-Identifier: MIT
"""What a user should know of a cell: likely mistakes, numbers that look like placeholders, and what is assumed."""

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.formats.pose import WHOLE_TURN
from mrts.base.remark import EFFORT_PLACEHOLDERS, Remark
from mrts.base.rigid_transform import plane_normal
from mrts.base.words import first_names
from mrts.cell.robot import DEGREES_SUSPECTED

if TYPE_CHECKING:
    from mrts.cell.cell import Cell
    from mrts.cell.record import ShapeRecord
    from mrts.cell.robot import Robot

FAR = 10.0
"""Lengths of an arm from which on nobody puts the arm's object so far away."""

NEAR = 3.0
"""Lengths of an arm within which a thousandth of a number makes sense instead."""

LONGEST_ARM = 100.0
"""[m]; a longer one was drawn in millimetres."""

HEAVY = 30.0
"""Times the weight that the motors of all arms together hold at arm's length."""

WIDE = 10.0
"""Lengths of an arm that no object's radius of gyration has."""

STANDARD_GRAVITY = 9.81
"""[m/s²]."""

EARTHLY = (9.0, 10.5)
"""Sizes of a gravity that is meant to be the earth's [m/s²]."""

STRAIGHT = 0.9
"""Share of gravity along one axis from which on that is the vertical."""

MOST_INERTIA = 2.0
"""Times the moment of inertia of a body whose mass is all at the corners of the box around its shape, which no body
inside exceeds; a drawn shape may leave parts out."""

LEAST_INERTIA = 1 / 300
"""Of the same: a uniform box has 1/3, so this one has its mass within a tenth of its size."""

FEWEST_JOINTS = 3
"""Turning joints of an arm from which on equal efforts are no accident: of two, motors often are alike."""

ANY_JOINT = 1000.0
"""Effort that no arm has in each of its joints, the last included [N m]: only hips and first axes of heavy arms do."""

LARGE = 50.0
"""Effort that no small arm has any more [N m]: those of hobby servos and direct drives, whose motors may all be alike,
stay below."""

UNLIKE = 50.0
"""Times by which what the first joint holds at full stretch exceeds what the last does, from which on nobody puts the
same motor into both. Legs of walking robots, with one motor for all joints, have up to 25."""

WEIGHTLESS = "no mass in the URDF, so its links weigh nothing: torques come out too small, and speeds too high"

POINT_MASSES = "a mass but no inertia in the URDF, so it counts as a point: turning it costs too little torque"

NO_COLLISIONS = "collisions are not looked at: not of arms and hands with each other, the object or the room"
"""Said wherever somebody could think they were: of cells that are begun, checked, or laid out."""


COLLISIONS_UNKNOWN = "no-collisions"
"""Code of the remark that says so."""


JOINT_ASSUMPTIONS: tuple[tuple[str, str, Callable[["Robot"], NDArray[np.bool_]]], ...] = (
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


def cell_remarks(cell: "Cell") -> Iterator[Remark]:
    """All that is to know of a cell: what its files and its numbers as they are now lead to."""
    units = [*_unit_remarks(cell)]
    codes = {remark.code for remark in units}
    yield from cell.remarks
    yield from units
    if cell.object_shape is not None and not codes & {"mass-grams", "inertia-unit"}:  # which make it fit
        yield from _inertia_remarks(cell, cell.object_shape)
    if placeholders := _placeholder_efforts(cell):
        said = "; ".join(f"{value:g} N m on every joint of {name}" for name, value in placeholders.items())
        yield Remark(
            EFFORT_PLACEHOLDERS,
            f"the effort limits of the URDF look like placeholders: {said}. c² is as good as they are: give "
            "the data sheet's as 'torque' in the cell file.",
        )
    yield from missing_masses(cell.robots)
    of_urdf = [robot.name for robot in cell.robots if robot.source.effort is not None]
    if of_urdf:
        text = f"torque limits: the effort limits of the URDF ({', '.join(of_urdf)}); 'torque' gives others"
        yield Remark.assumed("torque-of-urdf", text)
    yield from joint_assumptions(cell.robots)
    yield from _assumptions(cell)


def torque_source(robot: "Robot") -> str:
    """Where its torque limits are from: "URDF" or "cell file"."""
    return "URDF" if robot.source.effort is not None else "cell file"


def friction_sources(robot: "Robot") -> list[str]:
    """Where the friction of each joint is from: "cell file", "URDF", or "none given", which counts as 0."""
    if robot.source.friction is None:
        return ["cell file"] * len(robot.joints)
    return ["URDF" if some else "none given" for some in robot.motors.coulomb + robot.motors.viscous]


def _unit_remarks(cell: "Cell") -> Iterator[Remark]:
    yield from _gravity(cell.gravity)
    for robot in cell.robots:
        yield from _angles(robot)
        yield from urdf_remarks(robot)
    if any(arm_length(robot) > LONGEST_ARM for robot in cell.robots):
        return  # the rest compares with that length
    yield from _lengths(cell)
    yield from _load(cell)


def urdf_remarks(robot: "Robot") -> Iterator[Remark]:
    """Remarks on the numbers of a robot's URDF."""
    length = arm_length(robot)
    if length > LONGEST_ARM:
        yield Remark.hint(
            "urdf-millimetres",
            f"robot '{robot.name}' is {length:.4g} m long: the lengths of its URDF seem to be in mm, and must be in m.",
        )
    lower, upper = robot.position_lower, robot.position_upper
    stuck = [name for name, least, most in zip(robot.joints, lower, upper, strict=True) if least == most]
    if stuck:
        yield Remark.hint(
            "limits-equal",
            f"robot '{robot.name}' cannot move {', '.join(stuck)}: the upper position limit is the lower one, as "
            "exporters write it that were told none. Give the joint's own limits, or the type 'continuous'; the cell "
            "file's 'fixed' holds a joint on purpose.",
        )
    turning = robot.turns
    far = turning & np.isfinite(lower) & np.isfinite(upper) & (np.maximum(-lower, upper) > DEGREES_SUSPECTED)
    if np.any(far):
        worst = int(np.argmax(far))
        yield Remark.hint(
            "limits-degrees",
            f"robot '{robot.name}' may turn {robot.joints[worst]} from {lower[worst]:g} to {upper[worst]:g} rad: the "
            "position limits of its URDF seem to be in degrees.",
        )


def arm_length(robot: "Robot") -> float:
    """From the first joint to the tip along the links, and what prismatic joints add where they have limits [m]."""
    length = float(np.sum(link_lengths(robot)))
    stroke = (robot.position_upper - robot.position_lower)[~robot.turns]
    return length + float(np.sum(stroke[np.isfinite(stroke)]))


def link_lengths(robot: "Robot") -> Array:
    """From joint to joint and to the tip, Shape (n,) [m]."""
    corners = np.concatenate([robot.points, robot.T_base_tip.p[None]])
    return np.asarray(np.linalg.norm(np.diff(corners, axis=0), axis=1))


def _gravity(gravity: Array) -> Iterator[Remark]:
    size = float(np.linalg.norm(gravity))
    if not EARTHLY[0] <= size <= EARTHLY[1]:
        return
    axis = int(np.argmax(np.abs(gravity)))
    if gravity[axis] > STRAIGHT * size:
        down = [0.0, 0.0, 0.0]
        down[axis] = -STANDARD_GRAVITY
        yield Remark.hint(
            "gravity-upward",
            f"gravity points along +{'xyz'[axis]}, so things fall that way. If {'xyz'[axis]} points upward, it must "
            f"be gravity: [{', '.join(f'{value:g}' for value in down)}].",
        )


def _angles(robot: "Robot") -> Iterator[Remark]:
    turning = robot.turns
    far = turning & (np.abs(robot.posture) > WHOLE_TURN)
    if np.any(far):
        radians = np.where(turning, np.radians(robot.posture), robot.posture)
        shown = ", ".join(f"{value:.4g}" for value in radians)
        worst = float(robot.posture[int(np.argmax(np.abs(robot.posture) * far))])
        yield Remark.hint(
            "posture-degrees",
            f"the posture of robot '{robot.name}' has a joint at {worst:g} rad: if degrees are meant, it is "
            f"posture: [{shown}].",
        )


def _lengths(cell: "Cell") -> Iterator[Remark]:
    lengths = [arm_length(robot) for robot in cell.robots]
    longest = max(lengths)
    if not 0 < longest <= LONGEST_ARM:
        return
    for robot in cell.robots:
        grasp = float(np.linalg.norm(robot.T_object_tip.p))
        if grasp > FAR * longest and grasp / 1000 < NEAR * longest:
            yield Remark.hint(
                "grasp-millimetres",
                f"robot '{robot.name}' holds the object {grasp:.4g} m from its centre of mass, and the arm is "
                f"{longest:.3g} m long: the lengths of its grasp seem to be in mm.",
            )
    bases = [robot.T_world_base.p for robot in cell.robots]
    middle = np.mean(bases, axis=0)
    for robot, base in zip(cell.robots, bases, strict=True):
        if float(np.linalg.norm(base)) > FAR * longest:  # the farther one of two bases is the wrong one
            yield from base_remarks(robot, middle, middle / 1000, longest)


def base_remarks(robot: "Robot", middle: Array, meant: Array, longest: float) -> Iterator[Remark]:
    """That the base of an arm is a thousand times too far from where the arms work."""
    away = float(np.linalg.norm(robot.T_world_base.p - middle))
    thousandth = float(np.linalg.norm(robot.T_world_base.p / 1000 - meant))
    if away > FAR * longest + np.linalg.norm(robot.T_object_tip.p) and thousandth < NEAR * longest:
        yield Remark.hint(
            "base-millimetres",
            f"the base of robot '{robot.name}' is {away:.4g} m from the object, and the arm is {longest:.3g} m "
            "long: its position seems to be in mm.",
        )


def _load(cell: "Cell") -> Iterator[Remark]:
    lengths = [max(arm_length(robot), 1e-3) for robot in cell.robots]
    forces = [float(np.max(robot.torque_upper)) / length for robot, length in zip(cell.robots, lengths, strict=True)]
    weight = STANDARD_GRAVITY * cell.mass
    if weight > HEAVY * sum(forces) > weight / 1000:
        yield Remark.hint(
            "mass-grams",
            f"the object weighs {weight:.4g} N, and the motors hold about {sum(forces):.3g} N at arm's length: its "
            f"mass, {cell.mass:g} kg, seems to be in g.",
        )
    radius = float(np.sqrt(np.max(np.linalg.eigvalsh(cell.inertia)) / cell.mass))
    if radius > WIDE * max(lengths):
        yield Remark.hint(
            "inertia-unit",
            f"the object's inertia is that of a body {radius:.3g} m wide on each side of its axis (the radius of "
            "gyration): it must be in kg m², with a mass in kg. 1 kg mm² is 1e-6 kg m², 1 g mm² is 1e-9 kg m².",
        )


def _inertia_remarks(cell: "Cell", shape: "ShapeRecord") -> Iterator[Remark]:
    ratio = _ratio_to_shape(cell, shape)
    if not LEAST_INERTIA <= ratio <= MOST_INERTIA:
        moments = ", ".join(f"{moment:.4g}" for moment in np.linalg.eigvalsh(cell.inertia))
        yield Remark.hint(
            "inertia-unlike-shape",
            f"the object's inertia, principal moments {moments} kg m², does not fit its mass of {cell.mass:g} kg: it "
            f"is {ratio:.3g} times what a body of this shape has at most. Without 'inertia', a 'shape' gives that of a "
            "uniform body; 1 kg mm² is 1e-6 kg m².",
        )


def _ratio_to_shape(cell: "Cell", shape: "ShapeRecord") -> float:
    """Of the inertia to that of the mass at the corners of a box around the shape.

    It is the largest about any axis of the shape, or that of the largest moments if that is not too large; of a planar
    cell that about the plane's normal.
    """
    R, p = shape.pose.R, shape.pose.p
    squares = (np.abs(R.T @ p) + _half_sides(shape)) ** 2
    corners = cell.mass * (np.sum(squares) - squares)
    if cell.plane is not None:
        normal = plane_normal(cell.plane)
        return float((normal @ cell.inertia @ normal) / (normal @ (R * corners) @ R.T @ normal))
    moments = np.diag(R.T @ cell.inertia @ R)
    most = float(np.max(moments / corners))
    return most if most > MOST_INERTIA else float(np.max(moments) / np.max(corners))


def _half_sides(shape: "ShapeRecord") -> Array:
    """Of a box around the shape, in its axes, about its frame's origin, Shape (3,) [m]."""
    if shape.box is not None:
        return np.array(shape.box) / 2
    if shape.cylinder is not None:
        radius = shape.cylinder.radius
        return np.array([radius, radius, shape.cylinder.length / 2])
    from mrts.base.formats.surface_text import unpacked_surface  # noqa: PLC0415 (for meshes alone)

    assert shape.mesh is not None  # noqa: S101 (one kind is given)
    return np.asarray(np.max(np.abs(unpacked_surface(shape.mesh.vertices, shape.mesh.triangles)[0]), axis=0))


def _placeholder_efforts(cell: "Cell") -> dict[str, float]:
    found = {}
    for robot in cell.robots:
        efforts = robot.torque_upper[robot.turns].tolist()
        if robot.source.effort is None or len(efforts) < FEWEST_JOINTS or len({*efforts}) > 1:
            continue
        if efforts[0] >= ANY_JOINT or (efforts[0] >= LARGE and _share_of_load(robot) > UNLIKE):
            found[robot.name] = efforts[0]
    return found


def _share_of_load(robot: "Robot") -> float:
    """What the first joint of an arm holds at full stretch, as a multiple of what the last one does."""
    lengths = link_lengths(robot)
    masses = robot.source.carried_mass
    first, least = sum(masses) * float(np.sum(lengths)), masses[-1] * float(lengths[-1])
    return first / least if least > 0 else np.inf if first > 0 else 0.0


def missing_masses(robots: Sequence["Robot"]) -> Iterator[Remark]:
    """Warnings on links without a mass or an inertia."""
    if weightless := _named(robots, lambda robot: np.array(robot.source.carried_mass) == 0):
        yield Remark("links-without-mass", f"{WEIGHTLESS} ({weightless})")
    points = {robot.name: [link for links in robot.source.point_links for link in links] for robot in robots}
    if any(points.values()):
        named = (f"{robot}: {first_names(links, NAMES_SHOWN)}" for robot, links in points.items() if links)
        yield Remark("links-without-inertia", f"{POINT_MASSES} ({'; '.join(named)})")


def joint_assumptions(robots: Sequence["Robot"]) -> Iterator[Remark]:
    """What is taken for granted of joints of which neither URDF nor cell file says it."""
    for code, text, applies in JOINT_ASSUMPTIONS:
        if named := _named(robots, applies):
            yield Remark.assumed(code, f"{text} ({named})")


def _assumptions(cell: "Cell") -> Iterator[Remark]:
    text = "the object's centre of mass is the origin of its frame, and its inertia is about that"
    yield Remark.assumed("com-at-origin", text)
    if not np.any(np.isfinite(cell.object_velocity_limit)):
        yield Remark.assumed("no-object-velocity", "the object may move at any speed: no 'object: {velocity: …}'")
    cubes = [str(thing.name) for thing in cell.carried if thing.half_width is not None and thing.height is None]
    if cubes:
        text = f"the centre of mass of {', '.join(cubes)} is as high as the larger half width: 'height' gives another"
        yield Remark.assumed("carried-height", text)
    yield Remark.assumed(COLLISIONS_UNKNOWN, NO_COLLISIONS)
    free = [
        robot.name
        for robot in cell.robots
        if not robot.contacts and not np.any(np.isfinite([robot.wrench_lower, robot.wrench_upper]))
    ]
    if free:
        text = f"hands hold whatever comes: no 'wrench' and no 'contact' ({', '.join(free)})"
        yield Remark.assumed("no-wrench-limit", text)


def _named(robots: Sequence["Robot"], applies: Callable[["Robot"], NDArray[np.bool_]]) -> str:
    """The joints to which something applies, in words; empty if to none."""
    chosen = [applies(robot) for robot in robots]
    if robots and all(map(np.all, chosen)):
        return "all joints"
    return "; ".join(
        f"all of {robot.name}" if np.all(of) else f"{robot.name}: {', '.join(np.array(robot.joints)[of])}"
        for robot, of in zip(robots, chosen, strict=True)
        if np.any(of)
    )
