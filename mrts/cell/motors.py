# SPDX-License-Identifier: MIT
"""The motors of one arm, seen from the joint side of their gears, and what a motion asks of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Self

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, as_array
from mrts.base.formats.record import MadeAgain, Shape, check_attributes
from mrts.base.input_file import LARGEST_NUMBER, SMALLEST_NUMBER

ROUNDED_SLOPE = 1e-9
"""Share by which a torque-speed curve may miss falling and concave: corners printed with few digits lie on one line."""

EFFECTS = ("armature", "coulomb", "viscous")
"""What moves a motor's torque, a number a joint."""

RATINGS = ("torque_rate", "jerk", "rated", "power")
"""What a motor bears at most, likewise."""

PER_JOINT = (*EFFECTS, *RATINGS)

NONE_GIVEN = dict.fromkeys(EFFECTS, 0.0) | dict.fromkeys(RATINGS, np.inf)
"""What they are where nothing is known: no effect, no limit."""


Effect = Annotated[Array, Shape("n", finite=True, least=0.0, most=LARGEST_NUMBER)]
Rating = Annotated[Array, Shape("n", least=SMALLEST_NUMBER)]


@dataclass(frozen=True, kw_only=True, eq=False)
class JointMotors(MadeAgain):
    """The motors of n joints, on the joint side of their gears; of a prismatic joint read kg, N, N s/m, m/s.

    Attributes:
        armature: Rotor inertia times gear ratio squared, Shape (n,) [kg m²].
        coulomb: Dry friction, Shape (n,) [N m].
        viscous: Friction that grows with the speed, Shape (n,) [N m s/rad].
        torque_speed: One a joint: corners |q̇|, |τ| of the largest torque while the motor drives, falling and concave
            from standstill to its largest speed, Shape (c, 2) [rad/s, N m]; None where there is none.
        torque_rate: Largest change of the torque, infinity where it is not known, Shape (n,) [N m/s].
        jerk: Likewise of the acceleration, Shape (n,) [rad/s³].
        rated: Continuous (rated) torque, likewise, Shape (n,) [N m].
        power: Largest power that the motor gives or takes up, likewise, Shape (n,) [W].

    Raises:
        InputError: If a number is negative or a curve rises, bends upward or does not start at standstill.
    """

    armature: Effect
    coulomb: Effect
    viscous: Effect
    torque_speed: Annotated[tuple[Array | None, ...], Shape("n")]
    torque_rate: Rating
    jerk: Rating
    rated: Rating
    power: Rating

    def __post_init__(self) -> None:
        check_attributes(self, JointMotors, "motors", n=len(self.torque_speed))
        curves = tuple(None if curve is None else _checked_curve(j, curve) for j, curve in enumerate(self.torque_speed))
        object.__setattr__(self, "torque_speed", curves)

    @classmethod
    def unknown(cls, joints: int) -> Self:
        """Ideal motors: no inertia, no friction, no limits but those of the torque."""
        return cls(torque_speed=(None,) * joints, **{name: np.full(joints, NONE_GIVEN[name]) for name in PER_JOINT})

    @cached_property
    def has_effect(self) -> bool:
        """Whether torques differ from those of ideal motors."""
        return self.has_friction or bool(np.any(self.armature))

    @cached_property
    def has_friction(self) -> bool:
        """Whether some of the torque overcomes friction."""
        return bool(np.any(self.coulomb) or np.any(self.viscous))

    def check_torques(self, where: str, lower: Array, upper: Array, joints: Sequence[str]) -> None:
        """Refuse torque limits of a robot, named in the message, that they contradict."""
        for j, joint in enumerate(joints):
            least, most = float(min(-lower[j], upper[j])), float(max(-lower[j], upper[j]))
            if self.coulomb[j] > 0 and not self.coulomb[j] < least:
                rule = f"Coulomb friction of joint '{joint}' is {self.coulomb[j]:g}, which no torque within its limits "
                rule = f"{rule}({lower[j]:g} to {upper[j]:g}) overcomes. Correct one of them."
                raise InputError(where, rule, key=f"motors.friction.coulomb[{j}]")
            curve = self.torque_speed[j]
            if curve is not None and not most <= curve[0, 1] * (1 + ROUNDED_SLOPE):
                rule = (
                    f"the curve of joint '{joint}' gives {curve[0, 1]:g} at standstill, but its torque limit is "
                    f"{most:g}: they contradict each other. Give a 'torque' of at most {curve[0, 1]:g}, or another "
                    "curve."
                )
                raise InputError(where, rule, key=f"motors.torque_speed[{j}]")


