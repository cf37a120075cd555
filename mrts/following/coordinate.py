# SPDX-License-Identifier: MIT
"""Motion of the whole cell from whatever is known of it: the object, a table of joints, or both.

Given joints miss their grasps by a planner's tolerance, by rounding, or by a spline: they are moved onto them.
"""

from dataclasses import dataclass
from types import NoneType
from typing import Annotated

import numpy as np

from mrts.base.arrays import Array, changed, cross, rotated
from mrts.base.errors import InputError, MotionError, Remark, check_type
from mrts.base.formats.record import Rule, check_attributes
from mrts.base.manifest import GEOMETRY
from mrts.base.rigid_transform import rotations_from_vectors, vectors_from_rotations
from mrts.base.words import first_names
from mrts.cell.cell import Cell
from mrts.cell.robot import PRINTED_TOLERANCE, Robot
from mrts.following.coordinated_motion import CoordinatedMotion, carried_by_each, carried_by_first, follow_object
from mrts.following.joint_columns import MOST_NAMED, required_columns
from mrts.following.tracking import check_joint_limits, check_regular, joints_on_grasps, solve_grasps
from mrts.kernel.tracking import closure_sizes
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion

WITHIN = Rule(gt=0, le=0.1)
"""[m, rad]; hands that far from their grasps hold another object."""

RAD_PER_M = 2.5
"""The bound on rotations where only that on positions is given: 5 mrad for 2 mm, as planners' tolerances come."""

GIVEN_CLOSURE = 1e-4
"""Gap between tip and grasp that changes nothing [m, rad]: given joints are taken as they are."""

GIVEN_SLIP = 1e-2
"""Slip of a tip on its grasp that changes nothing, relative to the largest velocity or acceleration."""

COARSE_SLIPS = (0.1, 0.5)
"""Slips in velocity and in acceleration that gaps or splines may explain; in proportion more for a wider bound."""

ROUGH = 1.0
"""Typical slip of accelerations from positions, relative to the typical acceleration: from here on they are noise."""

TIGHT = 1e-9, 1e-9, 1e-8
"""Gap [m, rad] and relative slip that are rounding: a slip of 1e-5 is felt in the jerk between close samples."""

SILENT_GAP = 1e-6
"""Gap that is closed without a word [m, rad]: any table has it."""

REST_SLIP = 1e-9
"""Slip of an object at rest that is rounding [m/s, rad/s and per s]."""

ROUNDED_SLIP = 1e-3
"""The same where rates carry few digits."""


@dataclass(frozen=True)
class ClosureBound:
    """How far hands may be off their grasps in joint motion that is given; they are then moved onto them.

    Attributes:
        position: Largest distance between a tip and its grasp [m].
        rotation: Largest angle between them [rad]; None is 2.5 rad per m of `position`.

    Raises:
        InputError: If one is no number above 0, or larger than any hand is off its grasp.
    """

    position: Annotated[float, WITHIN] = 2e-3
    rotation: Annotated[float, WITHIN] | None = None

    def __post_init__(self) -> None:
        check_attributes(self, ClosureBound, "closure")

    @property
    def angle(self) -> float:
        """Largest angle between tip and grasp [rad]."""
        return RAD_PER_M * self.position if self.rotation is None else self.rotation


def coordinate(
    cell: Cell, motion: ObjectMotion | JointTable | CoordinatedMotion, closure: ClosureBound | None = None
) -> CoordinatedMotion:
    """Motion of the whole cell from whatever is known of it.

    Args:
        motion: Of the object (the joints follow it), of the joints (they carry the object), or of both.
        closure: How far given joints may be off the grasps, onto which they are then moved; None allows 2 mm and
            5 mrad.

    Raises:
        InputError: If a joint table does not fit the cell, or `closure` is none.
        MotionError: If the arms cannot follow the object, or given joints do not close the chain.
    """
    check_type("cell", cell, Cell)
    check_type("motion", motion, ObjectMotion, JointTable, CoordinatedMotion)
    check_type("closure", closure, ClosureBound, NoneType)
    if isinstance(motion, ObjectMotion):
        return follow_object(cell, motion)
    bound = closure or ClosureBound()
    if isinstance(motion, JointTable):
        return _follow_joints(cell, motion, bound)
    joints = len(cell.joint_names)
    if motion.q.shape[1] != joints:
        raise InputError("motion.q", f"has {motion.q.shape[1]} columns, cell '{cell.name}' has {joints} joints.")
    check_joint_limits(cell, motion.object.time, motion.q)
    return close_chain(cell, motion, bound, "motion", carried=False)


