# SPDX-License-Identifier: MIT
"""What a motion asks of the motors of one arm: how hard, how fast, and for how long."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.motors.joint_motors import JointMotors


@dataclass(frozen=True, kw_only=True, eq=False)
class JointDuty:
    """Duty of n joints over a motion, each Shape (n,); of a prismatic joint read N, m/s, N/s, m/s³.

    Torques are those that the motors give, taken as straight lines between samples. A share is that of what the joint
    bears, 1 being all of it, and 0 where no limit is known. Torque rate and jerk bound nothing unless rates are
    kept (`mrts.scale(rates=…)`). They are differences of neighbouring samples, so a jump, as of dry friction where a
    joint turns back, counts as steep as the samples are close.

    Attributes:
        rms_torque: Root mean square over the motion, pauses before and after it left out [N m].
        rated_share: Of `JointMotors.rated`.
        peak_torque: Largest |τ| [N m].
        torque_share: Largest share of a torque limit, on the side that is nearer.
        drive_power: Largest power q̇ τ that the motor gives [W].
        brake_power: Largest power that it takes up [W].
        peak_speed: Largest |q̇| [rad/s].
        speed_share: Of the velocity limit, or of the end of the torque-speed curve where that is less.
        torque_rate: Largest |τ̇| [N m/s].
        torque_rate_share: Of `JointMotors.torque_rate`.
        jerk: Largest |change of q̈| per second [rad/s³].
        jerk_share: Of `JointMotors.jerk`.
    """

    rms_torque: Array
    rated_share: Array
    peak_torque: Array
    torque_share: Array
    drive_power: Array
    brake_power: Array
    peak_speed: Array
    speed_share: Array
    torque_rate: Array
    torque_rate_share: Array
    jerk: Array
    jerk_share: Array

    def to_json(self) -> dict[str, list[float]]:
        """One list a quantity, a number a joint."""
        return {entry.name: getattr(self, entry.name).tolist() for entry in fields(self)}


def joint_duty(
    motors: JointMotors,
    time: Array,
    dq: Array,
    ddq: Array,
    torque: Array,
    *,
    torque_share: Array,
    velocity_limit: Array,
) -> JointDuty:
    """The duty of an arm along N samples.

    Args:
        motors: Of its n joints.
        time: Shape (N,) [s].
        dq: q̇, Shape (N, n) [rad/s].
        ddq: q̈, Shape (N, n) [rad/s²].
        torque: τ of the motors, Shape (N, n) [N m].
        torque_share: Share of the torque limits that each sample uses, Shape (N, n).
        velocity_limit: Infinity where there is none, Shape (n,) [rad/s].
    """
    steps = np.diff(time)[:, None]
    start, end = torque[:-1], torque[1:]
    squares = np.sum(steps * (start**2 + start * end + end**2) / 3, axis=0)
    power, largest = dq * torque, np.array([np.inf if c is None else c[-1, 0] for c in motors.torque_speed])
    found: dict[str, Any] = {
        "rms_torque": np.sqrt(squares / (time[-1] - time[0])),
        "peak_speed": np.max(np.abs(dq), axis=0),
        "torque_rate": np.max(np.abs((end - start) / steps), axis=0),
        "jerk": np.max(np.abs(np.diff(ddq, axis=0) / steps), axis=0),
    }
    return JointDuty(
        **found,
        rated_share=found["rms_torque"] / motors.rated,
        peak_torque=np.max(np.abs(torque), axis=0),
        torque_share=np.maximum(np.max(torque_share, axis=0), 0.0),
        drive_power=np.maximum(np.max(power, axis=0), 0.0),
        brake_power=np.maximum(-np.min(power, axis=0), 0.0),
        speed_share=found["peak_speed"] / np.minimum(velocity_limit, largest),
        torque_rate_share=found["torque_rate"] / motors.torque_rate,
        jerk_share=found["jerk"] / motors.jerk,
    )
