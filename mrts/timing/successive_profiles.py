# SPDX-License-Identifier: MIT
"""The fastest speed along a path where rows have terms in ṡ = √x: programs without it, one after the other.

Terms in √x are those of viscous friction and torque-speed curves. In each program a line stands for √x at every sample,
start + slope x, as the two arrays of `Lines`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.program.sample_problem import SampleProblem
from mrts.timing.fastest_profile import Obstacle, SpeedProfile, fastest_profile, segment_times
from mrts.timing.speed_regions import FARTHEST, SpeedRegions, intersect_regions, speed_regions

CONVERGED = 1e-6
"""Share of the duration by which a step with the narrowest chords must shorten it, or it was the last."""

STARTS = tuple(0.25**power for power in range(8))
"""Shares of the fastest x without terms in ṡ at which the first tangents are laid."""

WIDTHS = (2.0, 1.1, 1.01, 1.001)
"""x stays within this factor of the last profile, step after step; the last chords miss √x by 2e-7 of it."""

FIRST_REACH = 4.0
"""The first chords are from 0 to this multiple of x where the first tangents are laid."""

MOST_STEPS = 50
"""Steps after which the profile is taken as it is: every one keeps all limits."""

AT_BORDER = 1e-9
"""Share of x from which it lies on the border of its interval: rounding."""

LEAST_SHARE = 1e-12
"""Tangents are laid at no less than this share of the largest x: at 0 they are upright."""

Ends = tuple[float, float]
"""x at the first and the last sample of a path."""

Lines = tuple[Array, Array]
"""Start and slope at every sample, each Shape (N,)."""


def successive_profiles(problems: Sequence[SampleProblem], step: Array, ends: Ends) -> list[SpeedProfile] | Obstacle:
    """Profiles within limits, each faster than the one before, or where none leads on.

    Where √x presses towards a limit it is replaced by its tangent at the last profile, where it helps to keep one by
    its chord over an interval around that profile, which only narrows: rows are stricter than the given ones, and the
    last profile keeps them, so the next one is no slower. Where a profile ends at the border of such an interval, all
    are opened again.

    Args:
        problems: Rows of [F, u, x] with terms in √x, one a load.
        step: Length of each segment, Shape (n - 1,).
    """
    search = _Search(problems, step, ends)
    first = search.part_of(_without_speed(problems))
    if isinstance(first, Obstacle):
        first = search.part_of(weaker_rows(problems, step, ends))
    if isinstance(first, Obstacle):
        return first
    done, before = [first], np.inf
    while search.duration(done[-1]) < before * (1 - CONVERGED) and len(done) < MOST_STEPS:
        before = search.duration(done[-1])
        if not search.narrow(done):
            break
    done[-1] = search.linear_at(done[-1])
    return done


def weaker_rows(problems: Sequence[SampleProblem], step: Array, ends: Ends) -> list[SampleProblem]:
    """Rows without √x that are weaker than the given ones at every speed: what they forbid, limits forbid."""
    length, nothing = float(np.sum(step)), np.zeros(problems[0].samples)
    bounds = [speed_regions(one, length, ends).bound for one in _without_speed(problems)]
    likely = max(*ends, min(bounds) / FARTHEST)
    return _linear(problems, (nothing, nothing), _tangents(nothing + likely), ends)


@dataclass(frozen=True)
class _Search:
    problems: Sequence[SampleProblem]
    step: Array
    ends: Ends

    def part_of(self, rows: Sequence[SampleProblem]) -> SpeedProfile | Obstacle:
        """A profile within limits, a part of the fastest one in rows without √x, or why there is none.

        Where the cell can hold still at every sample with something to spare, a slow enough one is within limits. An
        obstacle in weaker rows is one of the limits; otherwise it is that in the stricter rows of the slowest part.
        """
        whole = self.fastest(self.regions(rows))
        if isinstance(whole, Obstacle):
            return whole
        for share in STARTS:
            found = self.near(share * whole.x, np.zeros_like(whole.x), FIRST_REACH * share * whole.x)
            if isinstance(found, SpeedProfile):
                break
        return found

    def narrow(self, done: list[SpeedProfile]) -> bool:
        """Add faster profiles while chords grow narrower; whether the last touches the border of its interval."""
        least, most = np.zeros_like(done[-1].x), np.full_like(done[-1].x, np.inf)
        stage = 0
        while len(done) < MOST_STEPS:
            x, before = done[-1].x, self.duration(done[-1])
            least, most = np.maximum(least, x / WIDTHS[stage]), np.minimum(most, x * WIDTHS[stage])
            found, after = self.near(x, least, most), np.inf
            if isinstance(found, SpeedProfile):
                after = self.duration(found)
                done += [found] if after < before else []
            if stage == len(WIDTHS) - 1 and not after < before * (1 - CONVERGED):
                break
            stage = min(stage + 1, len(WIDTHS) - 1)
        x = done[-1].x
        at_border = (x <= least * (1 + AT_BORDER)) | (x >= most * (1 - AT_BORDER))
        return bool(np.any(at_border[1:-1]))

    def near(self, at: Array, least: Array, most: Array) -> SpeedProfile | Obstacle:
        """The fastest profile between two others, of x at least and at most, in rows made stricter by tangents at x."""
        at = np.maximum(at, LEAST_SHARE * np.max(at))
        chords = _chords(least, np.maximum(most, at))
        regions = self.regions(_linear(self.problems, _tangents(at), chords, self.ends))
        lower, upper, inside = regions.lower.copy(), regions.upper.copy(), slice(1, -1)
        lower[inside] = np.maximum(lower, least)[inside]
        upper[inside] = np.minimum(upper, most)[inside]
        return self.fastest(replace(regions, lower=lower, upper=upper))

    def linear_at(self, last: SpeedProfile) -> SpeedProfile:
        """The same profile with all speeds that rows linear at it admit: what else could have been.

        There √x is its tangent in every row, which is exact at the profile and near it.
        """
        x = last.x
        lines = _tangents(np.maximum(x, LEAST_SHARE * np.max(x)))
        around = self.fastest(self.regions(_linear(self.problems, lines, lines, self.ends)))
        if isinstance(around, Obstacle):
            return last
        lower, upper = np.minimum(around.lower, x), np.maximum(around.upper, x)
        return replace(last, regions=around.regions, lower=lower, upper=upper)

    def regions(self, rows: Sequence[SampleProblem]) -> SpeedRegions:
        length = float(np.sum(self.step))
        return intersect_regions([speed_regions(one, length, self.ends) for one in rows])

    def fastest(self, regions: SpeedRegions) -> SpeedProfile | Obstacle:
        last = len(self.step)
        for sample in regions.undecided[-1:]:
            return Obstacle("end" if sample == last else "segment", sample, (0.0, 0.0))
        return fastest_profile(self.step, regions, self.ends)

    def duration(self, profile: SpeedProfile) -> float:
        """Of a profile [s]; infinity where it stands still."""
        with np.errstate(divide="ignore"):
            return float(np.sum(segment_times(self.step, profile.x, profile.rise)))


def _without_speed(problems: Sequence[SampleProblem]) -> list[SampleProblem]:
    return [replace(one, speed=None, torque_speed=None) for one in problems]


def _linear(problems: Sequence[SampleProblem], pressing: Lines, helping: Lines, ends: Ends) -> list[SampleProblem]:
    """Rows with lines in the place of √x; at the first and the last sample, where x is given, with √x itself."""
    lines = [(start.copy(), slope.copy()) for start, slope in (pressing, helping)]
    for start, slope in lines:
        start[[0, -1]], slope[[0, -1]] = np.sqrt(ends), 0.0
    return [_without_root(one, *lines) for one in problems]


def _tangents(at: Array) -> Lines:
    """Lines that touch √x at some x > 0, Shape (N,), and lie above it."""
    root = np.sqrt(at)
    return root / 2, 0.5 / root


def _chords(least: Array, most: Array) -> Lines:
    """Lines below √x between two of its points, of x >= 0 and > 0, each Shape (N,)."""
    low, high = np.sqrt(least), np.sqrt(most)
    return low * high / (low + high), 1 / (low + high)


def _without_root(problem: SampleProblem, pressing: Lines, helping: Lines) -> SampleProblem:
    """Rows that are linear in x in place of rows with terms in √x.

    Each row with such a term becomes two, one a side. Where the term presses towards that side one line is put in the
    place of √x, where it helps the other. With lines above √x for what presses and below it for what helps the rows are
    stricter than the given ones; the other way round, weaker.
    """
    root = problem.speed
    if root is None:
        return problem
    both = np.any(root, axis=0)
    plain, split = np.flatnonzero(~both), np.flatnonzero(both)
    order = np.concatenate([plain, split, split])
    A, lower, upper = problem.A[:, order], problem.lower[:, order], problem.upper[:, order]
    above, below = np.split(np.arange(len(plain), len(order)), 2)
    lower[:, above], upper[:, below] = -np.inf, np.inf
    for rows, sign, limit in ((above, 1.0, upper), (below, -1.0, lower)):
        term = root[:, split]
        presses = sign * term > 0
        A[:, rows, -1] += term * np.where(presses, pressing[1][:, None], helping[1][:, None])
        limit[:, rows] -= term * np.where(presses, pressing[0][:, None], helping[0][:, None])
    return replace(
        problem,
        names=tuple(problem.names[row] for row in order.tolist()),
        A=A,
        lower=lower,
        upper=upper,
        speed=None,
        torque_speed=None,
        **{
            name: getattr(problem, name)[order] for name in ("unit", "is_limit", "is_cap", "limit_lower", "limit_upper")
        },
    )
