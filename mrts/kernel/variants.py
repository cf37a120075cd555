# SPDX-License-Identifier: MIT
"""Many variants of one cell along its motion in two foreign calls (mrts/kernel/c/variants)."""

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.cell_library import CellLibrary, SparseLimits
from mrts.kernel.foreign_arrays import INFINITY, pointer, work_arrays
from mrts.kernel.sample_terms import SampleTerms
from mrts.kernel.tracking import GraspTask, TrackingStructure

FOLLOWED, NO_START, START_PAST, OUT_OF_REACH, LOST, PAST_LIMIT, UNSETTLED, REFUSED = range(8)
"""How following a variant ends, as in variants.h."""

OUTCOME = np.dtype(
    [(name, np.int32) for name in ("code", "robot", "sample", "joint")] + [("amount", np.float64, (2,))], align=True
)
"""`mrts_outcome` of variants.h."""

NAMED = 4
"""Most rows that are named at an end, as a multiple of the unknowns: `MRTS_MOST_NAMED` of ranges.c."""

PATH = {"time": (), "position": (3,), "rotation": (3, 3), "twist": (6,), "acceleration": (6,)}
"""What is known of the object at each sample, and its shape there."""


class _Following(ctypes.Structure):
    """`mrts_following` of variants.h."""

    _fields_ = [
        ("task", TrackingStructure),
        ("start_steps", ctypes.c_int),
        ("further", ctypes.c_int),
        ("further_steps", ctypes.c_int),
        ("jump", ctypes.c_double),
        ("drift", ctypes.c_double),
        ("fold", ctypes.c_double),
        ("past", ctypes.c_double),
        ("turns", ctypes.c_void_p),
    ]


@dataclass(frozen=True, kw_only=True)
class FollowingRule:
    """How variants start and follow, and what counts as failed.

    Attributes:
        task: How grasps are held at a sample; its geometry is not used.
        start_steps: Most Newton steps from the posture to the grasp at the first sample.
        further_steps: Most steps from each further start.
        jump: Correction of a predicted joint at which an arm has lost its branch [rad or m].
        drift: Step left to a redundant arm that is not settled [rad or m].
        fold: Curvature at which its positions end.
        past: How far a joint may pass its limit [rad or m].
        turns: Whether whole turns of a joint are the same position, Shape (m,).
    """

    task: GraspTask
    start_steps: int
    further_steps: int
    jump: float
    drift: float
    fold: float
    past: float
    turns: NDArray[np.bool_]


@dataclass(frozen=True)
class FollowedVariants:
    """Joints of V variants along a path of N samples, m in all.

    Attributes:
        q: Shape (V, N, m) [rad or m]; likewise `dq` and `ddq`. Of a variant that fails, what was found before.
        dq: q'.
        ddq: q''.
        outcome: How each ends, Shape (V,) of `OUTCOME`.
    """

    q: Array
    dq: Array
    ddq: Array
    outcome: NDArray[np.void]

    def parts(self) -> tuple[NDArray[Any], ...]:
        """All arrays."""
        return self.q, self.dq, self.ddq, self.outcome


def follow_variants(
    library: CellLibrary, rule: FollowingRule, refused: NDArray[np.bool_], given: Mapping[str, Array]
) -> FollowedVariants:
    """Start poses and joints along the path of many variants.

    Args:
        library: Of the cell.
        rule: How they start and follow.
        refused: Variants that are passed over, Shape (V,).
        given: By name, with V first, or 1 where all share one: the path's `PATH`, with N before the shape of each,
            "geometry", Shape (V, 3 + 24 n + h), "posture" and "seed" (where the search for a start begins), Shape
            (V, m), and "further" (the starts tried after it), Shape (V, F, m).
    """
    variants, samples, m = len(refused), given["time"].shape[1], library.joints
    shapes = {name: (samples, *shape) for name, shape in PATH.items()} | {
        "geometry": given["geometry"].shape[-1:],
        "posture": (m,),
        "seed": (m,),
        "further": given["further"].shape[-2:],
    }
    arrays, strides = _strided(variants, shapes, given)
    turns = np.ascontiguousarray(rule.turns, dtype=np.uint8)
    further = shapes["further"][0]
    structure = _Following(
        *(rule.task.structure, rule.start_steps, further, rule.further_steps, rule.jump, rule.drift, rule.fold),
        *(rule.past, pointer(turns)),
    )
    q, dq, ddq = (np.zeros((variants, samples, m)) for _ in range(3))
    outcome = np.zeros(variants, dtype=OUTCOME)
    outcome["code"][refused] = REFUSED
    library.opened.mrts_follow_variants(
        ctypes.c_longlong(variants),
        ctypes.c_longlong(samples),
        ctypes.byref(structure),
        _addresses(arrays),
        strides,
        *(pointer(array) for array in (q, dq, ddq, outcome)),
    )
    return FollowedVariants(q, dq, ddq, outcome)


