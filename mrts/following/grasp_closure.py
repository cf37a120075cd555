# SPDX-License-Identifier: MIT
"""How well given joints hold every grasp on the object: positions, velocities and accelerations."""

from dataclasses import dataclass

import numpy as np

from mrts.base.argument_types import is_number
from mrts.base.arrays import Array, rotated, row_products
from mrts.base.errors import InputError, MotionError
from mrts.base.rigid_transform import angles_of_rotations
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.following.grasp_tracking import tip_rates
from mrts.motion.joint_table import Source
from mrts.motion.object_motion import ObjectMotion

LARGEST_CLOSURE = 0.1
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

ROUGHENED = 0.1
"""The same from where on it should be known: the range may then depend on the noise."""

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

    position: float = 2e-3
    rotation: float | None = None

    def __post_init__(self) -> None:
        for name in ("position", "rotation"):
            value = getattr(self, name)
            if name == "rotation" and value is None:
                continue
            if not is_number(value, 0, LARGEST_CLOSURE) or value == 0:
                raise InputError("closure", f"must be > 0 and at most {LARGEST_CLOSURE:g}.", key=name, value=value)
            object.__setattr__(self, name, float(value))

    @property
    def angle(self) -> float:
        """Largest angle between tip and grasp [rad]."""
        return RAD_PER_M * self.position if self.rotation is None else self.rotation

    def __str__(self) -> str:
        return f"{self.position:g} m and {self.angle:g} rad"


@dataclass(frozen=True)
class TipMotion:
    """Pose of one tip in the world, and its velocity and acceleration in base axes and cell components."""

    position: Array
    rotation: Array
    velocity: Array
    acceleration: Array


def tip_motions(cell: Cell, q: Array, dq: Array, ddq: Array) -> list[TipMotion]:
    """Motion of every tip from the joints' motion, each Shape (N, m)."""
    samples, robots = len(q), len(cell.robots)
    poses = cell.functions("kinematics", samples, {"q": q})
    bias = cell.functions("bias_acceleration", samples, {"q": q, "dq": dq})["bias_acceleration"]
    bias = bias.reshape(samples, len(cell.wrench_components), robots)
    positions = poses["position"].reshape(samples, 3, robots)
    tips = []
    for index, joints in enumerate(cell.joint_slices.values()):
        J = poses["jacobian"][:, :, joints]
        rates = J @ np.stack([dq[:, joints], ddq[:, joints]], axis=2)
        tips.append(
            TipMotion(
                positions[:, :, index],
                poses["rotation"][:, :, 3 * index : 3 * index + 3],
                rates[:, :, 0],
                rates[:, :, 1] + bias[:, :, index],
            )
        )
    return tips


def in_world(cell: Cell, robot: Robot, rate: Array) -> tuple[Array, Array]:
    """Linear and angular part of a tip's rate, base axes and cell components, Shape (N, w), in the world."""
    full = np.zeros((len(rate), 6))
    full[:, cell.wrench_rows] = rate
    R = robot.T_world_base.R
    return full[:, :3] @ R.T, full[:, 3:] @ R.T


@dataclass(frozen=True)
class GraspGaps:
    """How far the tips are off their grasps.

    Attributes:
        distance: Shape (robots, N) [m].
        angle: Shape (robots, N) [rad].
    """

    distance: Array
    angle: Array

    @property
    def largest(self) -> float:
        """Of both [m, rad]."""
        return float(max(np.max(self.distance), np.max(self.angle)))

    def worst(self, bound: ClosureBound) -> tuple[int, int, float]:
        """Robot and sample of the largest gap in units of the bound, and that gap."""
        share = np.maximum(self.distance / bound.position, self.angle / bound.angle)
        robot, sample = np.unravel_index(int(np.argmax(share)), share.shape)
        return int(robot), int(sample), float(share[robot, sample])

    def at(self, robot: int, sample: int) -> str:
        """One gap as text."""
        return f"{self.distance[robot, sample]:.3g} m and {self.angle[robot, sample]:.3g} rad"


def grasp_gaps(cell: Cell, given: ObjectMotion, tips: list[TipMotion]) -> GraspGaps:
    """Gaps between the tips and their grasps on an object."""
    distances, angles = [], []
    for robot, tip in zip(cell.robots, tips, strict=True):
        gap = tip.position - given.position - rotated(given.rotation, robot.T_object_tip.p)
        distances.append(np.sqrt(row_products(gap, gap)))
        off = rotated(given.rotation, robot.T_object_tip.R) @ tip.rotation.transpose(0, 2, 1)
        angles.append(angles_of_rotations(off))
    return GraspGaps(np.array(distances), np.array(angles))


def check_gaps(cell: Cell, given: ObjectMotion, gaps: GraspGaps, bound: ClosureBound, where: str) -> None:
    """Check that no tip is further off its grasp than is allowed.

    Raises:
        MotionError: Names the worst robot, sample and gap.
    """
    robot, sample, share = gaps.worst(bound)
    if share > 1:
        raise MotionError(
            f"{where}: the joints do not close the chain. The tip of '{cell.robots[robot].name}' is off its grasp by "
            f"{gaps.at(robot, sample)} at sample {sample} (t = {given.time[sample]:.6g} s), the worst; {bound} are "
            "allowed. Check the joint positions and how many digits they have, the bases and the grasps; if they are "
            "right, allow more with --closure (argument closure)."
        )


def slip(
    cell: Cell,
    given: ObjectMotion,
    tips: list[TipMotion],
    shares: tuple[float, ...],
    rest: float,
    source: Source | None = None,
) -> str | None:
    """Where the tips' velocities or accelerations do not fit the object's, as a sentence; None if they fit.

    Args:
        cell: The cell.
        given: Motion of the object.
        tips: Motion of every tip.
        shares: Allowed of the largest velocity, and of the largest acceleration; accelerations are left out if it is.
        rest: Allowed besides [m, rad per s or s²].
        source: What those of them were found from that were not given.
    """
    for robot, tip in zip(cell.robots, tips, strict=True):
        rates = zip(tip_rates(cell, robot, given), (tip.velocity, tip.acceleration), strict=True)
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


def roughness(cell: Cell, given: ObjectMotion, tips: list[TipMotion]) -> float:
    """How much of the accelerations is noise: root mean square of the worst tip's slip by that of accelerations."""
    worst = 0.0
    for robot, tip in zip(cell.robots, tips, strict=True):
        expected = tip_rates(cell, robot, given)[1]
        size = max(float(np.mean(expected**2)), float(np.mean(tip.acceleration**2)), ROUNDED_SLIP**2)
        worst = max(worst, float(np.sqrt(np.mean((tip.acceleration - expected) ** 2) / size)))
    return worst
