# SPDX-License-Identifier: MIT
"""What a plan asks of a cell if its clock alone is slowed, as a trajectory controller of ROS 2 does it.

Source: ros2_controllers, joint_trajectory_controller.cpp, `traj_time_ += period * scaling_factor_`: at every tick the
place on the plan goes on by the period times the wanted speed; commanded are the positions of the spline there. It does
so where it commands positions alone, and looks at no limit.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.following.coordinated_motion import carried_by_first
from mrts.program.motion_rows import motion_rows
from mrts.program.widening import motion_widening
from mrts.scaling.scaled_trajectory import ScaledTrajectory


@dataclass(frozen=True)
class SpeedScaling:
    """By which share of themselves limits are passed at least, whatever torques and wrenches follow the commands.

    Attributes:
        time: Of the ticks, Shape (k,) [s].
        excess: Shape (k,); 0 where all limits can be kept.
    """

    time: Array
    excess: Array

    def sentence(self) -> str:
        """The largest excess."""
        worst = int(np.argmax(self.excess))
        if self.excess[worst] == 0:
            return "slowing the plan's clock alone, as speed scaling of ros2_controllers does, would keep all limits"
        return (
            "slowing the plan's clock alone, as speed scaling of ros2_controllers does, would pass limits by "
            f"{100 * self.excess[worst]:.3g} % at least, at {self.time[worst]:.4g} s"
        )

    def to_json(self) -> dict[str, Any]:
        """The excess as JSON values."""
        return {"time": self.time.tolist(), "excess": self.excess.tolist()}


def speed_scaling(plan: ScaledTrajectory, wanted: Array, dt: float) -> SpeedScaling:
    """What following a plan's positions takes when its clock goes on by the wanted speed.

    Between two ticks joints are given the velocity that they have along the plan at the wanted speed then, and the
    acceleration that leads to the next one within the period: no way to follow asks for less.

    Args:
        plan: The plan.
        wanted: At each tick, Shape (k,); below 0 it is 0, as the controller takes it.
        dt: Between ticks [s].
    """
    speed = np.maximum(wanted, 0.0)
    place = np.minimum(dt * np.concatenate([[0.0], np.cumsum(speed)]), plan.duration)
    count = int(np.searchsorted(place, plan.duration)) + 1
    joints = plan.course()
    q, dq = joints(place[:count]), joints(place[:count], 1) * np.append(speed, speed[-1])[:count, None]
    ddq = np.diff(dq, axis=0) / dt
    time = dt * np.arange(len(ddq), dtype=np.float64)
    motion = carried_by_first(plan.cell, time, q[:-1], dq[:-1], ddq)
    return SpeedScaling(time, motion_widening(motion_rows(plan.cell, motion), np.ones(len(time))))
