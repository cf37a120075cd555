# SPDX-License-Identifier: MIT
"""Limits on how fast torques, contact wrenches and accelerations change."""

from dataclasses import dataclass

from mrts.base.arrays import Array


@dataclass(frozen=True)
class RateLimits:
    """Limits of rates; infinity where there is none.

    Attributes:
        torque: Of |τ̇|, Shape (m,) [N m/s].
        wrench: Of |Ḟ|, robot after robot in base axes, Shape (n w,) [N/s, N m/s].
        jerk: Of |q⃛|, Shape (m,) [rad/s³].
    """

    torque: Array
    wrench: Array
    jerk: Array
