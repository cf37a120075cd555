# SPDX-License-Identifier: MIT
"""The fastest speed along a path where rows have terms in ṡ = √x: programs without it, one after the other."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.program.sample_problem import SampleProblem
from mrts.timing.fastest_profile import Obstacle, SpeedProfile, fastest_profile
from mrts.timing.speed_cells import profile_through_cells
from mrts.timing.speed_regions import SpeedRegions, intersect_regions, speed_regions
from mrts.timing.speed_terms import chords, tangents, without_root

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


@dataclass(frozen=True)
class Step:
    """One step: the regions that it took, and the fastest profile in them."""

    regions: SpeedRegions
    profile: SpeedProfile


def successive_profiles(
    problems: Sequence[SampleProblem], step: Array, ends: tuple[float, float]
) -> list[Step] | Obstacle:
    """Profiles within limits, each faster than the one before, or where there is none.

    Where √x presses towards a limit it is replaced by its tangent at the last profile, where it helps to keep one by
    its chord over an interval around that profile, which only narrows: rows are stricter than the given ones, and the
    last profile keeps them, so the next one is no slower. Where a profile ends at the border of such an interval, all
    are opened again.

    Args:
        problems: Rows of [F, u, x] with terms in √x, one a load.
        step: Length of each segment, Shape (n - 1,).
        ends: x at the first and the last sample.
    """
    search = _Search(problems, step, ends)
    first = search.first()
    if isinstance(first, Obstacle):
        return first
    done, before = [first], np.inf
    while duration(step, done[-1].profile.x) < before * (1 - CONVERGED) and len(done) < MOST_STEPS:
        before = duration(step, done[-1].profile.x)
        if not search.narrow(done):
            break
    done[-1] = search.linear_at(done[-1])
    return done


@dataclass(frozen=True)
class _Search:
    """What all steps have in common."""

    problems: Sequence[SampleProblem]
    step: Array
    ends: tuple[float, float]

    def first(self) -> Step | Obstacle:
        """A profile within limits, if there is one.

        Where the cell can hold still at every sample with something to spare, a slow enough one is; else it is searched
        for among all speeds.
        """
        bare = self.fastest([replace(problem, speed=None, torque_speed=None) for problem in self.problems])
        for at in () if bare is None else [share * bare.profile.x for share in STARTS]:
            found = self.near(at, np.zeros_like(at), FIRST_REACH * at)
            if found is not None:
                return found
        through = profile_through_cells(self.problems, self.step, self.ends)
        return through if isinstance(through, Obstacle) else Step(*through)

    def narrow(self, done: list[Step]) -> bool:
        """Add faster profiles while chords grow narrower; whether the last touches the border of its interval."""
        least, most = np.zeros_like(done[-1].profile.x), np.full_like(done[-1].profile.x, np.inf)
        stage = 0
        while len(done) < MOST_STEPS:
            x = done[-1].profile.x
            least, most = np.maximum(least, x / WIDTHS[stage]), np.minimum(most, x * WIDTHS[stage])
            found = self.near(x, least, most)
            before, after = (np.inf if one is None else duration(self.step, one.profile.x) for one in (done[-1], found))
            if found is not None and after < before:
                done.append(found)
            if stage == len(WIDTHS) - 1 and not after < before * (1 - CONVERGED):
                break
            stage = min(stage + 1, len(WIDTHS) - 1)
        x = done[-1].profile.x
        at_border = (x <= least * (1 + AT_BORDER)) | (x >= most * (1 - AT_BORDER))
        return bool(np.any(at_border[1:-1]))

    def near(self, at: Array, least: Array, most: Array) -> Step | None:
        """The fastest profile between two others within rows that are stricter than the given ones.

        Args:
            at: Where tangents are laid, Shape (n,).
            least: Least x, Shape (n,).
            most: Largest x, Shape (n,).
        """
        at = np.maximum(at, LEAST_SHARE * np.max(at))
        above, below = (lines.pinned(self.ends) for lines in (tangents(at), chords(least, np.maximum(most, at))))
        strict = [without_root(problem, above, below) for problem in self.problems]
        inside = np.ones(len(at), dtype=bool)
        inside[[0, -1]] = False
        return self.fastest(strict, np.where(inside, least, 0.0), np.where(inside, most, np.inf))

    def linear_at(self, last: Step) -> Step:
        """The same profile with all speeds that rows linear at it admit: what else could have been.

        There √x is its tangent in every row, which is exact at the profile and near it.
        """
        x = last.profile.x
        lines = tangents(np.maximum(x, LEAST_SHARE * np.max(x))).pinned(self.ends)
        around = self.fastest([without_root(problem, lines, lines) for problem in self.problems])
        if around is None:
            return last
        lower, upper = np.minimum(around.profile.lower, x), np.maximum(around.profile.upper, x)
        return Step(around.regions, SpeedProfile(x, lower, upper, last.profile.rise))

    def fastest(
        self, problems: Sequence[SampleProblem], least: Array | float = 0.0, most: Array | float = np.inf
    ) -> Step | None:
        """The fastest profile between two others where no row has a term in √x; None if there is none."""
        regions = intersect_regions(
            [speed_regions(problem, float(np.sum(self.step)), self.ends) for problem in problems]
        )
        if regions.undecided:
            return None
        regions = replace(regions, lower=np.maximum(regions.lower, least), upper=np.minimum(regions.upper, most))
        found = fastest_profile(self.step, regions, self.ends)
        return Step(regions, found) if isinstance(found, SpeedProfile) else None


def duration(step: Array, x: Array) -> float:
    """Of a profile [s]; infinity where it stands still.

    Args:
        step: Length of each segment, Shape (n - 1,).
        x: Shape (n,).
    """
    speed = np.sqrt(x)
    with np.errstate(divide="ignore"):
        return float(np.sum(2 * step / (speed[:-1] + speed[1:])))