def torque_speed_lines(curve: Array) -> list[tuple[float, float]]:
    """The falling lines |τ| <= a - m |q̇| of a curve, as pairs a [N m], m [N m s/rad]."""
    steps = np.diff(curve, axis=0)
    slopes = -steps[:, 1] / steps[:, 0]
    return [(float(t + m * v), float(m)) for (v, t), m in zip(curve[:-1], slopes, strict=True) if m > 0]


def _checked_curve(joint: int, given: object) -> Array:
    key = f"torque_speed[{joint}]"
    curve = as_array(f"motors: {key}", given)

    def refuse(rule: str) -> InputError:
        return InputError("motors", rule, key=key, value=curve.tolist())

    if curve.ndim != 2 or curve.shape[1] != 2 or len(curve) < 2:  # noqa: PLR2004 (pairs, and at least two)
        raise refuse("must be at least two corners [speed, torque].")
    if not np.all((curve >= 0) & (curve <= LARGEST_NUMBER)):
        raise refuse(f"speeds and torques are sizes: they must be >= 0 and at most {LARGEST_NUMBER:.0e}.")
    if curve[0, 0] != 0:
        raise refuse("its first corner must be at standstill: [0, torque].")
    steps = np.diff(curve, axis=0)
    if np.any(steps[:, 0] <= 0):
        raise refuse("its speeds must rise from corner to corner.")
    if np.any(steps[:, 1] > 0):
        raise refuse("its torques must not rise: a motor gives no more torque at a higher speed.")
    slopes = -steps[:, 1] / steps[:, 0]
    if np.any(np.diff(slopes) < -ROUNDED_SLOPE * np.max(slopes)):
        raise refuse(
            "it must fall ever more steeply (be concave): between its corners more must not be possible than on "
            "straight lines. Leave out the corners that bend it upward."
        )
    curve.setflags(write=False)
    return curve


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
        power_share: The larger of the two, of `JointMotors.power`.
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
    power_share: Array
    peak_speed: Array
    speed_share: Array
    torque_rate: Array
    torque_rate_share: Array
    jerk: Array
    jerk_share: Array


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
    rms_torque, peak_speed = np.sqrt(squares / (time[-1] - time[0])), np.max(np.abs(dq), axis=0)
    torque_rate = np.max(np.abs((end - start) / steps), axis=0)
    jerk = np.max(np.abs(np.diff(ddq, axis=0) / steps), axis=0)
    return JointDuty(
        rms_torque=rms_torque,
        rated_share=rms_torque / motors.rated,
        peak_torque=np.max(np.abs(torque), axis=0),
        torque_share=np.maximum(np.max(torque_share, axis=0), 0.0),
        drive_power=np.maximum(np.max(power, axis=0), 0.0),
        brake_power=np.maximum(-np.min(power, axis=0), 0.0),
        power_share=np.max(np.abs(power), axis=0) / motors.power,
        peak_speed=peak_speed,
        speed_share=peak_speed / np.minimum(velocity_limit, largest),
        torque_rate=torque_rate,
        torque_rate_share=torque_rate / motors.torque_rate,
        jerk=jerk,
        jerk_share=jerk / motors.jerk,
    )
