# SPDX-License-Identifier: MIT
"""The fastest speed along a path inside its speed regions (Pham and Pham, IEEE T-RO 34(3), 2018)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from mrts.base.arrays import Array, median
from mrts.kernel.programs import default_programs
from mrts.timing.speed_regions import SpeedRegions

END_SPEED_TOLERANCE = 1e-9
"""Share by which a given end speed may miss its controllable set: rounding."""

MOST_RISE = 0.25
"""Largest rise of s̈ along a segment, as a share of the median |s̈|: where it changes more, limits do between samples."""

WORTH = 1e-3
"""Share of the duration that a further pass with rising s̈ must gain, or be likely to."""

SUMMED = 0.003
"""What a constant s̈ costs, as a share of what the steps' own parts of it would if they all added up: 0.003 to 0.05. It
falls with the step, so fine grids are timed as ever."""

MOST_PASSES = 4
"""Passes with rising s̈; the first gains most."""


@dataclass(frozen=True)
class SpeedProfile:
    """x = ṡ² along a path of n samples; s̈ is linear on each segment, and mostly constant.

    Attributes:
        regions: In which it is the fastest.
        x: The fastest, Shape (n,).
        lower: Least controllable x, Shape (n,).
        upper: Largest controllable x, Shape (n,).
        rise: By how much s̈ rises along each segment, Shape (n - 1,).
    """

    regions: SpeedRegions
    x: Array
    lower: Array
    upper: Array
    rise: Array


@dataclass(frozen=True)
class Obstacle:
    """Why there is no profile.

    Attributes:
        kind: "segment" (no speed at `sample` leads on), "start" or "end" (the given speed is not admissible).
        sample: Where on the path.
        reach: Admissible x there; for a segment, controllable x at its end.
        next_reach: At a start, controllable x at the next sample.
    """

    kind: Literal["segment", "start", "end"]
    sample: int
    reach: tuple[float, float]
    next_reach: tuple[float, float] | None = None


def fastest_profile(
    step: Array, regions: SpeedRegions, ends: tuple[float, float], rise: Array | None = None
) -> SpeedProfile | Obstacle:
    """Controllable sets backward, then the largest speeds forward.

    Args:
        step: Length of each segment, Shape (n - 1,).
        rise: By how much s̈ is to rise along each segment, Shape (n - 1,); None where it is constant on all.
    """
    rise = np.zeros_like(step) if rise is None else rise
    lower, upper = regions.lower.copy(), np.minimum(regions.upper, regions.bound)
    last = len(step)
    if not _within(ends[1], lower[last], upper[last]):
        return Obstacle("end", last, (float(lower[last]), float(upper[last])))
    lower[last] = upper[last] = ends[1]
    planes = np.ascontiguousarray(regions.planes)
    steps = np.ascontiguousarray(step)
    kernel = default_programs()
    failed = kernel.backward(steps, rise, regions.start, planes, lower, upper)
    if failed >= 0:
        return Obstacle("segment", failed, (float(lower[failed + 1]), float(upper[failed + 1])))
    if not _within(ends[0], lower[0], upper[0]):
        return Obstacle("start", 0, (float(lower[0]), float(upper[0])), (float(lower[1]), float(upper[1])))
    first = min(max(ends[0], lower[0]), upper[0])
    x = kernel.forward(steps, rise, regions.start, planes, lower, upper, first)
    return SpeedProfile(regions, x, lower, upper, rise)


def rising_profile(
    found: SpeedProfile, step: Array, ends: tuple[float, float], times: Array | None = None
) -> SpeedProfile:
    """A profile that is faster than another, as s̈ rises on its segments as it did from one to the next.

    A constant s̈ that keeps the limits of both ends of a segment is the lesser of theirs: where the largest s̈ changes
    along the path that costs speed in proportion to the step, and most of it is gained here. Limits hold at both ends
    of every segment as before. The rise is the lesser of the two slopes beside a segment, none where s̈ turns there or
    jumps (the minmod limiter), and no large one. Where little is likely to be gained the profile is returned as it is.

    Args:
        step: Length of each segment, Shape (n - 1,).
        times: Durations of the segments with that profile, Shape (n - 1,) [s], where they are known.
    """
    times, rise = segment_times(step, found.x, found.rise) if times is None else times, _rises(step, found.x)
    lasts = float(np.sum(times))
    lost = times * np.abs(rise) * step / (found.x[1:] + found.x[:-1])
    if SUMMED * len(step) * float(np.sum(lost)) < WORTH * lasts:
        return found
    for _ in range(MOST_PASSES):
        faster = fastest_profile(step, found.regions, ends, rise)
        if not isinstance(faster, SpeedProfile) or np.any(_stop_share(step, faster.x, rise) >= 1):
            return found
        before, lasts = lasts, min(lasts, float(np.sum(segment_times(step, faster.x, rise))))
        if lasts < before:
            found, rise = faster, _rises(step, faster.x)
        if lasts >= before * (1 - WORTH):
            return found
    return found


def segment_times(step: Array, x: Array, rise: Array) -> Array:
    """Duration of each segment, Shape (n - 1,) [s]; infinity where both ends stand still.

    With v = ṡ at its ends it is 2 Δs / (v_0 + v_1) artanh(z) / z with z² = Δs (s̈_1 - s̈_0) / (v_0 + v_1)², the time
    that s̈ = a s + b takes, and arctan where z² < 0.

    Args:
        step: Length of each segment, Shape (n - 1,).
        x: ṡ² at its ends, Shape (n,).
        rise: By how much s̈ rises along each segment, Shape (n - 1,).
    """
    speed = np.sqrt(x)
    duration: Array = 2 * step / (speed[:-1] + speed[1:])
    if np.any(rise):
        share = _stop_share(step, x, rise)
        z = np.sqrt(np.abs(share))
        for sign, inverse in ((share > 0, np.arctanh), (share < 0, np.arctan)):
            duration[sign] *= inverse(z[sign]) / z[sign]
    return duration


def _stop_share(step: Array, x: Array, rise: Array) -> Array:
    """The rise of s̈ on each segment as a share of that with which it would come to rest inside, Shape (n - 1,)."""
    speed, share, rising = np.sqrt(x), np.zeros_like(step), rise != 0
    share[rising] = (step * rise)[rising] / np.square(speed[:-1] + speed[1:])[rising]
    return share


def _rises(step: Array, x: Array) -> Array:
    """By how much s̈ rises along each segment, from its means on this one and both beside it, Shape (n - 1,)."""
    u, rise = np.diff(x) / (2 * step), np.zeros_like(step)
    slope = 2 * np.diff(u) / (step[1:] + step[:-1])
    before, after = slope[:-1], slope[1:]
    lesser = np.where(np.abs(before) < np.abs(after), before, after)
    most = MOST_RISE * median(np.abs(u))
    rise[1:-1] = np.clip(np.where(before * after > 0, lesser, 0.0) * step[1:-1], -most, most)
    return rise


def _within(value: float, lower: float, upper: float) -> bool:
    tolerance = END_SPEED_TOLERANCE * max(abs(lower), abs(upper), abs(value))
    return lower - tolerance <= value <= upper + tolerance
