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
