# SPDX-License-Identifier: MIT
"""The admissible pairs of u = r̈ and x = ṙ² at every sample, and the fastest speed inside them.

Regions are convex polygons, as half-planes; the passes through them are those of Pham and Pham, IEEE T-RO 34(3), 2018.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, median
from mrts.kernel.programs import INFEASIBLE, OPTIMAL, fastest_speeds, half_planes, projections, scales
from mrts.program.sample_problem import SampleProblem
from mrts.program.smooth_program import segment_times, stop_share

FARTHEST = 1e3
"""The bound of regions is this multiple of the x that is likely, `MRTS_FARTHEST` of projections.c."""

NO_DIRECTION = 1e-12
"""A principal direction of the free unknowns that moves rows by less than this share of the first moves none."""


@dataclass(frozen=True)
class SpeedRegions:
    """Half-planes n_u u + n_x x <= h, in units of limits, at N samples, and bounds of x.

    Attributes:
        start: The half-planes of sample i are start[i] .. start[i + 1] - 1, Shape (N + 1,).
        planes: n_u, n_x, h, Shape (E, 3).
        lower: Least x, Shape (N,).
        upper: Largest x: the maximum velocity curve, infinity where nothing bounds it, Shape (N,).
        bound: An x that no profile within limits reaches.
        undecided: Where the region is empty, or was not found, Shape (N,).
    """

    start: NDArray[np.int64]
    planes: Array
    lower: Array
    upper: Array
    bound: float
    undecided: NDArray[np.bool_]


def speed_regions(
    problem: SampleProblem, length: float, ends: tuple[float, float] = (0.0, 0.0), bound: float | None = None
) -> SpeedRegions:
    """Project the polytope of every sample onto (u, x); rows of u and x alone are half-planes as they are.

    A projection is the hull of answers of linear programs, so a mixture of its corners is feasible: the region lies
    inside the true one, by less than 1e-9 of a limit. The programs count x in units of what may be reached on this
    path, and so are well scaled however short it is.

    Args:
        problem: Rows of [F, u, x], from `build_sample_problem` with a varying speed.
        length: Of the path: over it u changes x by 2 u times that.
        bound: An x that no profile reaches, of other samples of the path; None finds one.
    """
    samples, free = (problem.A, problem.lower, problem.upper), problem.unknowns - 2
    alone = ~problem.is_cap & ~problem.A[0, :, :free].any(axis=1)
    alone[alone] = ~problem.A[:, alone, :free].any(axis=(0, 2))
    every, by_itself, rows, caps = (
        of.nonzero()[0].astype(np.int32) for of in (~problem.is_cap, alone, ~(problem.is_cap | alone), problem.is_cap)
    )
    bound, scale, bounds, most = scales(samples, every, caps, length, ends, bound)
    number, corners = np.zeros(len(most), dtype=np.int32), np.zeros((0, 2))
    undecided = number > 0
    if rows.size:
        number, corners = _decided_projections(problem, rows, scale, bounds)
        crossed = (problem.lower > problem.upper).T.copy()  # numpy is slow along short rows
        undecided = (number == 0) | crossed.any(axis=0)  # such sides leave nothing
    return SpeedRegions(*half_planes(samples, by_itself, scale, (number, corners), most, bound), bound, undecided)


def intersect_regions(
    regions: Sequence[SpeedRegions], places: Sequence[NDArray[np.intp]] | None = None
) -> SpeedRegions:
    """What is admissible in all of several regions: of the same samples, or each of those at some places, in order."""
    if len(regions) == 1:
        return regions[0]
    places = places or [np.arange(len(part.lower)) for part in regions]
    count = 1 + max(int(at[-1]) for at in places)
    lower, upper, undecided = np.zeros(count), np.full(count, np.inf), np.zeros(count, dtype=bool)
    start = np.zeros(count + 1, dtype=np.int64)
    for part, at in zip(regions, places, strict=True):
        lower[at], upper[at] = np.maximum(lower[at], part.lower), np.minimum(upper[at], part.upper)
        undecided[at] |= part.undecided
        start[at + 1] += np.diff(part.start)
    of = np.concatenate([at.repeat(np.diff(part.start)) for part, at in zip(regions, places, strict=True)])
    planes = np.concatenate([part.planes for part in regions]).take(of.argsort(kind="stable"), axis=0)
    return SpeedRegions(start.cumsum(), planes, lower, upper, min(part.bound for part in regions), undecided)


def _decided_projections(
    problem: SampleProblem, rows: NDArray[np.int32], scale: Array, bounds: tuple[Array, Array]
) -> tuple[NDArray[np.int32], Array]:
    """Corners of all samples, and how many each has; what the kernel did not decide, over other free unknowns.

    Along principal directions of the rows unknowns do not replace each other but for a small rest, whose multiplier
    is too small to be told from rounding.
    """
    number, corners, status = projections(problem.A, problem.lower, problem.upper, scale, bounds, rows)
    again = ((status != OPTIMAL) & (status != INFEASIBLE)).nonzero()[0]
    if not again.size:
        return number, corners
    some, free = problem.at(again), problem.unknowns - 2
    turned = some.A * scale[again, None, :]
    directions, sizes, _ = np.linalg.svd(turned[:, rows, :free], full_matrices=False)
    used = sizes > NO_DIRECTION * sizes[:, :1]
    turned[:, :, :free] = 0.0
    turned[:, rows, : used.shape[1]] = directions * used[:, None, :]
    ones, its_bounds = np.ones_like(scale[again]), (bounds[0][again], bounds[1][again])
    more, found, _ = projections(turned, some.lower, some.upper, ones, its_bounds, rows)
    places = np.repeat(np.cumsum(number)[again], more)  # none of them had corners
    number[again] = more
    return number, np.insert(corners, places, found, axis=0)


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
        kind: "segment" (no speed at `sample` leads on), "start" or "end" (the given speed is not admissible), or
            "undecided" (no speed is admissible there, or none was found).
        sample: Where on the path.
        reach: Admissible x there; for a segment, controllable x at its end.
        next_reach: At a start, controllable x at the next sample.
    """

    kind: Literal["segment", "start", "end", "undecided"]
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
    if regions.undecided.any():
        return Obstacle("undecided", int(regions.undecided.argmax()), (0.0, 0.0))
    rise = np.zeros_like(step) if rise is None else rise
    lower, upper = regions.lower.copy(), np.minimum(regions.upper, regions.bound)
    last = len(step)
    if not _within(ends[1], lower[last], upper[last]):
        return Obstacle("end", last, (float(lower[last]), float(upper[last])))
    lower[last] = upper[last] = ends[1]
    failed, x = fastest_speeds(step, rise, regions.start, regions.planes, lower, upper, ends[0])
    if failed >= 0:
        return Obstacle("segment", failed, (float(lower[failed + 1]), float(upper[failed + 1])))
    if not _within(ends[0], lower[0], upper[0]):
        return Obstacle("start", 0, (float(lower[0]), float(upper[0])), (float(lower[1]), float(upper[1])))
    return SpeedProfile(regions, x, lower, upper, rise)


