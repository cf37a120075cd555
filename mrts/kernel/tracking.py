# SPDX-License-Identifier: MIT
"""Inverse kinematics along a path, and how far given joints are from it, each one foreign call to kernel/c/tracking."""

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.kernel.cell_library import CellLibrary, pointers, sample_inputs
from mrts.kernel.foreign_arrays import over_chunks, pointer

HELD = ("gap", "turn", "jump", "condition", "drift", "curvature")
"""What is told of each robot at a sample: `mrts_held` of tracking.h."""

CLOSURE_SIZES = 6
"""Numbers of each arm, `MRTS_CLOSURE_SIZES` of closure.c."""


class _Preference(ctypes.Structure):
    """`mrts_preference` of null_space.h."""

    _fields_ = [
        ("lower", ctypes.c_void_p),
        ("upper", ctypes.c_void_p),
        ("zone", ctypes.c_void_p),
        ("push", ctypes.c_double),
    ]


@dataclass(frozen=True)
class NewtonRule:
    """How the iteration at a sample goes.

    Attributes:
        steps: Most steps.
        settled: Joint step at which it ends [rad or m].
        longest: Largest joint step [rad or m].
        reached: Remaining error at which a grasp counts as held [m, rad].
        condition: Of a Jacobian, at which an arm may be singular.
    """

    steps: int
    settled: float
    longest: float
    reached: float
    condition: float


class TrackingStructure(ctypes.Structure):
    """`mrts_tracking` of tracking.h."""

    _fields_ = [
        ("steps", ctypes.c_int),
        ("settled", ctypes.c_double),
        ("longest", ctypes.c_double),
        ("reached", ctypes.c_double),
        ("condition", ctypes.c_double),
        ("components", ctypes.c_int * 6),
        ("wish", _Preference),
        ("geometry", ctypes.c_void_p),
    ]


class GraspTask:
    """What the n arms of a cell, m joints in all, are to hold, and how: the same at every sample.

    Args:
        newton: How the iteration at a sample goes.
        components: Rows of a six-component twist that the cell uses.
        geometry: Of the cell, Shape (3 + 24 n + h,).
        lower: Least joint positions, minus infinity where there is none, Shape (m,) [rad or m].
        upper: Largest ones, Shape (m,).
        zone: Widths of the zones beside them, Shape (m,).
        push: What h adds at a limit [rad or m], see `mrts.inverse_kinematics.null_space`.
    """

    def __init__(
        self,
        *,
        newton: NewtonRule,
        components: Sequence[int],
        geometry: Array,
        lower: Array,
        upper: Array,
        zone: Array,
        push: float,
    ) -> None:
        self._arrays = [np.ascontiguousarray(array) for array in (lower, upper, zone, geometry)]
        *limits, place = (pointer(array) for array in self._arrays)
        used = (ctypes.c_int * 6)(*components)
        wish = _Preference(*limits, push)
        self.structure = TrackingStructure(
            steps=newton.steps,
            settled=newton.settled,
            longest=newton.longest,
            reached=newton.reached,
            condition=newton.condition,
            components=used,
            wish=wish,
            geometry=place,
        )


@dataclass(frozen=True)
class TrackedJoints:
    """Joints along a path of N samples, n robots.

    Attributes:
        done: How many samples were followed; fewer than N where an arm is singular.
        q: Shape (N, m); likewise `dq` and `ddq`.
        gap: Remaining error of position, or more, Shape (N, n) [m].
        turn: Remaining error of rotation, or more, Shape (N, n) [rad].
        jump: Largest correction of a predicted joint, Shape (N, n) [rad or m].
        condition: At least the condition number of the Jacobian, Shape (N, n).
        drift: Step still to go of a redundant arm, Shape (N, n) [rad or m]; zero for others.
        curvature: Product of the curvatures of H (`mrts.inverse_kinematics.null_space`), Shape (N, n); one for others.
    """

    done: int
    q: Array
    dq: Array
    ddq: Array
    gap: Array
    turn: Array
    jump: Array
    condition: Array
    drift: Array
    curvature: Array


def track_path(library: CellLibrary, task: GraspTask, path: Sequence[Array], start: Array) -> TrackedJoints:
    """Follow the grasps from joint positions that hold them.

    Args:
        library: Of the cell.
        task: What its arms are to hold.
        path: Of the object: time, Shape (N,) [s], position, Shape (N, 3) [m], rotation, Shape (N, 3, 3), twist and
            acceleration, Shape (N, 6).
        start: Positions at the first sample, Shape (m,) [rad or m].
    """
    given = [np.ascontiguousarray(part) for part in path]
    samples = len(given[0])
    q, dq, ddq = (np.zeros((samples, len(start))) for _ in range(3))
    held = np.zeros((samples, len(HELD), library.robots))
    q[0] = start
    run = library.opened.mrts_track
    run.restype = ctypes.c_longlong
    done = run(
        ctypes.c_longlong(samples),
        ctypes.byref(task.structure),
        *(pointer(array) for array in (*given, q, dq, ddq, held)),
    )
    return TrackedJoints(int(done), q, dq, ddq, **dict(zip(HELD, held.swapaxes(0, 1), strict=True)))


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
    taken = np.array(components, dtype=np.int32)
    found: list[Array] = []

    def run(first: int, count: int) -> None:
        most = np.zeros((library.robots, CLOSURE_SIZES))
        library.opened.mrts_closure(
            ctypes.c_longlong(count),
            pointers(given, first, strides),
            strides,
            *(pointer(array) for array in (at[first:], placed, taken, most)),
        )
        found.append(most)

    over_chunks(library.opened, samples, run)
    apart, turned, *rates = np.max(found, axis=0).T
    # |R - S|² of two rotations is 8 sin² of half the angle between them
    return ClosureSizes(np.sqrt(apart), 2 * np.arcsin(np.minimum(np.sqrt(turned / 8), 1.0)), *rates)
