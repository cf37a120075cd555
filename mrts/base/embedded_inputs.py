# SPDX-License-Identifier: MIT
"""What an exported library takes from the run time: the cell's limits, and the answers that it is tested with."""

from dataclasses import dataclass
from typing import Literal

from mrts.base.arrays import Array


@dataclass(frozen=True, kw_only=True)
class EmbeddedMotors:
    """What motors add to the torques of m joints, and to the limits; of a prismatic joint read kg, N, N s/m.

    Attributes:
        armature: Shape (m,) [kg m²].
        coulomb: Shape (m,) [N m].
        viscous: Shape (m,) [N m s/rad].
        line_rows: Rows of the limits that fall with the speed: lines of torque-speed curves.
        line_joints: The joint of each.
        slope: By how much they fall with its speed, one a line [N m s/rad].
        end_joints: The joint of each velocity behind that of the object: ends of torque-speed curves.
        rest: Speeds and accelerations up to this share of the largest of a motion are rest: rounding.
    """

    armature: Array
    coulomb: Array
    viscous: Array
    line_rows: tuple[int, ...]
    line_joints: tuple[int, ...]
    slope: Array
    end_joints: tuple[int, ...]
    rest: float


@dataclass(frozen=True, kw_only=True)
class EmbeddedMotions:
    """Limits of accelerations, of p points and of t things on the object, infinity where there is none; m joints.

    Attributes:
        texts: Of each joint's acceleration, the object's linear and angular one, speed and acceleration of each point,
            and of each thing friction and tilt along +a, -a, +b and -b.
        acceleration: Least and largest of the joints, Shape (2, m) [rad/s² or m/s²].
        object_acceleration: Linear and angular, Shape (2,) [m/s², rad/s²].
        axes: Of the joints with all of them at zero, base axes, Shape (m, 3).
        axis_points: A point on each, base frame, Shape (m, 3) [m].
        slides: Whether each joint is prismatic.
        point_joints: First joint of each point's arm, and how many move it: none moves a point of the object.
        points: With every joint at zero in the base frame, or in the object's, Shape (p, 3) [m].
        point_limits: Speed and acceleration of each, Shape (p, 2) [m/s, m/s²].
        thing_axes: a, b and n of each as rows, object frame, Shape (t, 3, 3).
        thing_centres: Centres of mass, object frame, Shape (t, 3) [m].
        friction: Coefficients, Shape (t,).
        tilt: Half widths along a and b over the height of the centre of mass, Shape (t, 2).
        gravity: World axes, Shape (3,) [m/s²].
    """

    texts: tuple[str, ...]
    acceleration: Array
    object_acceleration: Array
    axes: Array
    axis_points: Array
    slides: tuple[bool, ...]
    point_joints: tuple[tuple[int, int], ...]
    points: Array
    point_limits: Array
    thing_axes: Array
    thing_centres: Array
    friction: Array
    tilt: Array
    gravity: Array


@dataclass(frozen=True, kw_only=True)
class EmbeddedLimits:
    """Rows lower <= M [τ; F; H] <= upper over m torques, all wrenches and the same in object axes, and velocity limits.

    Attributes:
        texts: One a row, such as "left/elbow torque".
        matrix: M, Shape (r, m + n w) without H, else (r, m + 2 n w).
        base: Rotation of each base in the world, its columns those of `axes`, Shape (n, 3, 3); None without H.
        axes: Of the object that a triple of a wrench has, x, y, z being 0, 1, 2, Shape (3,); empty without H.
        lower: Shape (r,), minus infinity where unbounded.
        upper: Shape (r,), infinity where unbounded.
        group: Alike for rows of which one measures another's limit of zero; one a row.
        velocity_texts: One a velocity.
        velocity: Of all joints, then of the object's linear and angular velocity, infinity where none is enforced,
            then of e motors whose torque-speed curve ends there, Shape (m + 2 + e,) [rad/s or m/s].
        motors: None where all motors are ideal.
        motions: None where the cell limits neither accelerations nor points, and no thing stands on its object.
    """

    texts: tuple[str, ...]
    matrix: Array
    base: Array | None
    axes: tuple[int, ...]
    lower: Array
    upper: Array
    group: tuple[int, ...]
    velocity_texts: tuple[str, ...]
    velocity: Array
    motors: EmbeddedMotors | None = None
    motions: EmbeddedMotions | None = None


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
