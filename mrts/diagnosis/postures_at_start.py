# SPDX-License-Identifier: MIT
"""Where the postures hold the object, against where the motion starts."""

from collections.abc import Iterator, Sequence

import numpy as np

from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform, angles_of_rotations
from mrts.cell.cell import Cell
from mrts.motion.object_motion import ObjectMotion

AGREE = (0.05, 0.2)
"""Distance [m] and angle [rad] within which the postures of all arms hold one object."""

ELSEWHERE = (0.1, 0.5)
"""Distance [m] and angle [rad] from which on that is not where the motion starts."""


def posture_hints(arms: Sequence[Cell], motion: ObjectMotion) -> Iterator[Remark]:
    """A hint where the postures of all arms hold the object together, but elsewhere than the motion starts."""
    held = [_held(arm) for arm in arms]
    if len(held) < 2 or any(_beyond(held[0], other, AGREE) for other in held[1:]):  # noqa: PLR2004 (one agrees always)
        return
    if _beyond(held[0], RigidTransform(motion.rotation[0], motion.position[0]), ELSEWHERE):
        ours, theirs = (", ".join(f"{value:.3g}" for value in p) for p in (held[0].p, motion.position[0]))
        yield Remark.hint(
            "other-start-pose",
            f"the postures hold the object at [{ours}] m, and the motion starts at [{theirs}] m or turned otherwise: "
            "were they made for another motion?",
        )


def posture_off(arm: Cell, motion: ObjectMotion) -> float:
    """How far from its start the posture of an arm holds the object [m]."""
    return float(np.linalg.norm(_held(arm).p - motion.position[0]))


def posture_turned(arm: Cell, motion: ObjectMotion) -> float:
    """How far the posture of an arm turns the object from how it starts [rad]; arguments as `posture_off`."""
    return float(angles_of_rotations((motion.rotation[0].T @ _held(arm).R)[None])[0])


def _held(arm: Cell) -> RigidTransform:
    """Where the posture of an arm holds the object."""
    (robot,) = arm.robots
    poses = arm.functions("kinematics", 1, {"q": robot.posture[None]})
    tip = RigidTransform(poses["rotation"][0], poses["position"][0].reshape(3))
    return tip @ robot.T_object_tip.inverse()


def _beyond(one: RigidTransform, other: RigidTransform, bound: tuple[float, float]) -> bool:
    turn = float(angles_of_rotations((one.R.T @ other.R)[None])[0])
    return bool(np.linalg.norm(one.p - other.p) > bound[0] or turn > bound[1])
