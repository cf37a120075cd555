# SPDX-License-Identifier: MIT
"""The motion played at the chosen speed: what a controller gets."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid

from mrts.cell import Cell
from mrts.coordinated_motion import CoordinatedMotion
from mrts.rigid_transform import Array


@dataclass(frozen=True)
class ScaledTrajectory:
    """Eqs. (9), (10), (19): q̃(t) = q(c t), with joint torques and contact wrenches, at N samples.

    Attributes:
        c2: c².
        time: t / c, Shape (N,) [s].
        q: Shape (N, m) [rad or m].
        dq: q̇ = c q', Shape (N, m) [rad/s or m/s].
        ddq: q̈ = c² q'', Shape (N, m) [rad/s² or m/s²].
        torque: τ, Shape (N, m) [N m or N].
        wrench: F, robot after robot in base axes, Shape (N, n w) [N, N m].
        internal_wrench: F - B⁺ B F with B = [B_1 … B_n], the part that does not move the object, Shape (N, n w).
        power: q̇ · τ of every joint, Shape (N, m) [W].
    """

    c2: float
    time: Array
    q: Array
    dq: Array
    ddq: Array
    torque: Array
    wrench: Array
    internal_wrench: Array
    power: Array

    @property
    def duration(self) -> float:
        """New traversal time t_1 = t_f / c [s]."""
        return float(self.time[-1])

    @property
    def energy(self) -> float:
        """Energy that the motors give, Σ ∫ q̇ᵀ τ dt (remark after (34)), by the trapezoidal rule [J]."""
        return float(trapezoid(np.sum(self.power, axis=1), self.time))


def scaled_trajectory(
    cell: Cell, motion: CoordinatedMotion, c2: float, torque: Array, wrench: Array
) -> ScaledTrajectory:
    """Assemble the scaled motion.

    Args:
        cell: The cell.
        motion: The given motion.
        c2: c² > 0.
        torque: Shape (N, m) [N m or N].
        wrench: Shape (N, n w), base axes [N, N m].
    """
    c = float(np.sqrt(c2))
    B = cell.functions("terms", motion.samples, motion.inputs(cell.load))["B"]
    carried = np.linalg.pinv(B) @ (B @ wrench[:, :, None])
    dq = c * motion.dq
    return ScaledTrajectory(
        c2,
        motion.object.time / c,
        motion.q,
        dq,
        c2 * motion.ddq,
        torque,
        wrench,
        wrench - carried[:, :, 0],
        dq * torque,
    )