def _follow_joints(cell: Cell, table: JointTable, bound: ClosureBound) -> CoordinatedMotion:
    names, extra = required_columns(cell, cell.robots, table.path, table.positions, table.unusable)
    told = f"joints that no arm of cell '{cell.name}' has were passed over: {first_names(sorted(extra), MOST_NAMED)}."
    remarks = (Remark("extra-joints", told),) if extra else ()
    time, joints, course, said = table.of(names)
    check_joint_limits(cell, time, joints[0], PRINTED_TOLERANCE)
    carried = carried_by_first(cell, time, *joints)
    given = changed(carried, remarks=(*said, *remarks), course=course)
    return close_chain(cell, given, bound, str(table.path), carried=True)


def grasp_gaps(cell: Cell, target: ObjectMotion, q: Array) -> Array:
    """Distances [m] and angles [rad] between the tips and their grasps on an object, Shape (2, n, N), at N joints q."""
    gaps: Array = np.swapaxes(solve_grasps(cell, target, slice(None), q, 1)[1:3], 1, 2)
    return gaps


def _worst(gaps: Array, bound: ClosureBound) -> tuple[int, int, float, str]:
    """Robot and sample of the largest gap in units of the bound, that gap, and the same as text."""
    share = np.max(gaps / np.reshape([bound.position, bound.angle], (2, 1, 1)), axis=0)
    robot, sample = (int(place) for place in np.unravel_index(int(np.argmax(share)), share.shape))
    text = "{:.3g} m and {:.3g} rad".format(*gaps[:, robot, sample])
    return robot, sample, float(share[robot, sample]), text


def tip_rates(cell: Cell, robot: Robot, motion: ObjectMotion) -> tuple[Array, Array]:
    """Velocity and acceleration of a grasp in the robot's base axes, cell components, each Shape (N, w)."""
    r = rotated(motion.rotation, robot.T_object_tip.p)
    v, w = motion.twist[:, :3], motion.twist[:, 3:]
    a, dw = motion.acceleration[:, :3], motion.acceleration[:, 3:]
    R = robot.T_world_base.R
    rows = cell.wrench_rows
    swing = cross(w, r)
    velocity = np.concatenate([(v + swing) @ R, w @ R], axis=1)
    linear = a + cross(dw, r) + cross(w, swing)
    acceleration = np.concatenate([linear @ R, dw @ R], axis=1)
    return velocity[:, rows], acceleration[:, rows]


def slip(
    cell: Cell,
    given: ObjectMotion,
    carried: list[ObjectMotion],
    shares: tuple[float, ...],
    rest: float,
    source: str | None = None,
) -> str | None:
    """Where the tips' velocities or accelerations do not fit the object's, as a sentence; None if they fit.

    Allowed are shares of the largest velocity and acceleration, which is left out if its share is, and what is rest.
    """
    for robot, own in zip(cell.robots, carried, strict=True):
        rates = zip(tip_rates(cell, robot, given), tip_rates(cell, robot, own), strict=True)
        for what, share, (expected, ours) in zip(("velocities", "accelerations"), shares, rates, strict=False):
            size = max(float(np.max(np.abs(expected))), float(np.max(np.abs(ours))))
            off = np.abs(ours - expected)
            if np.max(off) > max(share * size, rest):
                worst, _ = np.unravel_index(int(np.argmax(off)), off.shape)
                found, advice = "", f"Check the {what}."
                if source not in {None, what}:
                    found = f", which were found from the {source},"
                    advice = f"Give the {what} too, or {source} with more digits, less noise or at more times."
                return (
                    f"the joint {what}{found} do not fit the object's: at sample {worst} (t = {given.time[worst]:.6g} "
                    f"s) the tip of '{robot.name}' slips on its grasp by {np.max(off):.3g} (m, rad per s or s²); the "
                    f"largest is {size:.3g}. {advice}"
                )
    return None


