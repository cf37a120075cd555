# SPDX-License-Identifier: MIT
"""How fast the acceleration of a plan's time may change, so that torques, wrenches and accelerations keep their rates.

What changes at a rate z' along the motion, and by z_u for each unit of u, keeps |z' + z_u u̇| within its rate r while
|u̇| <= (r - |z'|) / |z_u|, of all the least. That is measured at rest, at half and at the largest speed, at the least,
no and the largest u. A governor that may change u no faster must begin in time to bring it back to 0: its bounds fall
no faster along the plan than u can follow, and within what it takes until u is 0 the least change counts.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.binding import INFINITY
from mrts.override.plan_nodes import Corners
from mrts.program.rate_limits import RateLimits

States = Callable[[NDArray[np.intp], Array, Array, Array], NDArray[Any]]
"""States at places after nodes, with speeds and accelerations."""

SPEEDS = (0.0, 0.5, 1.0)
"""Parts of the largest speed at which changes are measured."""

PLACES = (0.05, 0.5, 0.95)
"""Places in each segment, likewise."""

AHEAD = 1e-4
"""Part of a segment over which a rate is a difference."""


def levelled(corners: Corners, part: float, hold: Array) -> Corners:
    """Accelerations alike at rest and at the largest speed, up to a part of the median one, and steady wrenches.

    What the object takes for them goes to all arms alike, as what wrenches lack does while it plays: the wrenches of
    the hardest accelerations are found node by node, and change from one to the next faster than rates allow.
    """
    size = np.abs(corners.acceleration)
    most = part * np.median(size)
    least = np.minimum(np.min(size, axis=2, keepdims=True), most) * np.sign(corners.acceleration)
    accelerate = np.broadcast_to(hold[:, None], corners.accelerate.shape)
    return replace(corners, acceleration=least, hold=hold, accelerate=accelerate)


def largest_changes(corners: Corners, states: States, limits: RateLimits) -> Array:
    """Largest |u̇| at rest and at the largest speed, below 0 where rates are passed anyhow, Shape (n, 2)."""
    step = np.diff(corners.motion.object.time)
    segment = np.flatnonzero(step)
    found = np.full((len(SPEEDS), len(step)), INFINITY)
    for speed, of_speed in enumerate(SPEEDS):
        for place in PLACES:
            least, largest, most = (
                of[segment] + place * (of[segment + 1] - of[segment])
                for of in (corners.acceleration[:, 0, 0], corners.acceleration[:, 1, 0], corners.most)
            )
            v, inside = of_speed * np.sqrt(most), place * step[segment]
            none = np.zeros_like(v)
            here = [_values(states(segment, inside, v, u)) for u in (least, none, largest)]
            per_u = [
                np.divide(value - here[1], u[:, None], out=np.zeros_like(value), where=u[:, None] != 0)
                for value, u in ((here[0], least), (here[2], largest))
            ]
            slope = np.maximum(*np.abs(per_u))
            for value, u in zip(here, (least, none, largest), strict=True):
                dt = AHEAD * step[segment] / np.maximum(1.0, v + np.abs(u) * step[segment])
                moved = _values(states(segment, inside + v * dt, v + u * dt, u))
                left = _limits(limits) - np.abs(moved - value) / dt[:, None]
                with np.errstate(divide="ignore", invalid="ignore"):
                    room = np.where(np.isfinite(left) & (slope > 0), left / slope, np.where(left < 0, left, INFINITY))
                found[speed, segment] = np.minimum(found[speed, segment], np.min(room, axis=1))
    at_rest, half, most_ = found
    pairs = np.stack([at_rest, np.minimum(most_, 2 * half - at_rest)])  # the line between lies below at half the speed
    shown = np.full((2, len(step) + 1), INFINITY)
    shown[:, :-1] = pairs
    shown[:, 1:] = np.minimum(shown[:, 1:], pairs)
    return np.asarray(shown.T)


def followed(corners: Corners, rate: Array, *, backwards: bool) -> Corners:
    """Corners whose accelerations a governor can follow with changes up to `rate`, Shape (n, 2)."""
    time, least = corners.motion.object.time, np.maximum(np.min(rate, axis=1), 0.0)
    count, fastest = len(time), float(np.sqrt(np.max(corners.most)))
    size = np.abs(corners.acceleration[:, :, 0])
    room, ahead = _until_none(np.max(size, axis=1), least, time / fastest)
    if backwards:
        back = _until_none(np.max(size, axis=1)[::-1], least[::-1], -time[::-1] / fastest)
        room, ahead = (np.minimum(of, other[::-1]) for of, other in zip((room, ahead), back, strict=True))
    size = np.minimum(size, room[:, None])
    follow = np.minimum(least[:-1], least[1:]) * np.diff(time) / fastest
    for k in range(count - 2, -1, -1):
        size[k] = np.minimum(size[k], size[k + 1] + follow[k])
    for k in range(1, count):
        size[k] = np.minimum(size[k], size[k - 1] + follow[k - 1])
    given = np.abs(corners.acceleration)
    part = np.divide(size[:, :, None], given, out=np.zeros_like(given), where=given > 0)
    return replace(corners.lowered(part), rate=rate, rate_ahead=ahead)


def _until_none(wanted: Array, change: Array, time: Array) -> tuple[Array, Array]:
    """The u up to those wanted from which changes lead back to 0 before any that is less begins, and that change.

    At the end of the plan nothing moves, whatever u is.
    """
    room, least = np.zeros_like(time), np.zeros_like(time)
    for k in range(len(time)):
        lowest = np.minimum.accumulate(change[k:])
        reach = np.append(lowest[:-1] * (time[k:-1] - time[k]), np.inf if lowest[-1] > 0 else 0.0)
        enough = np.flatnonzero(reach >= wanted[k])
        best = int(enough[0]) if enough.size else int(np.argmax(reach))
        room[k], least[k] = min(reach[best], wanted[k]), lowest[best]
    return room, least


def _values(states: NDArray[Any]) -> Array:
    return np.concatenate([states["torque"], states["wrench"], states["ddq"]], axis=1)


def _limits(limits: RateLimits) -> Array:
    return np.concatenate([limits.torque, limits.wrench, limits.jerk])
