# SPDX-License-Identifier: MIT
"""The motion of the carried object, and its samples from splines and paths."""

from dataclasses import InitVar, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mrts.base.argument_types import check_type
from mrts.base.arrays import Array, freeze
from mrts.base.errors import InputError, as_array
from mrts.base.remark import Remark
from mrts.motion.rounded_samples import splines_through
from mrts.motion.velocity_profile import Profile

ROTATION_LENGTH = 0.25
"""Metres of path that a turn by one radian counts as, where waypoints are spaced along a path."""

ORTHOGONAL = 1e-6
"""Largest entry of R Rᵀ - I: matrices from tables carry few digits."""

RATE_TOLERANCE = 0.1
"""Largest part of a step that velocities may miss: a trapezoid in eleven samples misses 0.03."""

ACCELERATION_TOLERANCE = 0.5
"""The same for accelerations, which may jump inside a step; from the start to any sample the jumps cancel out."""

NOISE = 2e-4
"""Steps of positions and of rates that rounding may leave out [m, rad and per s]: tables may carry four decimals."""

NOISE_SHARE = 0.05
"""Share of the largest way, and of the largest rate, that it may be: else any table of a small motion passes."""

STILL = 1e-9
"""Steps that are rounding, whatever moves [m, rad and per s]."""

SHORTEST_STEP = 1e-9
"""Least time between samples [s]: below it squares of rates overflow."""

SAME_WAYPOINT = 1e-9
"""Waypoints nearer than this [m, with turns by `ROTATION_LENGTH`] are one."""


@dataclass(frozen=True, repr=False)
class ObjectMotion:
    """N samples of the given motion of the object frame, world axes.

    Attributes:
        time: Shape (N,) [s], strictly increasing from 0.
        position: p, Shape (N, 3) [m].
        rotation: R_world_object, Shape (N, 3, 3).
        twist: [p'; φ'], Shape (N, 6) [m/s, rad/s].
        acceleration: [p''; φ''], Shape (N, 6) [m/s², rad/s²].
        remarks: What to know of how it was read.
        smooth: Whether the rates are to be compared with the steps between samples; not where accelerations jump.
    """

    time: Array
    position: Array
    rotation: Array
    twist: Array
    acceleration: Array
    smooth: InitVar[bool] = True
    remarks: tuple[Remark, ...] = field(default=(), kw_only=True)

    def __repr__(self) -> str:
        return f"<ObjectMotion: {len(self.time)} samples in {self.time[-1]:.4g} s>"

    def __post_init__(self, smooth: bool) -> None:
        check_type("smooth", smooth, bool)
        shapes = {"time": (), "position": (3,), "rotation": (3, 3), "twist": (6,), "acceleration": (6,)}
        time = as_array("time", self.time)
        if time.ndim != 1 or len(time) < 2 or time[0] != 0 or not np.all(np.diff(time) > 0):  # noqa: PLR2004 (two ends)
            raise InputError("time", "must have Shape (N,) with N >= 2, start at 0 and strictly increase.")
        for name, shape in shapes.items():
            value = as_array(name, getattr(self, name))
            object.__setattr__(self, name, value)
            if value.shape != (len(time), *shape) or not np.all(np.isfinite(value)):
                raise InputError(name, f"must have Shape {(len(time), *shape)} and be finite.")
        off = np.abs(self.rotation @ self.rotation.transpose(0, 2, 1) - np.eye(3))
        if np.max(off) > ORTHOGONAL or np.min(np.linalg.det(self.rotation)) < 0:
            raise InputError("rotation", "must hold rotation matrices: R Rᵀ = I, det R = 1.")
        freeze(self)
        if not smooth:
            return
        steps = Rotation.from_matrix(self.rotation[1:] @ self.rotation[:-1].transpose(0, 2, 1)).as_rotvec()
        turned = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
        noise = noise_allowed(np.column_stack([self.position, turned]), self.twist)
        check_derivatives("position", time, self.position, self.twist[:, :3], self.acceleration[:, :3], noise)
        check_derivatives("rotation", time, turned, self.twist[:, 3:], self.acceleration[:, 3:], noise)

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        freeze(self)


def noise_allowed(values: Array, rates: Array) -> tuple[float, float]:
    """What rounding may leave out of steps of positions, and of rates.

    Args:
        values: All positions of a table, Shape (N, k).
        rates: Their derivatives, Shape (N, k).
    """
    way, rate = float(np.max(np.ptp(values, axis=0))), float(np.max(np.abs(rates)))
    return max(min(NOISE, NOISE_SHARE * way), STILL), max(min(NOISE, NOISE_SHARE * rate), STILL)


