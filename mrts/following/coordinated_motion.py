# SPDX-License-Identifier: MIT
"""The whole cell along the object's motion: joint positions, velocities and accelerations of every arm."""

from collections.abc import Sequence
from dataclasses import InitVar, dataclass, field, replace
from operator import attrgetter
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply, changed, cross, freeze
from mrts.base.errors import InputError, MotionError, Remark, check_type
from mrts.base.formats.record import Shape, check_attributes
from mrts.base.rigid_transform import plane_normal
from mrts.cell.cell import Cell
from mrts.following.tracking import FURTHER_STARTS, is_redundant, random_starts, track_variants
from mrts.kernel.tracking import PATH
from mrts.motion.joint_table import UNTIMED, JointCourse
from mrts.motion.object_motion import ObjectMotion

OUT_OF_PLANE = 1e-9
"""Largest velocity and turning rate out of the plane of a planar cell [m/s, rad/s]: rounding of the input."""

SAME_JOINTS = 1e-6
"""Largest difference of joints that are followed again, as a share of the largest of them: what Newton steps leave."""

SAME_CHOICE = 1e-4
"""The same of a redundant arm's positions: at samples that were added it is near its choice (3e-7 off of 12)."""

SAME_CHOICE_RATES = 1e-2
"""The same of its velocities and accelerations (7e-4 off)."""

DEPENDENT = 1e-9
"""Singular value beside the largest below which a direction is lost: rounding leaves 1e-15, a bad posture far more."""

NAMED = 0.05
"""Part of a direction from which on it is named."""

POSTURES = 3
"""Of which the best counts: the first is the arm's own, and may be singular; the others are anywhere."""

TWIST = tuple(f"{move} {axis}" for move in ("along", "about") for axis in "xyz")
"""Components of a twist in words."""


@dataclass(frozen=True, repr=False, eq=False)
class CoordinatedMotion:
    """N samples of a given motion of the object and the m joints that carry it; nobody can write to its arrays.

    Attributes:
        object: Motion of the object.
        q: Joint positions of all arms in order, Shape (N, m) [rad or m].
        dq: q', Shape (N, m) [rad/s or m/s].
        ddq: q'', Shape (N, m) [rad/s² or m/s²].
        remarks: What to know of how it was read or found.
        travel: Signs of the joints' velocities just before and just after every sample, where `dq` and `ddq` do not
            show them: a motion at a stop of a retimed path has none of its own. Shape (2, N, m); None where they do.
        course: What a table makes of the joints between its rows; None where only samples of them are known.
        closed: Whether they hold the grasps to rounding; small gaps of given joints stay, between the samples too.

    Args:
        checked: As in `ObjectMotion`.
    """

    object: ObjectMotion
    q: Annotated[Array, Shape("N", "m", finite=True)]
    dq: Annotated[Array, Shape("N", "m", finite=True)]
    ddq: Annotated[Array, Shape("N", "m", finite=True)]
    remarks: tuple[Remark, ...] = ()
    travel: Array | None = None
    course: JointCourse | None = field(default=None, kw_only=True)
    closed: bool = field(default=True, kw_only=True)
    checked: InitVar[bool] = field(default=True, kw_only=True)

    def __post_init__(self, checked: bool) -> None:
        if checked:
            check_type("object", self.object, ObjectMotion)
            check_attributes(self, CoordinatedMotion, "motion", N=len(self.object.time))
            if self.travel is not None and (self.travel.shape != (2, *self.q.shape) or np.any(np.abs(self.travel) > 1)):
                raise InputError("travel", f"must have Shape {(2, *self.q.shape)} and lie between -1 and 1.")
        freeze(self)

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        freeze(self)

    def __repr__(self) -> str:
        return f"<CoordinatedMotion: {self.samples} samples in {self.object.time[-1]:.4g} s, {self.q.shape[1]} joints>"

    @property
    def samples(self) -> int:
        """Number of samples N."""
        return len(self.object.time)

    @property
    def untimed(self) -> bool:
        """Whether it is a path through waypoints, whose time is its length."""
        return UNTIMED in map(attrgetter("code"), self.remarks)

    def at(self, samples: NDArray[np.int_] | slice) -> "CoordinatedMotion":
        """Some samples, at least two, in their order, by themselves."""
        parts: dict[str, Any] = {name: getattr(self.object, name)[samples] for name in PATH}
        joints = {name: getattr(self, name)[samples] for name in ("q", "dq", "ddq")}
        carried = replace(self.object, **parts, remarks=(), checked=False)
        travel = None if self.travel is None else self.travel[:, samples]
        return changed(self, object=carried, **joints, remarks=(), travel=travel)

    def played(
        self, time: Array, rate: Array | float, change: Array | float = 0.0, travel: Array | None = None
    ) -> "CoordinatedMotion":
        """The same poses at another time r⁻¹, Shape (N,), by its ṙ and r̈, Shape (N, 1): eq. (10) and its derivative.

        q̇ = q' ṙ and q̈ = q'' ṙ² + q' r̈, and so for the object; `travel` is that of the motion unless it is given.
        """
        of, square = self.object, rate**2
        twist, acceleration = of.twist * rate, of.acceleration * square + of.twist * change
        carried = changed(of, time=time, twist=twist, acceleration=acceleration, remarks=(), course=None)
        dq, ddq = self.dq * rate, self.ddq * square + self.dq * change
        travel = self.travel if travel is None else travel
        return changed(self, object=carried, dq=dq, ddq=ddq, remarks=(), travel=travel, course=None)

    def inputs(self, load: Array) -> dict[str, Array]:
        """Inputs of the generated functions of a moving sample.

        Args:
            load: Load vector, Shape (10,), or one a sample, Shape (N, 10).
        """
        return {
            "q": self.q,
            "dq": self.dq,
            "ddq": self.ddq,
            "object_rotation": self.object.rotation,
            "object_twist": self.object.twist,
            "object_acceleration": self.object.acceleration,
            "load": load,
        }


