# SPDX-License-Identifier: MIT
"""What an exported library is tested with: a sample, a mass, and the answers."""

from dataclasses import dataclass

from mrts.base.arrays import Array


@dataclass(frozen=True)
class EmbeddedVector:
    """One sample, a mass, and the answers; statuses are those of the exported header.

    Attributes:
        inputs: q, dq, ddq, rotation of the object, twist, acceleration.
        mass: [kg].
        status: 0 feasible, 1 unbounded, 2 infeasible; likewise `share_status`.
        ends: c²⁻, c²⁺; infinite where there is none.
        share_status: Of an equal distribution.
        share_ends: Its ends.
        c2: Where torques are compared; 0 for no comparison.
        torque: Shape (m,) [N m or N].
    """

    inputs: tuple[Array, ...]
    mass: float
    status: int
    ends: tuple[float, float]
    share_status: int
    share_ends: tuple[float, float]
    c2: float
    torque: Array
