# SPDX-License-Identifier: MIT
"""Courses of the object, known at all times: a geodesic, a path through waypoints, splines through poses of a table.

A velocity profile says how the path fraction s runs from 0 to 1 over the normalised time u in [0, 1].
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Remark
from mrts.base.rigid_transform import rotations_from_quaternions, rotations_from_vectors, vectors_from_rotations
from mrts.motion.object_motion import ObjectMotion, ObjectRates
from mrts.motion.rounded_samples import Spline, splines_through

ROTATION_LENGTH = 0.25
"""Metres of path that a turn by one radian counts as, where waypoints are spaced along a path."""

SAME_WAYPOINT = 1e-9
"""Waypoints nearer than this [m, with turns by `ROTATION_LENGTH`] are one."""

Fractions = tuple[Array, Array, Array]
"""The share s of a path, and its first and second derivative by the share of the duration, each Shape (k,)."""

Profile = Callable[[Array], Fractions]

RAMP = 1 / 3
"""Share of the duration that a trapezoid accelerates, and that it brakes."""

CORNER_TOLERANCE = 1e-9
"""Share of the duration by which rounding may miss a corner: far above that of any u, far below a step of any table."""


def sinusoid(u: Array) -> Fractions:
    """Velocity ∝ sin(π u) (the paper's section VI); s, ds/du, d²s/du², each Shape (N,)."""
    return (1 - np.cos(np.pi * u)) / 2, np.pi / 2 * np.sin(np.pi * u), np.pi**2 / 2 * np.cos(np.pi * u)


def trapezoid(u: Array) -> Fractions:
    """Constant acceleration, speed, deceleration, a third of the time each; s, ds/du, d²s/du², each Shape (N,).

    At the two corners, where the acceleration jumps, the value of the ramp is taken.
    """
    top, end = 1 / (1 - RAMP), np.minimum(u, 1 - u)  # the nearer end's share of the duration away
    way = top * np.where(end < RAMP, end**2 / (2 * RAMP), end - RAMP / 2)
    s, ds = np.where(u < 1 / 2, way, 1 - way), top * np.minimum(end / RAMP, 1.0)
    return s, ds, np.where(end <= RAMP + CORNER_TOLERANCE, np.sign(1 / 2 - u) * top / RAMP, 0.0)


def cubic(u: Array) -> Fractions:
    """3u² - 2u³: at rest at both ends; s, ds/du, d²s/du², each Shape (N,)."""
    return u**2 * (3 - 2 * u), 6 * u * (1 - u), 6 - 12 * u


def quintic(u: Array) -> Fractions:
    """10u³ - 15u⁴ + 6u⁵: at rest without acceleration at both ends; s, ds/du, d²s/du², each Shape (N,)."""
    return u**3 * (10 + u * (6 * u - 15)), 30 * u**2 * (1 - u) ** 2, 60 * u * (1 - u) * (1 - 2 * u)


PROFILES: dict[str, Profile] = {"sinusoid": sinusoid, "trapezoid": trapezoid, "cubic": cubic, "quintic": quintic}
"""The names that a motion file may use."""

CORNERS: dict[Profile, tuple[float, ...]] = {trapezoid: (RAMP, 1 - RAMP)}
"""Where the acceleration of a profile jumps, if it does."""


@dataclass(frozen=True, repr=False, eq=False)
class ProfiledPath:
    """A path from pose to pose, or through waypoints, as a velocity profile runs along it in a duration [s].

    `rates` gives the motion at shares of the path, by these and their derivatives by time.
    """

    rates: Callable[[Array, Array, Array], ObjectRates]
    profile: Profile
    duration: float

    def __call__(self, time: Array) -> ObjectRates:
        """The motion at some times, Shape (k,) [s]."""
        return self.rates(*self.shares(time))

    def shares(self, time: Array) -> Fractions:
        """Share s of the path at some times [s], s' and s'', each Shape (k,)."""
        s, ds, dds = self.profile(time / self.duration)
        return s, ds / self.duration, dds / self.duration**2


@dataclass(frozen=True, repr=False, eq=False)
class PoseSplines:
    """A spline of x, y, z [m] and of a quaternion x, y, z, w through the rows of a table."""

    spline: Spline

    def __call__(self, time: Array) -> ObjectRates:
        """The motion at some times, Shape (k,) [s]."""
        values = [np.asarray(self.spline(time, order), dtype=np.float64) for order in range(3)]
        (position, velocity, acceleration), turn = zip(*(np.split(of, [3], axis=1) for of in values), strict=True)
        rotation, rate, change = _rotation_rates(*turn)
        return position, rotation, np.hstack([velocity, rate]), np.hstack([acceleration, change])


def geodesic_rates(positions: Array, rotations: Array) -> Callable[[Array, Array, Array], ObjectRates]:
    """Along a straight line and the geodesic rotation from one pose to another: one motion, or many that run alike.

    Start and end are Shape (…, 2, 3) [m] and (…, 2, 3, 3); shares are Shape (k,), and their derivatives Shape (…, k);
    found are position, rotation, twist and acceleration, Shape (…, k, 3), (…, k, 3, 3), (…, k, 6), (…, k, 6).
    """
    first, last = rotations[..., 0, :, :], rotations[..., 1, :, :]
    step = positions[..., 1:, :] - positions[..., :1, :]
    turn = vectors_from_rotations(last @ np.swapaxes(first, -1, -2))[..., None, :]  # world axes, all along the geodesic
    return partial(_along_geodesic, positions[..., :1, :], first, np.concatenate([step, turn], axis=-1))


def _along_geodesic(start: Array, first: Array, direction: Array, s: Array, ds: Array, dds: Array) -> ObjectRates:
    way, lead, samples = s[:, None] * direction, start.shape[:-2], len(s)
    turned = rotations_from_vectors(way[..., 3:]).reshape(*lead, 3 * samples, 3)
    rotation = (turned @ first).reshape(*lead, samples, 3, 3)
    return start + way[..., :3], rotation, ds[..., None] * direction, dds[..., None] * direction


def waypoint_rates(positions: Array, rotations: Array) -> Callable[[Array, Array, Array], ObjectRates]:
    """Through M poses, Shape (M, 3) [m] and (M, 3, 3), on a C² path of splines, as `ProfiledPath.rates`.

    The path parameter is the distance along the waypoints, a turn counted by `ROTATION_LENGTH`.

    Raises:
        InputError: If two waypoints that follow each other are the same.
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 (slow to import, for waypoints and tables only)
    from scipy.spatial.transform import Rotation, RotationSpline  # noqa: PLC0415

    turns = np.linalg.norm(vectors_from_rotations(rotations[1:] @ rotations[:-1].transpose(0, 2, 1)), axis=1)
    spacing = np.hypot(np.linalg.norm(np.diff(positions, axis=0), axis=1), ROTATION_LENGTH * turns)
    if np.min(spacing) <= SAME_WAYPOINT:
        index = int(np.argmin(spacing))
        raise InputError("waypoints", f"waypoints {index} and {index + 1} are the same; leave one out.")
    knots = np.concatenate([[0.0], np.cumsum(spacing)]) / np.sum(spacing)
    line = CubicSpline(knots, positions, bc_type="natural")
    turn = RotationSpline(knots, Rotation.from_matrix(rotations))
    return partial(_spline_rates, line, turn)


def _spline_rates(line: Spline, turn: Callable[..., Any], s: Array, ds: Array, dds: Array) -> ObjectRates:
    """On a spline of position and scipy's rotation spline, whose rates are in the body's axes."""
    along, ds, dds = np.clip(s, 0.0, 1.0), ds[:, None], dds[:, None]
    rotation = np.asarray(turn(along).as_matrix(), dtype=np.float64)
    rate, change = (np.einsum("nij,nj->ni", rotation, turn(along, order)) for order in (1, 2))
    twist, acceleration = np.hstack([line(along, 1), rate]), np.hstack([line(along, 2), change])
    position = np.asarray(line(along), dtype=np.float64)
    return position, rotation, twist * ds, acceleration * ds**2 + twist * dds


def spline_motion(time: Array, positions: Array, quaternions: Array, at: Array) -> ObjectMotion:
    """Through poses of a table on the splines of `splines_through`, of position and quaternion (x, y, z, w).

    Times are Shape (M,) from 0, poses Shape (M, 3) [m] and (M, 4), of length 1 but for rounding; samples are at others.
    """
    flips = np.append(False, np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0)
    turns = quaternions * np.cumprod(np.where(flips, -1.0, 1.0))[:, None]
    spline, moved = splines_through(time, np.concatenate([positions, turns], axis=1))
    course = PoseSplines(spline)
    remarks = (smoothing_remark("the object's poses", moved),) if moved > 0 else ()
    return ObjectMotion(at, *course(at), remarks=remarks, course=course)


def smoothing_remark(what: str, moved: float) -> Remark:
    """That positions were smoothed by their rounding, by at most so much [m, rad, or 1]."""
    return Remark(
        "smoothed-digits",
        f"the digits of {what} are too few to be differentiated twice: a smooth path was taken that misses them by "
        f"their rounding on the mean, and by at most {moved:.2g}. Give more digits, or velocities and accelerations.",
    )


def _rotation_rates(q: Array, dq: Array, ddq: Array) -> tuple[Array, Array, Array]:
    """Rotation, angular velocity and acceleration, world axes, of quaternions of any length near 1: φ' = 2 q' q⁻¹."""
    square = np.sum(q**2, axis=1)[:, None]
    rate = 2 * _times_conjugate(dq, q) / square
    stretch = 2 * np.sum(q * dq, axis=1)[:, None] / square
    change = 2 * _times_conjugate(ddq, q) / square - stretch * rate
    return rotations_from_quaternions(q), rate, change


def _times_conjugate(a: Array, b: Array) -> Array:
    """Vector part of the quaternion product a b*, Shape (N, 3)."""
    va, vb, wa, wb = a[:, :3], b[:, :3], a[:, 3:], b[:, 3:]
    product: Array = wb * va - wa * vb - np.cross(va, vb)
    return product
