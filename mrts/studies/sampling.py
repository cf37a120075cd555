# SPDX-License-Identifier: MIT
"""Which points a study looks at: how a number is distributed, and a grid or a Sobol sequence, any block by itself."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mrts.base.arrays import Array

SampleName = Literal["grid", "sobol"]

MAX_VARIANTS = 100_000_000
"""At a thousand a second and core a day of one core."""

MAX_STEPS = 100_000
"""Of one number in a grid."""

NEAREST_TO_CERTAIN = 1e-16
"""Least distance of a probability from 0 and 1: a distribution without ends has no number there."""

VALUES_SHOWN = 6
"""Of a list."""


@dataclass(frozen=True)
class Distribution:
    """The values of a parameter.

    Attributes:
        kind: "values" and "steps" (of a range) are levels, one as likely as another; "uniform"; "normal", of numbers
            that happen and are not for a designer to choose.
        numbers: The levels, in the order in which a grid takes them; least and largest value; mean and standard
            deviation.
    """

    kind: str
    numbers: tuple[float, ...]

    @property
    def levels(self) -> tuple[float, ...] | None:
        """The values where they can be counted; None where they cannot."""
        return self.numbers if self.kind in {"values", "steps"} else None

    def at(self, probability: Array) -> Array:
        """The values that probabilities from 0 to 1 stand for, of the same Shape."""
        if self.levels is not None:
            places = (probability * len(self.levels)).astype(np.intp)
            return np.array(self.levels)[np.minimum(places, len(self.levels) - 1)]
        first, second = self.numbers
        if self.kind == "uniform":
            return first + probability * (second - first)
        from scipy.special import ndtri  # noqa: PLC0415 (slow to import, and most studies have no such number)

        quantile: Array = ndtri(np.clip(probability, NEAREST_TO_CERTAIN, 1 - NEAREST_TO_CERTAIN))
        return first + second * quantile

    def text(self, unit: str) -> str:
        """The distribution for people, with the unit of its values, which may be empty."""
        spaced, shown = unit and f" {unit}", [f"{number:g}" for number in self.numbers]
        if self.kind == "steps":
            return f"from {shown[0]} to {shown[-1]}{spaced} in {len(shown)} steps"
        if self.kind == "values":
            more = f", … ({len(shown)} values)" if len(shown) > VALUES_SHOWN else ""
            return f"{', '.join(shown[:VALUES_SHOWN])}{more}{spaced}"
        if self.kind == "normal":
            return f"normal, around {shown[0]}, standard deviation {shown[1]}{spaced}"
        return f"from {shown[0]} to {shown[1]}{spaced}"


def grid_size(distributions: Sequence[Distribution]) -> int:
    """Number of points of the grid."""
    return math.prod(len(each.numbers) for each in distributions)


def sample_points(
    distributions: Sequence[Distribution], sample: SampleName, seed: int, block: tuple[int, int]
) -> Array:
    """The points of a study from a first to a last that is left out, Shape (V, P), the same whatever block they are in.

    "grid" takes every combination of levels, the last number varying fastest; "sobol" is a scrambled Sobol sequence
    (`scipy.stats.qmc`), drawn with a seed.
    """
    first, last = block
    if sample == "grid":
        return _grid([np.array(each.levels) for each in distributions], first, last)
    drawn = _sobol(len(distributions), seed, first, last).T
    return np.column_stack([each.at(column) for each, column in zip(distributions, drawn, strict=True)])


def _grid(values: Sequence[Array], first: int, last: int) -> Array:
    """Points of a grid, Shape (V, P); of numpy's index functions none takes more than 64 numbers."""
    left = np.arange(first, last)
    columns = []
    for levels in reversed(values):
        left, place = np.divmod(left, len(levels))
        columns.append(levels[place])
    return np.column_stack(columns[::-1])


def _sobol(numbers: int, seed: int, first: int, last: int) -> Array:
    from scipy.stats import qmc  # noqa: PLC0415 (slow to import)

    engine = qmc.Sobol(numbers, rng=np.random.default_rng(seed))
    if first > 0:
        engine.fast_forward(first)
        return np.asarray(engine.random(last - first))
    start = engine.random(min(last, 1))  # by itself: a first block that is no power of 2 would be warned of
    return np.vstack([start, engine.random(last - 1)]) if last > 1 else np.asarray(start)