def check_derivatives(
    name: str, time: Array, value: Array, rate: Array, change: Array, noise: tuple[float, float]
) -> None:
    """Check rates against the way between samples: catches wrong units, axes and signs, and too few samples.

    From each sample to the next, and from the first to all others, where what cancels out within a few steps does not
    count. The rule that the way is compared with is of fourth order, so a reasonable table passes by far.

    Args:
        name: What is checked, for the message.
        time: Shape (N,) [s].
        value: Shape (N, k).
        rate: Its derivative, Shape (N, k).
        change: The derivative of that, Shape (N, k).
        noise: From `noise_allowed`, of all that the table holds.

    Raises:
        InputError: If the rates do not lead from sample to sample.
    """
    h = np.diff(time)[:, None]
    pairs = (("rates", value, rate, change, noise[0]), ("accelerations", rate, change, None, noise[1]))
    for what, values, first, second, left_out in pairs:
        expected = h / 2 * (first[:-1] + first[1:])
        if second is not None:
            expected = expected + h**2 / 12 * (second[:-1] - second[1:])
        tolerance = RATE_TOLERANCE if second is not None else ACCELERATION_TOLERANCE
        steps = np.diff(values, axis=0)
        off = _lengths(steps - expected)
        size = max(float(np.max(_lengths(steps))), float(np.max(_lengths(expected))))
        _check_way(name, what, time, (np.arange(len(off)), off), size, tolerance * size + left_out)
        way, led = values[1:] - values[0], np.cumsum(expected, axis=0)
        size = max(float(np.max(_lengths(way))), float(np.max(_lengths(led))))
        allowed = RATE_TOLERANCE * size + (0.0 if second is not None else 2 * float(np.max(off)))
        _check_way(name, what, time, (np.zeros(len(off), np.intp), _lengths(way - led)), size, allowed + left_out)


def _lengths(steps: Array) -> Array:
    return np.asarray(np.linalg.norm(steps, axis=1), dtype=np.float64)


def _check_way(
    name: str, what: str, time: Array, missed: tuple[NDArray[np.intp], Array], size: float, allowed: float
) -> None:
    """Check how far the ways that start at given samples and end at 1 to N - 1 are missed, each Shape (N - 1,)."""
    start, off = missed
    worst = int(np.argmax(off))
    if off[worst] <= allowed:
        return
    raise InputError(
        name,
        f"its {what} do not lead from sample {start[worst]} to {worst + 1} (t = {time[start[worst]]:.6g} to "
        f"{time[worst + 1]:.6g} s): they are off by {100 * off[worst] / size:.3g} % of the largest such step. Check "
        "units, world axes and signs; if those are right, the samples are too few.",
    )


def geodesic_motion(
    positions: Array, rotations: Array, profile: Profile, duration: float, samples: int
) -> ObjectMotion:
    """From one pose to another along a straight line and the geodesic rotation.

    Args:
        positions: Start and end, Shape (2, 3) [m].
        rotations: Start and end, Shape (2, 3, 3).
        profile: Velocity profile.
        duration: [s].
        samples: Number of samples.
    """
    u = np.linspace(0.0, 1.0, samples)
    s, ds, dds = profile(u)
    step = positions[1] - positions[0]
    turn = Rotation.from_matrix(rotations[1] @ rotations[0].T).as_rotvec()  # world axes, constant on the geodesic
    direction = np.concatenate([step, turn])
    return ObjectMotion(
        u * duration,
        positions[0] + s[:, None] * step,
        Rotation.from_rotvec(s[:, None] * turn).as_matrix() @ rotations[0],
        ds[:, None] / duration * direction,
        dds[:, None] / duration**2 * direction,
    )


