# SPDX-License-Identifier: MIT
"""The fastest speed along a path inside its speed regions (Pham and Pham, IEEE T-RO 34(3), 2018)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.reachability.speed_kernel import speed_kernel
from mrts.reachability.speed_regions import SpeedRegions

END_SPEED_TOLERANCE = 1e-9
"""Share by which a given end speed may miss its controllable set: rounding."""


@dataclass(frozen=True)
class SpeedProfile:
    """x = ṡ² along a path, linear between its n samples: s̈ is constant on each segment.

    Attributes:
        x: The fastest, Shape (n,).
        lower: Least controllable x, Shape (n,).
        upper: Largest controllable x, Shape (n,).
    """

    x: Array
    lower: Array
    upper: Array


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


def fastest_profile(step: Array, regions: SpeedRegions, ends: tuple[float, float]) -> SpeedProfile | Obstacle:
    """Controllable sets backward, then the largest speeds forward.

    Args:
        step: Length of each segment, Shape (n - 1,).
        regions: Regions of the n samples.
        ends: x at the first and the last sample.
    """
    lower, upper = regions.lower.copy(), np.minimum(regions.upper, regions.bound)
    last = len(step)
    if not _within(ends[1], lower[last], upper[last]):
        return Obstacle("end", last, (float(lower[last]), float(upper[last])))
    lower[last] = upper[last] = ends[1]
    planes = np.ascontiguousarray(regions.planes)
    steps = np.ascontiguousarray(step)
    kernel = speed_kernel()
    failed = kernel.backward(steps, regions.start, planes, lower, upper)
    if failed >= 0:
        return Obstacle("segment", failed, (float(lower[failed + 1]), float(upper[failed + 1])))
    if not _within(ends[0], lower[0], upper[0]):
        return Obstacle("start", 0, (float(lower[0]), float(upper[0])), (float(lower[1]), float(upper[1])))
    first = min(max(ends[0], lower[0]), upper[0])
    return SpeedProfile(kernel.forward(steps, regions.start, planes, lower, upper, first), lower, upper)


def _within(value: float, lower: float, upper: float) -> bool:
    tolerance = END_SPEED_TOLERANCE * max(abs(lower), abs(upper), abs(value))
    return lower - tolerance <= value <= upper + tolerance
