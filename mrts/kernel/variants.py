# SPDX-License-Identifier: MIT
"""Ranges of c² of many variants of one cell along its motion, one foreign call (mrts/kernel/c/trajectory.c)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.binding import INFINITY, structure, work_arrays
from mrts.kernel.cell_library import CellLibrary
from mrts.kernel.tracking import PATH, strided

NAMED = 4
"""Most rows that are named at an end, as a multiple of the unknowns: `MRTS_MOST_NAMED` of trajectory.c."""


def range_record(unknowns: int) -> np.dtype[np.void]:
    """`mrts_variant_range` of trajectory.c for so many unknowns, c² last.

    Of a variant with `status` `OPTIMAL` both ends are known; one with `INFEASIBLE` is so at `sample[0]`, and `rows[0]`
    are those that conflict. Rows are 1 + row at an upper, -1 - row at a lower limit; `count` of them set each end.
    """
    record = structure("trajectory.c", "mrts_variant_range", MRTS_MOST_NAMED=NAMED * unknowns)
    made: np.dtype[np.void] = np.dtype(record)
    return made


def variant_ranges(
    library: CellLibrary,
    joints: tuple[Array, Array, Array],
    skipped: NDArray[np.bool_],
    limits: Any,
    given: Mapping[str, Array],
) -> NDArray[np.void]:
    """The range of c² over the whole motion of each variant that followed, Shape (V,) of `range_record`.

    Args:
        library: Of the cell.
        joints: q, q' and q'' along the motion, each Shape (V, N, m).
        skipped: Variants that did not follow, Shape (V,).
        limits: The rows as C reads them; which limits there are is the same for all variants.
        given: By name, with V first, or 1 where all share one: the path's "rotation", "twist" and "acceleration" as in
            `mrts.kernel.tracking.follow_variants`, "load", Shape (V, 10), "geometry" as there, "most", the largest
            c² by limits of the motion alone, infinity where there is none, Shape (V, N), "lower" and "upper" limits of
            the rows, Shape (V, r), and what the rows are made of, their entries, Shape (V, e).
    """
    variants, samples, m = joints[0].shape
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(("q", "dq", "ddq"), (samples, m))
    shapes |= {name: (samples, *PATH[name]) for name in ("rotation", "twist", "acceleration")}
    shapes |= {"load": (10,), "geometry": given["geometry"].shape[-1:], "most": (samples,)}
    shapes |= {"lower": (limits.rows,), "upper": (limits.rows,), "values": given["values"].shape[-1:]}
    bounds = {name: np.clip(given[name], -INFINITY, INFINITY) for name in ("most", "lower", "upper")}
    followed = dict(zip(("q", "dq", "ddq"), joints, strict=True))
    arrays, strides = strided(variants, shapes, {**given, **followed, **bounds})
    found = np.zeros(variants, dtype=range_record(library.unknowns))
    library.opened.mrts_variant_ranges(
        *(variants, samples, arrays, strides, limits, skipped, found),
        *work_arrays(library.opened, "mrts_variant_ranges", limits.rows, samples),
    )
    return found
