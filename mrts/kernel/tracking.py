# SPDX-License-Identifier: MIT
"""Inverse kinematics of many variants along their paths, and how far given joints are off (kernel/c/tracking)."""

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.binding import structure
from mrts.kernel.cell_library import CellLibrary, MotionLibrary, pointers, sample_inputs

FOLLOWED, NO_START, START_PAST, OUT_OF_REACH, LOST, FOLDED, SINGULAR, PAST_LIMIT, LEFT_LIMITS, REFUSED = range(10)
"""How following ends for an arm, as in follow.h."""

OUTCOME = np.dtype(structure("tracking/follow.h", "mrts_outcome"))

PATH = {"time": (), "position": (3,), "rotation": (3, 3), "twist": (6,), "acceleration": (6,)}
"""What is known of the object at each sample, and its shape there."""

NUMBERS = ("settled", "longest", "reached", "condition", "jump", "drift", "fold")
"""Of a `TrackingRule`, which C takes as they are."""

CLOSURE_SIZES = 6
"""Numbers of each arm, `MRTS_CLOSURE_SIZES` of closure.c."""


FOLLOWING, TRACKING, PREFERENCE = (
    structure("tracking/follow.h", f"mrts_{name}") for name in ("following", "tracking", "preference")
)


@dataclass(frozen=True, kw_only=True)
class TrackingRule:
    """How the arms of a cell, m joints in all, hold their grasps, and what counts as failed.

    Attributes:
        steps: Most Newton steps at a sample.
        start_steps: The same from a seed to the grasp at the first sample.
        further_steps: The same from each further start.
        settled: Joint step at which the iteration ends [rad or m].
        longest: Largest joint step [rad or m].
        reached: Remaining error at which a grasp counts as held [m, rad].
        condition: Of a Jacobian, at which an arm is singular.
        jump: Correction of a predicted joint at which an arm has lost its branch [rad or m].
        drift: Step left to a redundant arm that is not settled [rad or m].
        fold: Curvature at which its positions end (`mrts.following.null_space`).
        past: How far a joint may pass its limit [rad or m].
        push: What h adds at a limit [rad or m].
        components: Rows of a six-component twist that the cell uses.
        lower: Least joint positions, minus infinity where there is none, Shape (m,) [rad or m].
        upper: Largest ones, Shape (m,).
        zone: Widths of the zones beside them, Shape (m,).
        turns: Whether whole turns of a joint are the same position, Shape (m,).
    """

    steps: int
    start_steps: int
    further_steps: int
    settled: float
    longest: float
    reached: float
    condition: float
    jump: float
    drift: float
    fold: float
    past: float
    push: float
    components: Sequence[int]
    lower: Array
    upper: Array
    zone: Array
    turns: NDArray[np.bool_]

    def structure(self, steps: int, geometry: Array | None = None) -> Any:
        """As C reads it, which keeps none of the arrays alive."""
        return TRACKING(
            steps=steps,
            components=(ctypes.c_int * 6)(*self.components),
            wish=PREFERENCE(*(array.ctypes.data for array in (self.lower, self.upper, self.zone)), self.push),
            geometry=None if geometry is None else geometry.ctypes.data,
            **{name: getattr(self, name) for name in NUMBERS},
        )


@dataclass(frozen=True)
class FollowedVariants:
    """Joints of V variants along a path of N samples, m in all.

    Attributes:
        q: Shape (V, N, m) [rad or m]; likewise `dq` and `ddq`. Of an arm that fails, what was found before.
        dq: q'.
        ddq: q''.
        outcome: How each ends for each arm, Shape (V, n) of `OUTCOME`.
    """

    q: Array
    dq: Array
    ddq: Array
    outcome: NDArray[np.void]

    def parts(self) -> tuple[NDArray[Any], ...]:
        """All arrays."""
        return self.q, self.dq, self.ddq, self.outcome

    @property
    def followed(self) -> NDArray[np.bool_]:
        """Variants that all arms followed, Shape (V,)."""
        done: NDArray[np.bool_] = np.all(self.outcome["code"] == FOLLOWED, axis=1)
        return done


