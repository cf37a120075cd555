# SPDX-License-Identifier: MIT
"""What an exported library takes from the run time: the cell's limits, and the answers that it is tested with."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from numpy.typing import NDArray

from mrts.base.arrays import Array


@dataclass(frozen=True, kw_only=True)
class EmbeddedLimits:
    """Rows lower <= M [τ; F; H] <= upper over m torques, all wrenches and the same in object axes, and other limits.

    Attributes:
        texts: Of each row, such as "left/elbow torque", of each velocity, and of each limit of the motion alone.
        matrix: M, Shape (r, m + n w) without H, else (r, m + 2 n w).
        tables: Numbers by their words in codegen/embedded/templates, which say what they are; infinity where there is
            no limit. BASE and AXES are missing where no row is in object axes, ARMATURE and those after it where all
            motors are ideal, ACCELERATION_LOWER and those after it where only velocities limit the motion.
    """

    texts: tuple[str, ...]
    matrix: Array
    tables: Mapping[str, NDArray[Any]]


@dataclass(frozen=True, kw_only=True)
class EmbeddedPlan:
    """A plan that is played at any speed, as `cell_plan` of the exported header has it.

    Attributes:
        nodes: `cell_plan_node`, Shape (n,), with the fields of the header.
        limits: Names of what may be active.
        backwards: Whether limits hold against the plan's direction too.
        varies: Whether the largest speed is not 1 everywhere.
        keeps_rates: The place in `limits` of the rates that are kept; 0 where none are.
        load: Load vector, Shape (10,).
        armature: Of the motors, Shape (m,); likewise `coulomb` and `viscous`.
    """

    nodes: NDArray[Any]
    limits: tuple[str, ...]
    backwards: bool
    varies: bool
    keeps_rates: int
    load: Array
    armature: Array
    coulomb: Array
    viscous: Array


@dataclass(frozen=True, kw_only=True)
class EmbeddedVector:
    """One sample, a mass, and the answers; statuses are those of the exported header.

    Attributes:
        inputs: q, dq, ddq, rotation of the object, twist, acceleration.
        place: "inside" its motion, or its "start" or "end".
        mass: [kg].
        status: 0 feasible, 1 unbounded, 2 infeasible; likewise `share_status`.
        ends: c²⁻, c²⁺ of the highest interval; infinite where there is none.
        share_status: Of an equal distribution.
        share_ends: Its ends.
        c2: Where torques are compared; 0 for no comparison.
        torque: Shape (m,) [N m or N].
    """

    inputs: tuple[Array, ...]
    place: Literal["inside", "start", "end"]
    mass: float
    status: int
    ends: tuple[float, float]
    share_status: int
    share_ends: tuple[float, float]
    c2: float
    torque: Array
