# SPDX-License-Identifier: MIT
"""What motors must give beside what moves the arms: rotor inertia and friction along a motion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import LimitRows
from mrts.motion.rows_at_rest import REST


@dataclass(frozen=True, kw_only=True)
class MotorTerms:
    """τ of the motors less τ of the arms: square ṙ² + rate r̈ + speed ṙ + dry, at N samples of m joints.

    Attributes:
        square: I_a q'', Shape (N, m).
        rate: I_a q', Shape (N, m).
        speed: b q', Shape (N, m); None where no joint has viscous friction.
        dry: τ_c in the direction of travel, Shape (N, m) [N m or N].
        turning: τ_c where a joint turns back at a sample: it acts in both directions there, and `dry` has none,
            Shape (N, m) [N m or N]; None where no joint does.
    """

    square: Array
    rate: Array
    speed: Array | None
    dry: Array
    turning: Array | None

    def at(self, samples: NDArray[np.int_] | slice) -> "MotorTerms":
        """The same at some samples only."""
        return MotorTerms(
            square=self.square[samples],
            rate=self.rate[samples],
            speed=None if self.speed is None else self.speed[samples],
            dry=self.dry[samples],
            turning=None if self.turning is None else self.turning[samples],
        )

    def torque(self, speed: float) -> Array:
        """All that the motors give besides at a constant factor of speed, Shape (N, m) [N m or N]."""
        return self.square * speed**2 + self.friction(speed)

    def margin(self, rows: LimitRows) -> Array | None:
        """By how much limits move inward where friction may act in both directions, Shape (N, r); None if none does."""
        return None if self.turning is None else self.turning @ np.abs(rows.torque_matrix).T

    def friction(self, speed: float | Array) -> Array:
        """The part of τ that friction is at ṙ, Shape (N, m) [N m or N].

        Args:
            speed: ṙ, one for all samples, or Shape (N, 1).
        """
        return self.dry if self.speed is None else self.dry + self.speed * speed


def motor_terms(cell: Cell, motion: CoordinatedMotion) -> MotorTerms | None:
    """Rotor inertia and friction of a cell along a motion; None where its motors are ideal."""
    motors = [robot.motors for robot in cell.robots]
    if not any(motor.has_effect for motor in motors):
        return None
    armature, coulomb, viscous = (
        np.concatenate([getattr(motor, name) for motor in motors]) for name in ("armature", "coulomb", "viscous")
    )
    before, after = travel_directions(motion)
    turns = (before != after) & (coulomb > 0)
    return MotorTerms(
        square=armature * motion.ddq,
        rate=armature * motion.dq,
        speed=viscous * motion.dq if np.any(viscous) else None,
        dry=coulomb * (before + after) / 2,
        turning=coulomb * turns if np.any(turns) else None,
    )


def travel_directions(motion: CoordinatedMotion) -> Array:
    """Signs of each joint's velocity just before and just after every sample, Shape (2, N, m); 0 where it stands.

    Where the motion does not tell them and q' = 0, q'' does: a joint arrives against it and leaves with it. At the
    first sample nothing is before, at the last nothing after.
    """
    if motion.travel is not None:
        return motion.travel
    dq, ddq = motion.dq, motion.ddq
    speed, change = np.abs(dq), np.abs(ddq)
    moving = np.where(speed > REST * np.max(speed), np.sign(dq), 0.0)
    leaving = np.where(change > REST * np.max(change), np.sign(ddq), 0.0)
    before, after = np.where(moving == 0, -leaving, moving), np.where(moving == 0, leaving, moving)
    before[0], after[-1] = after[0], before[-1]
    return np.stack([before, after])