def range_record(unknowns: int) -> np.dtype[np.void]:
    """`mrts_variant_range` of ranges.c for so many unknowns, c² last.

    Of a variant with `status` `OPTIMAL` both ends are known; one with `INFEASIBLE` is so at `sample[0]`, and `rows[0]`
    are those that conflict. Rows are 1 + row at an upper, -1 - row at a lower limit; `count` of them set each end.
    """
    return np.dtype(
        [
            ("status", np.int32),
            ("capped", np.int32),
            ("sample", np.int32, (2,)),
            ("count", np.int32, (2,)),
            ("rows", np.int32, (2, NAMED * unknowns)),
            ("c2", np.float64, (2,)),
        ],
        align=True,
    )


def variant_ranges(
    library: CellLibrary,
    followed: FollowedVariants,
    limits: SparseLimits,
    terms: SampleTerms,
    order: NDArray[np.intp],
    given: Mapping[str, Array],
) -> NDArray[np.void]:
    """The range of c² over the whole motion of each variant that followed, Shape (V,) of `range_record`.

    Args:
        library: Of the cell.
        followed: The joints.
        limits: Rows over torques and wrenches; which limits there are is the same for all variants.
        terms: What is added at every sample, those of all variants one after the other.
        order: In which the samples are looked at, Shape (N,): those that may set the range first.
        given: By name, with V first, or 1 where all share one: the path's "rotation", "twist" and "acceleration" as in
            `follow_variants`, "load", Shape (V, 10), "geometry" as there, "velocity", limits of the joints and of the
            object's linear and angular one, infinity where there is none, Shape (V, m + 2), "lower" and "upper" limits
            of the rows, Shape (V, r), and what the rows are made of, `SparseLimits.values`, Shape (V, e).
    """
    variants, samples, m = followed.q.shape
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(("q", "dq", "ddq"), (samples, m))
    shapes |= {name: (samples, *PATH[name]) for name in ("rotation", "twist", "acceleration")}
    shapes |= {"load": (10,), "geometry": given["geometry"].shape[-1:], "velocity": (m + 2,)}
    shapes |= {"lower": (limits.rows,), "upper": (limits.rows,), "values": limits.values.shape}
    joints = {"q": followed.q, "dq": followed.dq, "ddq": followed.ddq}
    bounds = {name: np.clip(given[name], -INFINITY, INFINITY) for name in ("velocity", "lower", "upper")}
    arrays, strides = _strided(variants, shapes, {**given, **joints, **bounds})
    first = np.ascontiguousarray(order, dtype=np.int32)
    skipped = np.ascontiguousarray(followed.outcome["code"] != FOLLOWED, dtype=np.uint8)
    found = np.zeros(variants, dtype=range_record(library.unknowns))
    work = work_arrays(library.opened, "mrts_variant_ranges", limits.rows, samples)
    library.opened.mrts_variant_ranges(
        ctypes.c_longlong(variants),
        ctypes.c_longlong(samples),
        _addresses(arrays),
        strides,
        ctypes.byref(limits.structure),
        ctypes.byref(terms.structure()),
        *(pointer(array) for array in (first, skipped, found)),
        *(pointer(array) for array in work),
    )
    return found


def _strided(
    variants: int, shapes: Mapping[str, tuple[int, ...]], given: Mapping[str, Array]
) -> tuple[list[Array], Any]:
    """Arrays as C reads them, and how many reals apart variants lie in each (0: the one for all).

    Raises:
        ValueError: If an array has another shape: the C would read past its end.
    """
    arrays, strides = [], []
    for name, shape in shapes.items():
        array = np.ascontiguousarray(given[name], dtype=np.float64)
        if array.shape not in {(1, *shape), (variants, *shape)}:
            raise ValueError(f"{name} has Shape {array.shape}, not {(variants, *shape)}")
        arrays.append(array)
        strides.append(0 if len(array) == 1 else int(np.prod(shape)))
    return arrays, (ctypes.c_longlong * len(strides))(*strides)


def _addresses(arrays: list[Array]) -> Any:
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
