# SPDX-License-Identifier: MIT
"""Many variants of a cell along their paths in one foreign call.

Inverse kinematics (c/tracking.c), how far given joints are off (c/arm_tips.c), ranges of c² (c/trajectory.c).
"""

from collections.abc import Mapping, Sequence
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.binding import INFINITY, structure, work_arrays
from mrts.kernel.cell_library import CellLibrary, pointers, sample_inputs

FOLLOWED, NO_START, START_PAST, OUT_OF_REACH, LOST, FOLDED, SINGULAR, PAST_LIMIT, LEFT_LIMITS, REFUSED = range(10)
"""How following ends for an arm, as in tracking.c."""

OUTCOME = np.dtype(structure("tracking.c", "mrts_outcome"))

PATH = {"time": (), "position": (3,), "rotation": (3, 3), "twist": (6,), "acceleration": (6,)}
"""What is known of the object at each sample, and its shape there."""

CLOSURE_SIZES = 6
"""Numbers of each arm, `MRTS_CLOSURE_SIZES` of arm_tips.c."""

TRACKING, PREFERENCE = (structure("tracking.c", f"mrts_{name}") for name in ("tracking", "preference"))


def follow_variants(
    library: CellLibrary, rule: Any, refused: NDArray[np.bool_], given: Mapping[str, Array], *, held: bool = False
) -> tuple[Array, Array, Array, NDArray[np.void]]:
    """Start poses and joints along the path of V variants, N samples; one motion is one variant.

    Args:
        library: Of the cell, m joints in all.
        rule: How they start and follow, of `TRACKING`.
        refused: Variants that are passed over, Shape (V,).
        given: By name, with V first, or 1 where all share one: the path's `PATH`, with N before the shape of each,
            "geometry", Shape (V, 3 + 24 n + h), "posture", where the search for a start begins, Shape (V, m), and
            maybe "further" (the starts tried after it), Shape (V, F, m).
        held: Whether the postures hold the grasps.

    Returns:
        q, q' and q'', each Shape (V, N, m) [rad or m], of an arm that fails what was found before; and how each ends
        for each arm, Shape (V, n) of `OUTCOME`.
    """
    variants, samples, m = len(refused), given["time"].shape[1], library.joints
    shapes = {name: (samples, *shape) for name, shape in PATH.items()}
    shapes |= {name: given[name].shape[1:] for name in ("geometry", "posture", "further") if name in given}
    arrays, strides = strided(variants, shapes, given)
    further = -1 if held else shapes.get("further", (0,))[0]
    q, dq, ddq = np.zeros((3, variants, samples, m))
    outcome = np.zeros((variants, library.robots), dtype=OUTCOME)
    outcome["code"][refused] = REFUSED
    library.following.mrts_follow(variants, samples, rule, further, arrays, strides, q, dq, ddq, outcome)
    return q, dq, ddq, outcome


def strided(count: int, shapes: Mapping[str, tuple[int, ...]], given: Mapping[str, Array]) -> tuple[Any, list[int]]:
    """`pointers` to arrays of many variants, and how many reals apart these lie in each (0: the one for all)."""
    arrays, strides = list[Array](), list[int]()
    for name, shape in shapes.items():
        array = np.ascontiguousarray(given[name], dtype=np.float64)
        if array.shape not in {(1, *shape), (count, *shape)}:
            raise ValueError(f"{name} has Shape {array.shape}, not {(count, *shape)}")
        arrays.append(array)
        strides.append(0 if len(array) == 1 else prod(shape))
    return pointers(arrays), strides


def closure_sizes(
    library: CellLibrary, inputs: dict[str, Array], position: Array, geometry: Array, components: Sequence[int]
) -> Array:
    """How far given joints are from holding an object at a position, Shape (N, 3) [m].

    Inputs are those of the wrench form; components, those of a twist that a wrench of the cell has.

    Returns:
        The largest of all samples for each arm, infinity for what is no number, Shape (6, n): distance between tip and
        grasp [m]; angle [rad]; of the velocities of tip and grasp in base axes the largest component, and the largest
        of their difference [m/s, rad/s]; the same two of accelerations.
    """
    samples = len(position)
    given, strides = sample_inputs(library.records["wrench_form"], samples, inputs)
    most = np.zeros((library.robots, CLOSURE_SIZES))
    library.opened.mrts_closure(samples, given, strides, position, geometry, [*components], most)
    apart, turned, *rates = most.T
    # |R - S|² of two rotations is 8 sin² of half the angle between them
    return np.array([np.sqrt(apart), 2 * np.arcsin(np.minimum(np.sqrt(turned / 8), 1.0)), *rates])


NAMED = 4
"""Most rows that are named at an end, as a multiple of the unknowns: `MRTS_MOST_NAMED` of trajectory.c."""


def variant_range_record(unknowns: int) -> np.dtype[np.void]:
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
    """The range of c² over the whole motion of each variant that followed, Shape (V,) of `variant_range_record`.

    Args:
        library: Of the cell.
        joints: q, q' and q'' along the motion, each Shape (V, N, m).
        skipped: Variants that did not follow, Shape (V,).
        limits: The rows as C reads them; which limits there are is the same for all variants.
        given: By name, with V first, or 1 where all share one: the path's "rotation", "twist" and "acceleration" as in
            `follow_variants`, "load", Shape (V, 10), "geometry" as there, "most", the largest
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
    found = np.zeros(variants, dtype=variant_range_record(library.unknowns))
    library.opened.mrts_variant_ranges(
        *(variants, samples, arrays, strides, limits, skipped, found),
        *work_arrays(library.opened, "mrts_variant_ranges", limits.rows, samples),
    )
    return found