def follow_object(cell: Cell, motion: ObjectMotion) -> CoordinatedMotion:
    """Joint motion of every arm that keeps its grasp along the object's motion.

    At t = 0 the joints are solved near each robot's posture, which so selects the branch; a redundant arm takes the
    positions nearest to it. From there the branch is kept by continuity; a redundant arm stays as near to its start as
    the grasp lets it, and away from its limits (`mrts.following.tracking`). Velocities and accelerations
    come from derivatives of the generated functions, never from differences.

    Args:
        cell: The cell.
        motion: Motion of the object.

    Raises:
        InputError: If an arm has too few joints to follow.
        MotionError: If the object leaves the plane of a planar cell, or an arm cannot reach, is singular, loses its
            branch or passes a joint limit; names robot, joint and sample.
    """
    check_type("cell", cell, Cell)
    check_type("motion", motion, ObjectMotion)
    check_dimensions(cell, motion)
    path = {name: getattr(motion, name)[None] for name in PATH}
    posture = cell.posture
    tracked = track_variants(cell, path, cell.geometry[None], posture[None], np.zeros(1, dtype=bool))
    failure = tracked.failure(0)
    if failure is not None:
        check_motion(cell, motion)  # an arm that could follow none is told of as such
        raise MotionError(failure.message)
    remarks = motion.remarks
    for place in tracked.outcome[0]["start"].nonzero()[0].tolist():
        told = (
            f"robot '{cell.robots[place].name}' does not reach its grasp at t = 0 from its posture inside its joint "
            f"limits: it starts at the nearest positions that {FURTHER_STARTS} further starts led to."
        )
        remarks += (Remark("other-start", told, 0),)
    return CoordinatedMotion(motion, tracked.q[0], tracked.dq[0], tracked.ddq[0], remarks, checked=False)


def carried_by_first(cell: Cell, time: Array, q: Array, dq: Array, ddq: Array) -> CoordinatedMotion:
    """The motion of the object that the first robot's tip carries, with the joints', each Shape (N, m)."""
    return CoordinatedMotion(carried_by_each(cell, time, q, dq, ddq)[0], q, dq, ddq, checked=False)


def carried_by_each(cell: Cell, time: Array, q: Array, dq: Array, ddq: Array) -> list[ObjectMotion]:
    """The motions of the object that the tips carry, each by itself; their rates are not compared with their poses."""
    samples, robots = len(q), len(cell.robots)
    poses = cell.functions("kinematics", samples, {"q": q})
    bias = cell.functions("bias_acceleration", samples, {"q": q, "dq": dq})["bias_acceleration"]
    bias = bias.reshape(samples, len(cell.wrench_components), robots)
    tips = poses["position"].reshape(samples, 3, robots)
    carried = []
    for index, (robot, joints) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
        rotation = poses["rotation"][:, :, 3 * index : 3 * index + 3] @ robot.T_object_tip.R.T
        r = rotation @ robot.T_object_tip.p
        J, rates = poses["jacobian"][:, :, joints], np.zeros((2, samples, 6))
        rates[..., cell.wrench_rows] = apply(J, dq[:, joints]), apply(J, ddq[:, joints]) + bias[:, :, index]
        v, w, a, dw = (rate[:, part] @ robot.T_world_base.R.T for rate in rates for part in (slice(3), slice(3, 6)))
        twist = np.concatenate([v - cross(w, r), w], axis=1)
        acceleration = np.concatenate([a - cross(dw, r) - cross(w, cross(w, r)), dw], axis=1)
        carried.append(ObjectMotion(time, tips[:, :, index] - r, rotation, twist, acceleration, checked=False))
    return carried


