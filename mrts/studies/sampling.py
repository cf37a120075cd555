# SPDX-License-Identifier: MIT
"""Which points a study looks at: a grid, a Latin hypercube, or a Sobol sequence; any block of them by itself."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.studies.distributions import Distribution

SampleName = Literal["grid", "lhs", "sobol"]

MAX_VARIANTS = 100_000_000
"""At a thousand a second and core a day of one core."""

MAX_STEPS = 100_000
"""Of one number in a grid."""

MAX_HYPERCUBE_NUMBERS = 20_000_000
"""Of a Latin hypercube, which is drawn as a whole and kept: 160 MB."""


def grid_size(distributions: Sequence[Distribution]) -> int:
    """Number of points of the grid."""
    return math.prod(len(each.numbers) for each in distributions)


def sample_points(
    distributions: Sequence[Distribution], sample: SampleName, count: int, seed: int, block: tuple[int, int]
) -> Array:
    """A block of the points of a study, the same whatever block they are asked for in.

    Args:
        distributions: Of the P numbers; those of a grid have levels.
        sample: "grid" takes every combination, the last number varying fastest; "lhs" is a Latin hypercube, "sobol" a
            scrambled Sobol sequence (`scipy.stats.qmc`).
        count: Number of all points.
        seed: Of what is drawn.
        block: The first point, and the first that is left out.

    Returns:
        Shape (V, P).
    """
    first, last = block
    if sample == "grid":
        return _grid([np.array(each.levels) for each in distributions], first, last)
    if sample == "lhs":
        drawn = _hypercube(len(distributions), count, seed)[:, first:last]
    else:
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


@lru_cache(maxsize=1)
def _hypercube(numbers: int, count: int, seed: int) -> Array:
    """Probabilities of a Latin hypercube, Shape (numbers, count): one in each of `count` equal parts of [0, 1].

    Its columns are independent of one another by definition, so each is drawn by itself, and another one changes none.
    """
    from scipy.stats import qmc  # noqa: PLC0415 (slow to import)

    cube = np.empty((numbers, count))
    for number, column in enumerate(cube):
        column[:] = qmc.LatinHypercube(1, rng=np.random.default_rng([seed, number])).random(count)[:, 0]
    return cube


def _sobol(numbers: int, seed: int, first: int, last: int) -> Array:
    from scipy.stats import qmc  # noqa: PLC0415 (slow to import)

    engine = qmc.Sobol(numbers, rng=np.random.default_rng(seed))
    if first > 0:
        engine.fast_forward(first)
        return np.asarray(engine.random(last - first))
    start = engine.random(min(last, 1))  # by itself: a first block that is no power of 2 would be warned of
    return np.vstack([start, engine.random(last - 1)]) if last > 1 else np.asarray(start)
