# SPDX-License-Identifier: MIT
"""What is said of an arm that cannot follow."""

from mrts.base.arrays import Array
from mrts.cell.robot import Robot


def unreachable(robot: Robot, time: Array, sample: int, gap: float, turn: float) -> str:
    """The message for a grasp out of reach: the smallest position and rotation errors met [m, rad].

    Args:
        robot: The arm.
        time: Shape (N,) [s].
        sample: Where.
        gap: [m].
        turn: [rad].
    """
    return (
        f"robot '{robot.name}' cannot reach its grasp at sample {sample} (t = {time[sample]:.6g} s): its tip "
        f"came no nearer than {gap:.3g} m and {turn:.3g} rad. Choose another posture, from which another branch may "
        "reach it, or move the path, the base or the grasp."
    )


def branch_lost(robot: Robot, time: Array, sample: int, jump: float) -> str:
    """The message for an arm whose joint would have to jump [rad or m]; time as in `unreachable`."""
    return (
        f"robot '{robot.name}' loses its branch at sample {sample} (t = {time[sample]:.6g} s): a joint is "
        f"{jump:.3g} (rad or m) from where its velocity led. Use more samples, or keep away from the singularity near "
        "there."
    )