def check_motion(cell: Cell, motion: ObjectMotion) -> None:
    """Check what does not depend on the joints' positions: `check_dimensions`, and that joints are independent.

    Raises:
        InputError: If an arm's joints do not move its hand in as many directions as there are wrench components.
        MotionError: If the object leaves the plane.
    """
    check_dimensions(cell, motion)
    q = np.hstack([random_starts(robot, POSTURES) for robot in cell.robots])
    jacobians = cell.functions("kinematics", len(q), {"q": q})["jacobian"]
    for robot, joints in zip(cell.robots, cell.joint_slices.values(), strict=True):
        if lacking := lacking_freedom(robot.joints, jacobians[:, :, joints], cell.wrench_rows):
            rule = f"{lacking} It could not follow any motion: take another arm or tip."
            raise InputError(cell.name, rule, key=f"robot '{robot.name}'")


def lacking_freedom(joints: Sequence[str], jacobians: Array, rows: Sequence[int]) -> str:
    """Why an arm does not move its hand in all directions in any posture, as a sentence; empty if it does in some.

    Jacobians of the tip in base axes are those at `POSTURES` random positions, Shape (POSTURES, w, n).
    """
    values, right = np.linalg.svd(jacobians)[1:]
    ranks = np.sum(values > DEPENDENT * values[:, :1], axis=1)
    best = int(np.argmax(ranks))
    rank, needed = int(ranks[best]), len(rows)
    if rank == needed:
        return ""
    directions, sizes, _ = np.linalg.svd(np.concatenate([*jacobians], axis=1))
    never = directions[:, int(np.sum(sizes > DEPENDENT * sizes[0])) :]
    named = [TWIST[row] for row, size in zip(rows, np.linalg.norm(never, axis=1), strict=True) if size > NAMED]
    always = len(named) == needed - rank
    lost = f"In no posture does it move {', '.join(named)}" if always else "Which are lost depends on the posture"
    dependent = np.linalg.norm(right[best, rank:], axis=0) > DEPENDENT
    together = np.linalg.matrix_rank(jacobians[best][:, dependent], DEPENDENT * values[best, 0])
    some = ", ".join(name for name, is_one in zip(joints, dependent, strict=True) if is_one)
    part = f"{some} together give only {together}. " if some else ""
    return (
        f"its {len(joints)} joints move its hand in {rank} independent directions, but holding the object takes "
        f"{needed}. {part}{lost} (base axes)."
    )


def check_dimensions(cell: Cell, motion: ObjectMotion) -> None:
    """Check that arms have enough joints, and that the object keeps to the plane of a planar cell.

    Raises:
        InputError: If an arm has too few joints.
        MotionError: If the object leaves the plane.
    """
    for robot in cell.robots:
        if len(robot.joints) < len(cell.wrench_components):
            raise InputError(
                cell.name,
                f"it has {len(robot.joints)} moving joints, but holding the object takes "
                f"{len(cell.wrench_components)}: it could not follow any motion.",
                key=f"robot '{robot.name}'",
            )
    if cell.plane is not None and leaves_plane(cell, motion.twist):
        normal = "".join(sorted({*"xyz"} - {*cell.plane}))
        raise MotionError(
            f"the object leaves the plane {cell.plane} of cell '{cell.name}': its path may move in {cell.plane} and "
            f"turn about {normal} only."
        )


def leaves_plane(cell: Cell, twist: Array) -> NDArray[np.bool_]:
    """Whether the object leaves the plane of a planar cell along motions, Shape (…), by its twist, Shape (…, N, 6)."""
    normal = np.abs(plane_normal(cell.plane or "xy"))
    out = np.concatenate([normal, 1 - normal]) > 0
    return np.asarray(np.max(np.abs(twist[..., out]), axis=(-2, -1)) > OUT_OF_PLANE)


def following_again(cell: Cell, motion: CoordinatedMotion) -> tuple[Cell | None, CoordinatedMotion]:
    """The cell with postures from which its arms follow the object as in a motion: its own, or where that starts.

    Where the motion starts is found again sooner, but a redundant arm stays near its posture, whatever has moved.

    Returns:
        The cell, None if its arms take other joints, as where redundant ones were given; and what they take: the motion
        as it was given where that is the same, or no cell takes it.
    """
    parts = cell.joint_slices.items()
    starts = (cell.with_postures({name: motion.q[0, part].tolist() for name, part in parts}), cell)
    redundant = any(is_redundant(cell, robot) for robot in cell.robots)
    if redundant:
        starts = starts[::-1]
    for start in starts:
        try:
            again = follow_object(start, motion.object)
        except MotionError:
            continue
        if _same(again, motion, (SAME_JOINTS,) * 3):
            return start, motion
        if redundant and _same(again, motion, (SAME_CHOICE, SAME_CHOICE_RATES, SAME_CHOICE_RATES)):
            return start, again
    return None, motion


def _same(ours: CoordinatedMotion, given: CoordinatedMotion, shares: tuple[float, float, float]) -> bool:
    pairs = ((ours.q, given.q), (ours.dq, given.dq), (ours.ddq, given.ddq))
    return all(
        np.max(np.abs(one - other)) <= share * max(1.0, np.max(np.abs(other)))
        for (one, other), share in zip(pairs, shares, strict=True)
    )
