# SPDX-License-Identifier: MIT
"""A piece of a path with a smooth timing, and what is known of how it was found."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.program.rate_limits import RateLimits
from mrts.program.smooth_program import Goal, SmoothProgram
from mrts.program.successive_steps import CONVERGED, StepsTaken
from mrts.timing.retimed_motion import FastestPiece, TimedPiece
from mrts.timing.smooth_path import STRIDE, SmoothPath

BINDING = 1e-4
"""A limit binds where it is reached to this share: interior points come near limits, not to them."""


@dataclass(frozen=True, kw_only=True)
class SmoothPiece(TimedPiece):
    """A piece with its smooth timing; its `piece` is a path by σ.

    Attributes:
        piece: The piece, n samples.
        program: All limits of it, for all loads.
        steps: How the timing was found.
        plan: Free wrenches of the least torques that carry the cell's load within all limits and rates, Shape (n, f).
        torque: Those torques, Shape (n, m) [N m].
        wrench: Contact wrenches with them, Shape (n, n w) [N, N m].
    """

    piece: SmoothPath
    program: SmoothProgram
    steps: StepsTaken
    plan: Array
    torque: Array
    wrench: Array

    def to_json(self, time: Array) -> dict[str, list[float | None]]:
        """The profile as JSON values, along the arc length.

        Args:
            time: Of the given motion, Shape (N,) [s].
        """
        return super().to_json(time) | {
            "sigma": self.piece.path.object.time.tolist(),
            "sigma_speed": np.sqrt(self.x).tolist(),
            "sigma_rate": self.steps.profile.u.tolist(),
        }

    def between(self) -> tuple[NDArray[np.int_], Array, Array, Array]:
        """The fine samples that are not nodes: segment, place in it, x and u there, each Shape (k,)."""
        segment, step = self.piece.inside // STRIDE, self.piece.step
        after = self.piece.fine.object.time[self.piece.inside] - self.piece.path.object.time[segment]
        place, start, change = after / step[segment], self.rates[segment, 0], np.diff(self.rates)[segment, 0]
        return segment, place, self.x[segment] + 2 * after * (start + change * place / 2), start + change * place

    @property
    def binding(self) -> list[set[str]]:
        """Names of the limits that bind on every segment."""
        profile = self.steps.profile
        return self.program.binding(profile.x, profile.u, profile.free, BINDING)


@dataclass(frozen=True)
class SmoothAnswer:
    """What a smooth timing is beside its profile.

    Attributes:
        rates: The limits of rates that it keeps.
        goal: What is least.
        duration: Of the timing; None if there is none [s].
        bound: Duration of the fastest timing without limits of rates, below which none is, as exact as the samples of
            both; None if nothing bounds it [s].
        steps: Convex programs solved, for all pieces and in all rounds of refinement.
        gain: Share by which the last of them lowered the cost; None where no solver took a last one.
        fastest: The path with its fastest timing without limits of rates; empty if nothing bounds it.
    """

    rates: RateLimits
    goal: Goal
    duration: float | None
    bound: float | None
    steps: int
    gain: float | None
    fastest: tuple[FastestPiece, ...] = ()

    def __str__(self) -> str:
        count = "1 step" if self.steps == 1 else f"{self.steps} steps"
        text = f"It is a local optimum, found in {count}, of which the last gained {100 * (self.gain or 0.0):.2g} %"
        if self.gain is None:
            text = f"It was found in {count}, after which no solver took another: a better one may be near"
        elif self.gain >= CONVERGED:
            text = f"It was found in {count}, the last of which gained {100 * self.gain:.2g} %: a better one is near"
        if self.bound is None:
            return text
        if self.duration is not None and self.duration <= self.bound:
            return f"{text}; to within its samples that is as long as the fastest without limits of rates takes"
        return f"{text}; no timing takes less than {self.bound:.4g} s, the fastest without limits of rates"

    @property
    def what(self) -> str:
        """What the timing is, for people."""
        if self.goal.effort == 0:
            return "smooth timing"
        if self.goal.longest is None:
            return f"smooth timing with time = {self.goal.time:g} and energy = {self.goal.effort:g}"
        return f"smooth timing of least energy within {self.goal.longest:g} s"

    def to_json(self) -> dict[str, Any]:
        """The answer as JSON values."""
        return {
            "goal": {"time": self.goal.time, "energy": self.goal.effort, "longest": self.goal.longest},
            "bound": self.bound,
            "steps": self.steps,
            "last_gain": self.gain,
        }


def fastest_pieces(pieces: Sequence[TimedPiece]) -> tuple[FastestPiece, ...]:
    """Those with the fastest speed: all or none of a result."""
    return tuple(part for part in pieces if isinstance(part, FastestPiece))


def smooth_pieces(pieces: Sequence[TimedPiece]) -> list[SmoothPiece]:
    """Those that are smooth: all or none of a result."""
    return [part for part in pieces if isinstance(part, SmoothPiece)]