def follow_variants(
    library: MotionLibrary, rule: TrackingRule, refused: NDArray[np.bool_], given: Mapping[str, Array]
) -> FollowedVariants:
    """Start poses and joints along the path of many variants; one motion is one variant.

    Args:
        library: Of the cell.
        rule: How they start and follow; without steps to a start, the seeds hold the grasps.
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
    arrays, strides = strided(variants, shapes, given)
    further = shapes["further"][0]
    task, turns = rule.structure(rule.steps), rule.turns.ctypes.data
    following = FOLLOWING(task, rule.start_steps, further, rule.further_steps, rule.past, turns)
    q, dq, ddq = (np.zeros((variants, samples, m)) for _ in range(3))
    outcome = np.zeros((variants, library.robots), dtype=OUTCOME)
    outcome["code"][refused] = REFUSED
    library.opened.mrts_follow(variants, samples, following, pointers(arrays), strides, q, dq, ddq, outcome)
    return FollowedVariants(q, dq, ddq, outcome)


@dataclass(frozen=True)
class HeldGrasps:
    """Joint positions that hold the grasps at one sample each, as well as T starts led to.

    Attributes:
        q: Those with the smallest errors met; of those without, the most settled in the null space, Shape (T, m)
            [rad or m].
        gap: Error of position, Shape (T, n) [m].
        turn: Error of rotation, Shape (T, n) [rad].
        drift: Step still to go in the null space, Shape (T, n) [rad or m]; zero for an arm that has none.
    """

    q: Array
    gap: Array
    turn: Array
    drift: Array


def hold_grasps(
    library: MotionLibrary, rule: TrackingRule, steps: int, start: Array, given: Mapping[str, Array], geometry: Array
) -> HeldGrasps:
    """Damped Newton steps (Sugihara 2011) from T starts, at one sample each.

    Args:
        library: Of the cell.
        rule: How they hold.
        steps: Most to take.
        start: Shape (T, m) [rad or m].
        given: By name, with T first, or 1 where all share one: "position" and "rotation" of the object, and
            "reference", the positions that redundant arms stay near, Shape (T, m); without it they move no further
            than needed.
        geometry: Of the cell.
    """
    count, m = start.shape
    shapes = {"position": (3,), "rotation": (3, 3), "reference": (m,)}
    arrays, strides = strided(count, shapes, {"reference": start, **given})
    places = pointers(arrays)
    if "reference" not in given:
        places[2] = None
    q, at = np.array(start, dtype=np.float64), np.ascontiguousarray(geometry)
    sizes = [np.zeros((count, library.robots)) for _ in range(3)]
    library.opened.mrts_hold(count, rule.structure(steps, at), places, strides, q, *sizes)
    return HeldGrasps(q, *sizes)


def strided(count: int, shapes: Mapping[str, tuple[int, ...]], given: Mapping[str, Array]) -> tuple[list[Array], Any]:
    """Arrays of many variants as C reads them, and how many reals apart they lie in each (0: the one for all).

    Raises:
        ValueError: If an array has another shape: the C would read past its end.
    """
    arrays, strides = [], []
    for name, shape in shapes.items():
        array = np.ascontiguousarray(given[name], dtype=np.float64)
        if array.shape not in {(1, *shape), (count, *shape)}:
            raise ValueError(f"{name} has Shape {array.shape}, not {(count, *shape)}")
        arrays.append(array)
        strides.append(0 if len(array) == 1 else int(np.prod(shape)))
    return arrays, (ctypes.c_longlong * len(strides))(*strides)


@dataclass(frozen=True)
class ClosureSizes:
    """How far n arms are off their grasps, the largest of all samples, each Shape (n,); infinity for what is no number.

    Attributes:
        distance: Between tip and grasp [m].
        angle: Between them [rad].
        velocity: Largest component of velocities, of tip or grasp, in base axes [m/s, rad/s].
        slip: The same of their differences.
        acceleration: As `velocity`, of accelerations [m/s², rad/s²].
        acceleration_slip: The same of their differences.
    """

    distance: Array
    angle: Array
    velocity: Array
    slip: Array
    acceleration: Array
    acceleration_slip: Array


def closure_sizes(
    library: CellLibrary, inputs: dict[str, Array], position: Array, geometry: Array, components: Sequence[int]
) -> ClosureSizes:
    """How far given joints are from holding an object.

    Args:
        library: Of the cell.
        inputs: Of the wrench form at N samples, by name.
        position: Of the object, Shape (N, 3) [m].
        geometry: Of the cell.
        components: Those of a twist that a wrench of the cell has.
    """
    samples = len(position)
    given, strides = sample_inputs(library.records["wrench_form"], samples, inputs)
    at, placed = np.ascontiguousarray(position), np.ascontiguousarray(geometry)
    taken, most = np.array(components, dtype=np.int32), np.zeros((library.robots, CLOSURE_SIZES))
    library.opened.mrts_closure(samples, pointers(given), strides, at, placed, taken, most)
    apart, turned, *rates = most.T
    # |R - S|² of two rotations is 8 sin² of half the angle between them
    return ClosureSizes(np.sqrt(apart), 2 * np.arcsin(np.minimum(np.sqrt(turned / 8), 1.0)), *rates)
