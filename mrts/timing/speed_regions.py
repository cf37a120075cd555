# SPDX-License-Identifier: MIT
"""The admissible pairs of u = r̈ and x = ṙ² at every sample: convex polygons, as half-planes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, median
from mrts.kernel.one_unknown import KnownPlanes
from mrts.kernel.programs import INFEASIBLE, OPTIMAL, default_programs
from mrts.program.sample_problem import SampleProblem
from mrts.program.sample_ranges import REST_TOLERANCE

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

PROBES = 33
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


def speed_regions(problem: SampleProblem, length: float, ends: tuple[float, float] = (0.0, 0.0)) -> SpeedRegions:
    """Project the polytope of every sample onto (u, x).

    A projection is the hull of answers of linear programs, so a mixture of its corners is feasible: the region lies
    inside the true one, by less than 1e-9 of a limit. The programs count x in units of what may be reached on this
    path, and so are well scaled however short it is.

    Args:
        problem: Rows of [F, u, x], from `build_sample_problem` with a varying speed.
        length: Of the path: over it u changes x by 2 u times that.
        ends: x at the first and the last sample.
    """
    rows, most = np.flatnonzero(~problem.is_cap).astype(np.int32), problem.cap()
    effect = default_programs().effects(problem.A, rows)
    if problem.unknowns == 2:  # noqa: PLR2004 (u and x: the rows are the half-planes)
        A, lower, upper = problem.A[:, rows], problem.lower[:, rows], problem.upper[:, rows]
        return regions_of_planes(KnownPlanes(_both_sides(A, lower, upper), effect), most, length, ends)
    given = _Polytopes(problem.A, problem.lower, problem.upper, rows)
    effect[_at_rest(effect), -2] = 0.0
    likely = _likely_speed(_at_probes(given, effect[:, -2]), most, length, ends)
    reached = np.minimum(likely, most)
    effect[effect[:, -1] * reached <= NEGLIGIBLE, -1] = 0.0
    with np.errstate(divide="ignore"):
        unit = 1 / effect
    unit[:, -1] = np.where(effect[:, -1] > 0, np.minimum(unit[:, -1], reached), np.inf)
    scale = np.where(np.isfinite(unit), unit, 0.0)
    return _by_projection(given, scale, unit, most, FARTHEST * likely)


def regions_of_planes(
    known: KnownPlanes, most: Array, length: float, ends: tuple[float, float] = (0.0, 0.0)
) -> SpeedRegions:
    """The regions where u and x are the only unknowns: every side of a row is a half-plane.

    Args:
        known: The half-planes; those of samples at rest lose what rounding left of u or x.
        most: Largest x that velocities allow, Shape (N,).
        length: Of the path.
        ends: x at the first and the last sample.
    """
    planes, effect = known.planes, known.effect
    at_rest = _at_rest(effect)
    if np.any(at_rest):
        planes[at_rest, :, 0] = effect[at_rest, 0] = 0.0
    likely = _likely_speed(_rates_at_probes(planes, effect[:, 0]), most, length, ends)
    straight = effect[:, 1] * np.minimum(likely, most) <= NEGLIGIBLE
    if np.any(straight):
        planes[straight, :, 1] = 0.0
    count, sides, _ = planes.shape
    start = np.arange(count + 1, dtype=np.int64) * sides
    return SpeedRegions(start, planes.reshape(-1, 3), np.zeros(count), most, FARTHEST * likely, ())


def intersect_regions(regions: Sequence[SpeedRegions]) -> SpeedRegions:
    """What is admissible in all of several regions of the same samples."""
    if len(regions) == 1:
        return regions[0]
    samples = np.concatenate([np.repeat(np.arange(len(part.lower)), np.diff(part.start)) for part in regions])
    order = np.argsort(samples, kind="stable")
    return SpeedRegions(
        _starts(np.bincount(samples, minlength=len(regions[0].lower))),
        np.concatenate([part.planes for part in regions])[order],
        np.max([part.lower for part in regions], axis=0),
        np.min([part.upper for part in regions], axis=0),
        min(part.bound for part in regions),
        tuple(sorted({sample for part in regions for sample in part.undecided})),
    )


def _at_rest(effect: Array) -> NDArray[np.bool_]:
    """Samples at which u moves nothing but by rounding, Shape (N,)."""
    return np.asarray(effect[:, -2] <= REST_TOLERANCE * np.max(effect[:, -2]))


def _likely_speed(rates: Array, most: Array, length: float, ends: tuple[float, float]) -> float:
    """The x that the accelerations of some samples at rest reach along the whole path, at least those of its ends.

    Args:
        rates: The largest u of samples at rest; none where u has no effect.
        most: Largest x that velocities allow, Shape (N,).
        length: Of the path.
        ends: x at the first and the last sample.
    """
    if rates.size:
        return max(*ends, 2 * length * median(rates))
    return max(*ends, float(np.max(most[np.isfinite(most)], initial=1.0)))


def _probes(effect: Array) -> NDArray[np.int_]:
    """Some samples at which u has an effect, Shape (N,)."""
    moving = np.flatnonzero(effect)
    return moving if len(moving) <= PROBES else moving[np.arange(PROBES) * (len(moving) - 1) // (PROBES - 1)]


def _at_probes(given: "_Polytopes", effect: Array) -> Array:
    """The largest u of some samples at rest, at least that of a whole limit: some samples leave none.

    Args:
        given: Rows of [F, u, x].
        effect: Of u on the rows, Shape (N,).
    """
    probes = _probes(effect)
    scale = np.ones((len(probes), given.A.shape[2]))
    scale[:, -2] /= effect[probes]
    bound = np.tile([BOX, 0.0], (len(probes), 1))
    number, corners, _ = given.at(probes).projections(scale, (-bound, bound))
    largest = np.ones(len(probes))
    np.maximum.at(largest, np.repeat(np.arange(len(probes)), number), np.abs(corners[:, 0]))
    return np.asarray(largest / effect[probes])


def _rates_at_probes(planes: Array, effect: Array) -> Array:
    """`_at_probes` of half-planes, Shape (N, e, 3)."""
    probes = _probes(effect)
    per_u, limit = planes[probes, :, 0] / effect[probes, None], planes[probes, :, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = limit / per_u
    most = np.min(np.where(per_u > 0, ends, BOX), axis=1, initial=BOX)
    least = np.max(np.where(per_u < 0, ends, -BOX), axis=1, initial=-BOX)
    empty = (least > most) | np.any((per_u == 0) & (limit < 0), axis=1)
    return np.maximum(np.where(empty, 1.0, np.maximum(np.abs(least), np.abs(most))), 1.0) / effect[probes]


def _starts(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def _both_sides(A: Array, lower: Array, upper: Array) -> Array:
    """Every side of rows over u and x that has a limit, as half-planes, Shape (N, e, 3)."""
    sides = np.concatenate([A, -A], axis=1)
    limit = np.concatenate([upper, -lower], axis=1)
    limited = np.any(np.isfinite(limit), axis=0)
    return np.concatenate([sides[:, limited], limit[:, limited, None]], axis=2)


@dataclass(frozen=True)
class _Polytopes:
    """Rows of [F, u, x] at N samples, of which some count.

    Attributes:
        A: Shape (N, r, k).
        lower: Shape (N, r).
        upper: Shape (N, r).
        rows: Those that count, Shape (s,).
    """

    A: Array
    lower: Array
    upper: Array
    rows: NDArray[np.int32]

    def at(self, samples: NDArray[np.int_]) -> "_Polytopes":
        """Those of some samples."""
        return _Polytopes(self.A[samples], self.lower[samples], self.upper[samples], self.rows)

    def projections(
        self, scale: Array, bounds: tuple[Array, Array]
    ) -> tuple[NDArray[np.int32], Array, NDArray[np.uint8]]:
        """Their projections onto (u, x); see `mrts.kernel.programs.Programs.projections`."""
        return default_programs().projections(self.A, self.lower, self.upper, scale, bounds, self.rows)

    def decided_projections(self, scale: Array, bounds: tuple[Array, Array]) -> tuple[NDArray[np.int32], Array]:
        """The same, without corners where there is none. What the kernel did not decide, over other free unknowns.

        Along principal directions of the rows unknowns do not replace each other but for a small rest, whose multiplier
        is too small to be told from rounding.
        """
        number, corners, status = self.projections(scale, bounds)
        again = np.flatnonzero((status != OPTIMAL) & (status != INFEASIBLE))
        if not again.size:
            return number, corners
        some = self.at(again)
        turned, free = some.A * scale[again, None, :], self.A.shape[2] - 2
        directions, sizes, _ = np.linalg.svd(turned[:, self.rows, :free], full_matrices=False)
        used = sizes > NO_DIRECTION * sizes[:, :1]
        turned[:, :, :free] = 0.0
        turned[:, self.rows, : used.shape[1]] = directions * used[:, None, :]
        ones, its_bounds = np.ones_like(scale[again]), (bounds[0][again], bounds[1][again])
        more, found, _ = replace(some, A=turned).projections(ones, its_bounds)
        places = np.repeat(np.cumsum(number)[again], more)  # none of them had corners
        number[again] = more
        return number, np.insert(corners, places, found, axis=0)


def _by_projection(given: _Polytopes, scale: Array, unit: Array, most: Array, bound: float) -> SpeedRegions:
    count, of_x = len(unit), scale[:, -1]
    moving = np.where(of_x > 0, of_x, 1.0)
    box = np.minimum(bound / moving, BOX)
    cap = np.minimum(most / moving, box)
    moves = scale[:, -2:] > 0
    least = np.where(moves, [-BOX, 0.0], 0.0)
    largest = np.where(moves, np.column_stack([np.full(count, BOX), cap]), 0.0)
    number, corners = given.decided_projections(scale, (least, largest))
    found = (number > 0) & ~np.any(given.lower > given.upper, axis=1)  # sides that cross leave nothing to project
    if not np.all(found):
        corners, number = corners[np.repeat(found, number)], np.where(found, number, 0)
    start, planes, low, high = default_programs().half_planes(number, corners, unit[:, -2:], cap, BOX, NEAR_BOX)
    high = np.where(high >= NEAR_BOX * box, np.inf, high)
    return SpeedRegions(
        start,
        planes,
        np.maximum(low, 0.0) * of_x,
        np.minimum(np.where(of_x > 0, high * moving, np.inf), most),
        bound,
        tuple(np.flatnonzero(~found).tolist()),
    )
