# SPDX-License-Identifier: MIT
"""Samples whose wrenches balance fixes, whole trajectories in one foreign call (mrts/kernel/c/one_unknown)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.cell_library import CellLibrary, SparseLimits
from mrts.kernel.foreign_arrays import INFINITY
from mrts.kernel.sample_terms import SampleTerms

ONE_PIECE = 16_384
"""Samples up to which one thread takes them all: a few milliseconds' work, for which starting another does not pay."""


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


@dataclass(frozen=True)
class KnownPlanes:
    """Half-planes n_u u + n_x x <= h at N samples, e of each, in units of limits.

    Attributes:
        planes: n_u, n_x, h, Shape (N, e, 3).
        effect: Largest effect of u = 1 and of x = 1 on a row, Shape (N, 2).
    """

    planes: Array
    effect: Array


@dataclass(frozen=True)
class KnownWrenches:
    """A cell's samples whose wrenches are known but for c², or for u = r̈ and x = ṙ².

    Attributes:
        compiled: The cell's library.
        function: Short name of the generated function that gives torques and wrenches.
        samples: N.
        inputs: Of the function, by name.
        limits: Rows over torques and wrenches.
    """

    compiled: CellLibrary
    function: str
    samples: int
    inputs: dict[str, Array]
    limits: SparseLimits

    def ranges(self, terms: SampleTerms, most: Array) -> KnownRanges:
        """Least and largest c² at every sample.

        Args:
            terms: What is added at every sample.
            most: Largest c² that the velocities allow, Shape (N,), infinity where they do not bound it.
        """
        N, rows = self.samples, self.limits.rows
        tied = np.zeros((2, N, rows), dtype=np.int8)
        found = KnownRanges(np.zeros(N), np.zeros(N), np.zeros(N), tied)
        self._run(
            "mrts_known_ranges",
            (terms,),
            (np.minimum(most, INFINITY),),
            (found.lower, found.upper, found.effect, *tied),
        )
        return found

    def planes(self, terms: SampleTerms, rate_terms: SampleTerms) -> KnownPlanes | None:
        """The rows over u and x, those of their sides that have a limit; None where a coefficient is no number.

        Args:
            terms: What is added at every sample, with x for c².
            rate_terms: What u adds, likewise.
        """
        found = KnownPlanes(np.empty((self.samples, self.limits.sides, 3)), np.empty((self.samples, 2)))
        numbers = self._run("mrts_known_planes", (terms, rate_terms), (), (found.effect, found.planes))
        return found if numbers else None

    def _run(
        self, name: str, terms: Sequence[SampleTerms], each: Sequence[Array], outputs: Sequence[NDArray[Any]]
    ) -> bool:
        of = self.compiled
        run = of.address(self.function), len(of.records[self.function].inputs)
        return of.over_samples(
            *(name, self.samples, self.inputs, self.limits, terms, each, outputs, run),
            function=self.function,
            one_piece=ONE_PIECE,
        )


def known_values(
    compiled: CellLibrary, function: str, samples: int, inputs: dict[str, Array], c2: float
) -> tuple[Array, Array]:
    """Torques, Shape (N, m), without what motors give, and wrenches, Shape (N, n w), at a c².

    Args:
        compiled: The cell's library.
        function: As in `KnownWrenches`.
        samples: N.
        inputs: Of the function, by name.
        c2: One for all samples.
    """
    torque_map, torque, wrench_map, wrench = compiled.map(function, samples, inputs).values()
    return torque_map * c2 + torque, wrench_map * c2 + wrench