def close_chain(
    cell: Cell, given: CoordinatedMotion, bound: ClosureBound, where: str, *, carried: bool
) -> CoordinatedMotion:
    """Given joints that hold every grasp: unchanged where they do already, else moved onto the grasps.

    The object then moves as the hands carry it on the mean. Every arm takes the positions on its grasp nearest to the
    given ones, and the velocities and accelerations nearest to the given ones that keep it there.

    Args:
        carried: Whether the object's motion is that of the first hand; else it is given and stays.

    Raises:
        MotionError: If a gap is larger than the bound, velocities or accelerations do not fit, or an arm is singular.
    """
    as_given = min(GIVEN_CLOSURE, bound.position), min(GIVEN_CLOSURE, bound.angle), GIVEN_SLIP
    held, closed = holds(cell, given, as_given, TIGHT)
    if held:
        return given if closed else changed(given, closed=False)
    source = None
    if carried and given.course is not None:
        source = "positions" if given.course.rate is None else "velocities"
    by_each = carried_by_each(cell, given.object.time, given.q, given.dq, given.ddq)
    gaps = grasp_gaps(cell, given.object, given.q)
    robot, sample, share, text = _worst(gaps, bound)
    if share > 1:
        raise MotionError(
            f"{where}: the joints do not close the chain. The tip of '{cell.robots[robot].name}' is off its grasp by "
            f"{text} at sample {sample} (t = {given.object.time[sample]:.6g} s), the worst; {bound.position:g} m and "
            f"{bound.angle:g} rad are allowed. Check the joint positions and how many digits they have, the bases and "
            "the grasps; if they are right, allow more with --closure (argument closure)."
        )
    exact, usual = bool(np.max(gaps) <= GIVEN_CLOSURE), ClosureBound()
    wider = max(1.0, bound.position / usual.position, bound.angle / usual.angle)
    shares = (GIVEN_SLIP, GIVEN_SLIP) if exact and source is None else tuple(wider * share for share in COARSE_SLIPS)
    if source == "positions":
        shares = shares[:1]
        _check_accelerations(cell, given.object, by_each, where)
    if misfit := slip(cell, given.object, by_each, shares, ROUNDED_SLIP, source):
        raise MotionError(f"{where}: {misfit}")
    if carried:
        target = mean_object(by_each)
        gaps = grasp_gaps(cell, target, given.q)
    else:
        target = given.object
    q, dq, ddq = joints_on_grasps(cell, target, given.q, given.dq, given.ddq)
    check_joint_limits(cell, target.time, q, PRINTED_TOLERANCE)
    check_regular(cell, target.time, q)
    remarks = given.remarks
    if np.max(gaps) > SILENT_GAP:
        robot, sample, _, text = _worst(gaps, bound)
        told = (
            f"the given joints were moved onto the grasps: the tip of '{cell.robots[robot].name}' by {text} at sample "
            f"{sample}, the worst; no joint by more than {np.max(np.abs(q - given.q)):.3g} rad or m."
        )
        remarks += (Remark("chain-closed", told, sample),)
    return CoordinatedMotion(target, q, dq, ddq, remarks, course=given.course, checked=False)


def holds(cell: Cell, given: CoordinatedMotion, *bounds: tuple[float, float, float]) -> list[bool]:
    """Whether joints hold every grasp along a motion, within each of some bounds.

    They are a distance [m], an angle [rad], and a share of the largest velocity, or acceleration, of a tip by which it
    slips on its grasp.
    """
    library, target = cell.generated.compiled, given.object
    if library is None:
        by_each = carried_by_each(cell, target.time, given.q, given.dq, given.ddq)
        most = np.max(grasp_gaps(cell, target, given.q), axis=(1, 2))
        return [
            bool((most <= gaps).all()) and slip(cell, target, by_each, (share, share), REST_SLIP) is None
            for *gaps, share in bounds
        ]
    inputs = given.inputs(cell.load) | {GEOMETRY: cell.geometry}
    distance, angle, *rates = closure_sizes(library, inputs, target.position, cell.geometry, cell.wrench_rows)
    sizes, slips = np.array(rates[::2]), np.array(rates[1::2])
    return [
        bool(max(distance) <= apart and max(angle) <= turned and (slips <= np.maximum(share * sizes, REST_SLIP)).all())
        for apart, turned, share in bounds
    ]


def _check_accelerations(cell: Cell, given: ObjectMotion, carried: list[ObjectMotion], where: str) -> None:
    """Refuse accelerations that are noise: root mean square of the worst tip's slip by that of accelerations."""
    rough = 0.0
    for robot, own in zip(cell.robots, carried, strict=True):
        expected, ours = (tip_rates(cell, robot, motion)[1] for motion in (given, own))
        size = max(float(np.mean(expected**2)), float(np.mean(ours**2)), ROUNDED_SLIP**2)
        rough = max(rough, float(np.sqrt(np.mean((ours - expected) ** 2) / size)))
    if rough > ROUGH:
        raise MotionError(
            f"{where}: the joint accelerations, which were found from the positions, are rough: the hands, which hold "
            f"one object, differ typically by {rough:.2g} times the acceleration, so most of it is noise. Smooth them "
            "(--smooth 1e-3; in Python load_motion(…, smooth=1e-3)), or give velocities and accelerations, more digits "
            "or fewer positions."
        )


def mean_object(carried: list[ObjectMotion]) -> ObjectMotion:
    """What the tips carry on the mean, its rates likewise: they differ from its derivatives by squares of the gaps."""
    first = carried[0].rotation
    off = [vectors_from_rotations(each.rotation @ first.transpose(0, 2, 1)) for each in carried]
    position, twist, acceleration = (
        np.mean([getattr(each, name) for each in carried], axis=0) for name in ("position", "twist", "acceleration")
    )
    rotation = rotations_from_vectors(np.mean(off, axis=0)) @ first
    return ObjectMotion(carried[0].time, position, rotation, twist, acceleration, checked=False)
