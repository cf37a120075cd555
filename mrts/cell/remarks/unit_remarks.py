# SPDX-License-Identifier: MIT
"""Numbers that make sense in another unit: millimetres, degrees, N mm, grams, and gravity that points upward."""

from collections.abc import Container, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mrts.base.arrays import Array, median
from mrts.base.formats.pose import WHOLE_TURN
from mrts.base.remark import Remark
from mrts.cell.motors.joint_source import JointSource
from mrts.cell.robot import DEGREES_SUSPECTED

if TYPE_CHECKING:
    from mrts.cell.cell import Cell
    from mrts.cell.robot import Robot


FAR = 10.0
"""Lengths of an arm from which on nobody puts the arm's object so far away."""

NEAR = 3.0
"""Lengths of an arm within which a thousandth of a number makes sense instead."""

LONGEST_ARM = 100.0
"""[m]; a longer one was drawn in millimetres."""

STRONG = 100.0
"""Times the torque that holds the whole arm stretched out: no motor gives so much."""

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

TORQUE_UNIT = "torque-millimetres"
"""Code of the hint on torques in N mm."""


def unit_remarks(cell: "Cell", joints: Sequence[JointSource], without_efforts: Container[str]) -> Iterator[Remark]:
    """Remarks on the numbers of a cell that are likely in another unit."""
    yield from _gravity(cell.gravity)
    for robot in cell.robots:
        yield from _angles(robot)
        yield from urdf_remarks(robot)
    if any(arm_length(robot) > LONGEST_ARM for robot in cell.robots):
        return  # the rest compares with that length
    yield from _lengths(cell)
    yield from _torques(cell, joints, without_efforts)
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
    turning = np.array([kind == "revolute" for kind in robot.joint_types])
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
    corners = np.concatenate([robot.points, robot.T_base_tip.p[None]])
    length = float(np.sum(np.linalg.norm(np.diff(corners, axis=0), axis=1)))
    slides = np.array([kind == "prismatic" for kind in robot.joint_types])
    stroke = (robot.position_upper - robot.position_lower)[slides]
    return length + float(np.sum(stroke[np.isfinite(stroke)]))


def _gravity(gravity: Array) -> Iterator[Remark]:
    size = float(np.linalg.norm(gravity))
    if EARTHLY[0] <= size / 1000 <= EARTHLY[1]:
        yield Remark.hint("gravity-millimetres", f"gravity is {size:.4g} m/s²: it seems to be in mm/s².")
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
    turning = np.array([kind == "revolute" for kind in robot.joint_types])
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
    """That the base of an arm is a thousand times too far from where the arms work.

    Args:
        robot: The arm.
        middle: Where that is, Shape (3,) [m].
        meant: Where it would be, were the base in metres, Shape (3,) [m].
        longest: Length of the longest arm [m].
    """
    away = float(np.linalg.norm(robot.T_world_base.p - middle))
    thousandth = float(np.linalg.norm(robot.T_world_base.p / 1000 - meant))
    if away > FAR * longest + np.linalg.norm(robot.T_object_tip.p) and thousandth < NEAR * longest:
        yield Remark.hint(
            "base-millimetres",
            f"the base of robot '{robot.name}' is {away:.4g} m from the object, and the arm is {longest:.3g} m "
            "long: its position seems to be in mm.",
        )


def _torques(cell: "Cell", joints: Sequence[JointSource], without_efforts: Container[str]) -> Iterator[Remark]:
    for robot in cell.robots:
        if robot.name in without_efforts:
            continue
        own = [joint for joint in joints if joint.robot == robot.name]
        weight = STANDARD_GRAVITY * sum(joint.carried_mass for joint in own) * arm_length(robot)
        turning = [joint.torque[1] for joint in own if joint.unit == "rad"]
        if turning and weight > 0 and median(np.array(turning)) > STRONG * weight:
            source = own[0].torque_from
            yield Remark.hint(
                TORQUE_UNIT,
                f"the torque limits of robot '{robot.name}' ({source}) are around {median(np.array(turning)):.4g} N m, "
                f"and {weight:.3g} N m hold the whole arm stretched out: they seem to be in N mm, and must be in N m, "
                "or the links weigh more than their URDF says.",
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