def waypoint_motion(
    positions: Array, rotations: Array, profile: Profile, duration: float, samples: int
) -> ObjectMotion:
    """Through waypoints on a C² path: a cubic spline in position and scipy's rotation spline.

    The path parameter is the distance along the waypoints, a turn counted by `ROTATION_LENGTH`; the profile runs it
    from the first to the last.

    Args:
        positions: Shape (M, 3) [m].
        rotations: Shape (M, 3, 3).
        profile: Velocity profile.
        duration: [s].
        samples: Number of samples.

    Raises:
        InputError: If two waypoints that follow each other are the same.
    """
    turns = Rotation.from_matrix(rotations[1:] @ rotations[:-1].transpose(0, 2, 1)).magnitude()
    spacing = np.hypot(np.linalg.norm(np.diff(positions, axis=0), axis=1), ROTATION_LENGTH * turns)
    if np.min(spacing) <= SAME_WAYPOINT:
        index = int(np.argmin(spacing))
        raise InputError("waypoints", f"waypoints {index} and {index + 1} are the same; leave one out.")
    knots = np.concatenate([[0.0], np.cumsum(spacing)]) / np.sum(spacing)
    u = np.linspace(0.0, 1.0, samples)
    s, ds, dds = profile(u)
    path = _spline(knots, positions, rotations, np.clip(s, 0.0, 1.0))
    ds, dds = ds[:, None] / duration, dds[:, None] / duration**2
    return ObjectMotion(
        u * duration,
        path.position,
        path.rotation,
        path.twist * ds,
        path.acceleration * ds**2 + path.twist * dds,
    )


def spline_motion(time: Array, positions: Array, quaternions: Array, at: Array) -> ObjectMotion:
    """Through poses at given times on the splines of `splines_through`, of position and quaternion.

    Args:
        time: Shape (M,) [s], strictly increasing from 0.
        positions: Shape (M, 3) [m].
        quaternions: x, y, z, w, of length 1 but for rounding, Shape (M, 4).
        at: Times of the samples, Shape (N,) [s], from 0 to the last of `time`.
    """
    turns = quaternions * np.cumprod(np.where(_flips(quaternions), -1.0, 1.0))[:, None]
    splines, moved = splines_through(time, np.concatenate([positions, turns], axis=1))
    position, turn = (
        [np.column_stack([spline(at, order) for spline in part]).astype(np.float64) for order in range(3)]
        for part in (splines[:3], splines[3:])
    )
    rotation, rate, change = _rotation_rates(*turn)
    return ObjectMotion(
        at,
        position[0],
        rotation,
        np.concatenate([position[1], rate], axis=1),
        np.concatenate([position[2], change], axis=1),
        remarks=(smoothing_remark("the object's poses", float(np.max(moved))),) if np.any(moved) else (),
    )


def smoothing_remark(what: str, moved: float) -> Remark:
    """That positions were smoothed by their rounding, by at most so much [m, rad, or 1]."""
    return Remark(
        "smoothed-digits",
        f"the digits of {what} are too few to be differentiated twice: a smooth path was taken that misses them by "
        f"their rounding on the mean, and by at most {moved:.2g}. Give more digits, or velocities and accelerations.",
    )


def _flips(quaternions: Array) -> NDArray[np.bool_]:
    """Where a quaternion is written with the sign opposite to the row before, Shape (M,)."""
    return np.concatenate([[False], np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0])


def _rotation_rates(q: Array, dq: Array, ddq: Array) -> tuple[Array, Array, Array]:
    """Rotation, angular velocity and acceleration, world axes, of quaternions of any length near 1: φ' = 2 q' q⁻¹."""
    square = np.sum(q**2, axis=1)[:, None]
    rate = 2 * _times_conjugate(dq, q) / square
    stretch = 2 * np.sum(q * dq, axis=1)[:, None] / square
    change = 2 * _times_conjugate(ddq, q) / square - stretch * rate
    return np.asarray(Rotation.from_quat(q).as_matrix(), dtype=np.float64), rate, change


def _times_conjugate(a: Array, b: Array) -> Array:
    """Vector part of the quaternion product a b*, Shape (N, 3)."""
    va, vb, wa, wb = a[:, :3], b[:, :3], a[:, 3:], b[:, 3:]
    product: Array = wb * va - wa * vb - np.cross(va, vb)
    return product


@dataclass(frozen=True)
class _PathSamples:
    """Pose and its first two derivatives by the spline's parameter."""

    position: Array
    rotation: Array
    twist: Array
    acceleration: Array


def _spline(knots: Array, positions: Array, rotations: Array, at: Array) -> _PathSamples:
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 (slow to import, for waypoints and tables only)
    from scipy.spatial.transform import RotationSpline  # noqa: PLC0415

    line = CubicSpline(knots, positions, bc_type="natural")
    turn = RotationSpline(knots, Rotation.from_matrix(rotations))
    rotation = np.asarray(turn(at).as_matrix(), dtype=np.float64)
    # scipy gives rates in the body's axes
    rate, change = (np.einsum("nij,nj->ni", rotation, turn(at, order)) for order in (1, 2))
    return _PathSamples(
        np.asarray(line(at), dtype=np.float64),
        rotation,
        np.concatenate([line(at, 1), rate], axis=1),
        np.concatenate([line(at, 2), change], axis=1),
    )