def rising_profile(found: SpeedProfile, step: Array, ends: tuple[float, float], times: Array) -> SpeedProfile:
    """A profile that is faster than another, as s̈ rises on its segments as it did from one to the next.

    A constant s̈ that keeps the limits of both ends of a segment is the lesser of theirs: where the largest s̈ changes
    along the path that costs speed in proportion to the step, and most of it is gained here. Limits hold at both ends
    of every segment as before. The rise is the lesser of the two slopes beside a segment, none where s̈ turns there or
    jumps (the minmod limiter), and no large one. Where little is likely to be gained the profile is returned as it is.

    Args:
        step: Length of each segment, Shape (n - 1,).
        times: Its duration with the profile that is given, likewise [s].
    """
    rise, lasts = _rises(step, found.x), float(times.sum())
    lost = times * np.abs(rise) * step / (found.x[1:] + found.x[:-1])
    if SUMMED * len(step) * float(lost.sum()) < WORTH * lasts:
        return found
    for _ in range(MOST_PASSES):
        faster = fastest_profile(step, found.regions, ends, rise)
        if not isinstance(faster, SpeedProfile) or (stop_share(step, faster.x, rise) >= 1).any():
            return found
        before, lasts = lasts, min(lasts, float(np.sum(segment_times(step, faster.x, rise))))
        if lasts < before:
            found, rise = faster, _rises(step, faster.x)
        if lasts >= before * (1 - WORTH):
            return found
    return found


def _rises(step: Array, x: Array) -> Array:
    """By how much s̈ rises along each segment, from its means on this one and both beside it, Shape (n - 1,)."""
    u, rise = (x[1:] - x[:-1]) / (2 * step), np.zeros(len(step))
    slope = 2 * (u[1:] - u[:-1]) / (step[1:] + step[:-1])
    before, after = slope[:-1], slope[1:]
    lesser = np.minimum(np.minimum(np.abs(before), np.abs(after)) * step[1:-1], MOST_RISE * median(np.abs(u)))
    rise[1:-1] = np.where(before * after > 0, np.copysign(lesser, before), 0.0)
    return rise


def _within(value: float, lower: float, upper: float) -> bool:
    tolerance = END_SPEED_TOLERANCE * max(abs(lower), abs(upper), abs(value))
    return lower - tolerance <= value <= upper + tolerance
