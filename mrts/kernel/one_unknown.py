# SPDX-License-Identifier: MIT
"""Samples whose wrenches balance fixes, whole trajectories in one foreign call (mrts/kernel/c/one_unknown)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.cell_library import CellLibrary, SparseLimits
from mrts.kernel.foreign_arrays import INFINITY
from mrts.kernel.sample_terms import SampleTerms


@dataclass(frozen=True)
class KnownRanges:
    """What the kernel found at N samples of r rows.

    Attributes:
        lower: c²⁻(t), Shape (N,); above `upper` where no c² keeps all rows.
        upper: c²⁺(t), Shape (N,), infinity where nothing bounds it.
        effect: Largest effect of c² = 1 on a row in its unit, Shape (N,).
        tied: Rows that tie at each end, 1 at their upper and -1 at their lower limit, Shape (2, N, r); none at 0.
    """

    lower: Array
    upper: Array
    effect: Array
    tied: NDArray[np.int8]


def known_ranges(
    library: CellLibrary,
    function: str,
    samples: int,
    inputs: dict[str, Array],
    limits: SparseLimits,
    terms: SampleTerms,
    most: Array,
) -> KnownRanges:
    """Least and largest c² at every sample where c² is the only unknown.

    Args:
        library: Of the cell.
        function: Short name of the generated function that gives torques and wrenches.
        samples: N.
        inputs: Of the function, by name.
        limits: Rows over torques and wrenches.
        terms: What is added at every sample.
        most: Largest c² that the velocities allow, Shape (N,), infinity where they do not bound it.
    """
    run = library.address(function), len(library.records[function].inputs)
    tied = np.zeros((2, samples, limits.rows), dtype=np.int8)
    found = KnownRanges(np.zeros(samples), np.zeros(samples), np.zeros(samples), tied)
    each, outputs = [np.minimum(most, INFINITY)], [found.lower, found.upper, found.effect, *tied]
    given = samples, inputs, limits, terms, each, outputs, run
    library.over_samples("mrts_known_ranges", *given, function=function)
    return found
