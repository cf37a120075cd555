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
from mrts.kernel.programs import INFEASIBLE, OPTIMAL, backward, effects, forward, half_planes, projections
from mrts.program.sample_problem import SampleProblem
from mrts.program.sample_ranges import REST_TOLERANCE
from mrts.program.smooth_program import segment_times, stop_share

BOX = 1e5
"""Projections end where u or x moves some row by this many limits; what reaches that far counts as unbounded."""

NEAR_BOX = 1 - 1e-6
"""Share of such an end from which a corner lies on it: rounding."""

FARTHEST = 1e3
"""Speeds squared above this multiple of what the path's length and its accelerations make likely count as unbounded."""

NEGLIGIBLE = 1e-11
"""x has no effect where the largest likely one moves no row by more than this share of a limit: on a straight path what
is left of it is rounding."""

NO_DIRECTION = 1e-12
"""A principal direction of the free unknowns that moves rows by less than this share of the first moves none."""

PROBES = 9
"""Samples whose accelerations are looked at, to learn how fast the path may become."""


@dataclass(frozen=True)
class SpeedRegions:
    """Half-planes n_u u + n_x x <= h, in units of limits, at N samples, and bounds of x.

    Attributes:
        start: The half-planes of sample i are start[i] .. start[i + 1] - 1, Shape (N + 1,).
        planes: n_u, n_x, h, Shape (E, 3).
        lower: Least x, Shape (N,).
        upper: Largest x: the maximum velocity curve, infinity where nothing bounds it, Shape (N,).
        bound: An x that no profile within limits reaches.
        undecided: Samples whose region is empty, or was not found.
    """

    start: NDArray[np.int64]
    planes: Array
    lower: Array
    upper: Array
    bound: float
    undecided: tuple[int, ...]

    def with_samples(self, places: NDArray[np.intp], more: "SpeedRegions") -> "SpeedRegions":
        """Those of further samples besides, which are then at some places of all, Shape (k,), in order."""
        before, counts = places - np.arange(len(places)), np.diff(more.start)
        return SpeedRegions(
            np.concatenate([[0], np.cumsum(np.insert(np.diff(self.start), before, counts))]),
            np.insert(self.planes, np.repeat(self.start[before], counts), more.planes, axis=0),
            np.insert(self.lower, before, more.lower),
            np.insert(self.upper, before, more.upper),
            self.bound,
            tuple(places[list(more.undecided)].tolist()),
        )


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
    taken, most = ~problem.is_cap, problem.cap()
    by_itself = taken & ~problem.A[0, :, :-2].any(axis=1)
    by_itself[by_itself] = ~problem.A[:, by_itself, :-2].any(axis=(0, 2))
    every, alone, rows = (of.nonzero()[0].astype(np.int32) for of in (taken, by_itself, taken & ~by_itself))
    effect = effects(problem.A, every)
    effect[effect[:, -2] <= REST_TOLERANCE * effect[:, -2].max(), -2] = 0.0  # u moves nothing but by rounding
    by_row = _both_sides(problem.A[:, alone, -2:], problem.lower[:, alone], problem.upper[:, alone])
    if bound is None:
        bound = FARTHEST * _likely_speed(problem, every, effect[:, -2], most, length, ends)
    reached = np.minimum(bound / FARTHEST, most)
    effect[effect[:, -1] * reached <= NEGLIGIBLE, -1] = 0.0
    if not rows.size:
        return _regions_of_planes(by_row, effect, most, bound)
    with np.errstate(divide="ignore"):
        unit = 1 / effect
    unit[:, -1] = np.where(effect[:, -1] > 0, np.minimum(unit[:, -1], reached), np.inf)
    scale = np.where(np.isfinite(unit), unit, 0.0)
    moves = scale[:, -2:] > 0
    moving = np.where(moves[:, 1], scale[:, -1], 1.0)
    box = np.minimum(bound / moving, BOX)
    cap = np.minimum(most / moving, box)
    least = np.where(moves, [-BOX, 0.0], 0.0)
    largest = np.where(moves, np.column_stack([np.full_like(cap, BOX), cap]), 0.0)
    number, corners = _decided_projections(problem, rows, scale, (least, largest))
    found = (number > 0) & ~(problem.lower > problem.upper).any(axis=1)  # sides that cross leave nothing to project
    if not found.all():
        corners, number = corners[np.repeat(found, number)], np.where(found, number, 0)
    start, planes, low, high = half_planes(number, corners, unit[:, -2:], cap, BOX, NEAR_BOX)
    high = np.where(moves[:, 1] & (high < NEAR_BOX * box), high * moving, np.inf)
    lower = np.maximum(low, 0.0) * scale[:, -1]
    undecided = tuple((~found).nonzero()[0].tolist())
    projected = SpeedRegions(start, planes, lower, np.minimum(high, most), bound, undecided)
    return intersect_regions([projected, _regions_of_planes(by_row, effect, most, bound)]) if alone.size else projected


