# SPDX-License-Identifier: MIT
"""Samples whose wrenches balance fixes, whole trajectories in one foreign call (mrts/kernel/c/one_unknown)."""

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.cell_library import CellLibrary, SparseLimits, pointers, sample_inputs
from mrts.kernel.foreign_arrays import INFINITY, over_chunks, pointer, work_arrays
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
        each = np.ascontiguousarray(np.minimum(most, INFINITY))
        self._run("mrts_known_ranges", (terms,), (each,), (found.lower, found.upper, found.effect, *tied))
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
        """Call a C function of whole trajectories for all samples, in pieces; False if it met what is no number."""
        opened, record = self.compiled.opened, self.compiled.records[self.function]
        given, strides = sample_inputs(record, self.samples, self.inputs)
        failures = []

        def run(first: int, count: int) -> None:
            work = work_arrays(opened, name, self.limits.rows)
            failed = getattr(opened, name)(
                ctypes.c_longlong(count),
                pointers(given, first, strides),
                strides,
                ctypes.byref(self.limits.structure),
                *(ctypes.byref(added.structure(first)) for added in terms),
                *(pointer(values[first:]) for values in each),
                ctypes.cast(getattr(opened, record.symbol), ctypes.c_void_p),
                len(given),
                *(pointer(output[first:]) for output in outputs),
                *(pointer(array) for array in work),
            )
            failures.append(failed)

        if self.samples <= ONE_PIECE:
            run(0, self.samples)
        else:
            over_chunks(opened, self.samples, run)
        assert 1 not in failures  # noqa: S101 (`SparseLimits` has looked at the limits)
        return not any(failures)


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
    opened, record = compiled.opened, compiled.records[function]
    given, strides = sample_inputs(record, samples, inputs)
    torque, wrench = np.empty((samples, compiled.joints)), np.empty((samples, compiled.wrenches))
    opened.mrts_known_torques(
        ctypes.c_longlong(samples),
        pointers(given),
        strides,
        ctypes.c_double(c2),
        ctypes.cast(getattr(opened, record.symbol), ctypes.c_void_p),
        len(given),
        pointer(torque),
        pointer(wrench),
    )
    return torque, wrench
