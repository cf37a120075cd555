# SPDX-License-Identifier: MIT
"""Which points a study looks at: a grid, or a Sobol sequence; any block of them by itself."""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.studies.distributions import Distribution

SampleName = Literal["grid", "sobol"]

MAX_VARIANTS = 100_000_000
"""At a thousand a second and core a day of one core."""

MAX_STEPS = 100_000
"""Of one number in a grid."""


def grid_size(distributions: Sequence[Distribution]) -> int:
    """Number of points of the grid."""
    return math.prod(len(each.numbers) for each in distributions)


def sample_points(
    distributions: Sequence[Distribution], sample: SampleName, seed: int, block: tuple[int, int]
) -> Array:
    """A block of the points of a study, the same whatever block they are asked for in.

    Args:
        distributions: Of the P numbers; those of a grid have levels.
        sample: "grid" takes every combination, the last number varying fastest; "sobol" is a scrambled Sobol sequence
            (`scipy.stats.qmc`).
        seed: Of what is drawn.
        block: The first point, and the first that is left out.

    Returns:
        Shape (V, P).
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