def _regions_of_planes(planes: Array, effect: Array, most: Array, bound: float) -> SpeedRegions:
    """The regions of half-planes, Shape (N, e, 3); where u or x has no effect, they lose what rounding left of it."""
    for unknown, of in ((0, effect[:, -2]), (1, effect[:, -1])):
        planes[of == 0, :, unknown] = 0.0
    count, sides, _ = planes.shape
    start = np.arange(count + 1, dtype=np.int64) * sides
    return SpeedRegions(start, planes.reshape(-1, 3), np.zeros(count), most, bound, ())


def intersect_regions(regions: Sequence[SpeedRegions]) -> SpeedRegions:
    """What is admissible in all of several regions of the same samples."""
    if len(regions) == 1:
        return regions[0]
    samples = np.concatenate([np.repeat(np.arange(len(part.lower)), np.diff(part.start)) for part in regions])
    return SpeedRegions(
        np.sum([part.start for part in regions], axis=0),
        np.concatenate([part.planes for part in regions])[np.argsort(samples, kind="stable")],
        np.max([part.lower for part in regions], axis=0),
        np.min([part.upper for part in regions], axis=0),
        min(part.bound for part in regions),
        tuple(sorted({sample for part in regions for sample in part.undecided})),
    )


def _likely_speed(
    problem: SampleProblem,
    rows: NDArray[np.int32],
    effect: Array,
    most: Array,
    length: float,
    ends: tuple[float, float],
) -> float:
    """The x that the accelerations of some samples at rest reach along the whole path, at least those of its ends.

    Each is at least that of a whole limit: some samples leave none.
    """
    moving = effect.nonzero()[0]
    if not moving.size:
        return max(*ends, float(np.max(most[np.isfinite(most)], initial=1.0)))
    probes = moving if len(moving) <= PROBES else moving[np.arange(PROBES) * (len(moving) - 1) // (PROBES - 1)]
    scale = np.ones((len(probes), problem.unknowns))
    scale[:, -2] /= effect[probes]
    bound = np.zeros((len(probes), 2))
    bound[:, 0] = BOX
    some = problem.A[probes], problem.lower[probes], problem.upper[probes]
    number, corners, _ = projections(*some, scale, (-bound, bound), rows)
    largest = np.ones(len(probes))
    np.maximum.at(largest, np.repeat(np.arange(len(probes)), number), np.abs(corners[:, 0]))
    return max(*ends, 2 * length * median(largest / effect[probes]))


def _both_sides(A: Array, lower: Array, upper: Array) -> Array:
    planes = np.concatenate([np.dstack([A, upper]), -np.dstack([A, lower])], axis=1)
    limited = np.isfinite(planes[:, :, 2]).any(axis=0)
    return planes if limited.all() else planes[:, limited]


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
    failed = backward(steps, rise, regions.start, planes, lower, upper)
    if failed >= 0:
        return Obstacle("segment", failed, (float(lower[failed + 1]), float(upper[failed + 1])))
    if not _within(ends[0], lower[0], upper[0]):
        return Obstacle("start", 0, (float(lower[0]), float(upper[0])), (float(lower[1]), float(upper[1])))
    first = min(max(ends[0], lower[0]), upper[0])
    x = forward(steps, rise, regions.start, planes, lower, upper, first)
    return SpeedProfile(regions, x, lower, upper, rise)


def rising_profile(found: SpeedProfile, step: Array, ends: tuple[float, float]) -> SpeedProfile:
    """A profile that is faster than another, as s̈ rises on its segments as it did from one to the next.

    A constant s̈ that keeps the limits of both ends of a segment is the lesser of theirs: where the largest s̈ changes
    along the path that costs speed in proportion to the step, and most of it is gained here. Limits hold at both ends
    of every segment as before. The rise is the lesser of the two slopes beside a segment, none where s̈ turns there or
    jumps (the minmod limiter), and no large one. Where little is likely to be gained the profile is returned as it is.

    Args:
        step: Length of each segment, Shape (n - 1,).
    """
    times, rise = segment_times(step, found.x, found.rise), _rises(step, found.x)
    lasts = float(times.sum())
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
    lesser = np.where(np.abs(before) < np.abs(after), before, after)
    most = MOST_RISE * median(np.abs(u))
    rise[1:-1] = np.clip(np.where(before * after > 0, lesser, 0.0) * step[1:-1], -most, most)
    return rise


def _within(value: float, lower: float, upper: float) -> bool:
    tolerance = END_SPEED_TOLERANCE * max(abs(lower), abs(upper), abs(value))
    return lower - tolerance <= value <= upper + tolerance
