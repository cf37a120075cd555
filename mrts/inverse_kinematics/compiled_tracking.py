# SPDX-License-Identifier: MIT
"""A cell's grasps followed along a whole path in one foreign call (mrts/kernel/c/tracking.c)."""

import ctypes
from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.inverse_kinematics.null_space import LIMIT_PUSH, limit_zone
from mrts.kernel.compiled_cell import CompiledCell, Scratch
from mrts.kernel.kernel_library import pointer
from mrts.motion.object_motion import ObjectMotion


class _Arm(ctypes.Structure):
    """`mrts_arm` of tracking.c."""

    _fields_ = [
        ("base_rotation", ctypes.c_double * 9),
        ("tip_rotation", ctypes.c_double * 9),
        ("tip_position", ctypes.c_double * 3),
    ]


class _Preference(ctypes.Structure):
    """`mrts_preference` of null_space.c."""

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
    """

    steps: int
    settled: float
    longest: float
    reached: float


@dataclass(frozen=True)
class KernelTrack:
    """Joints along a path of N samples, n robots.

    Attributes:
        done: How many samples were followed; fewer than N where an arm is singular.
        q: Shape (N, m); likewise `dq` and `ddq`.
        gap: Remaining error of position, Shape (N, n) [m].
        turn: Remaining error of rotation, Shape (N, n) [rad].
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


def track_compiled(
    cell: Cell, compiled: CompiledCell, motion: ObjectMotion, start: Array, newton: NewtonRule
) -> KernelTrack:
    """Follow the grasps from joint positions that hold them.

    Args:
        cell: The cell.
        compiled: Its library.
        motion: Motion of the object.
        start: Positions at the first sample, Shape (m,) [rad or m].
        newton: How the iteration goes.
    """
    robots = len(cell.robots)

    class Task(ctypes.Structure):
        """`mrts_tracking` of tracking.c."""

        _fields_ = [
            ("steps", ctypes.c_int),
            ("settled", ctypes.c_double),
            ("longest", ctypes.c_double),
            ("reached", ctypes.c_double),
            ("components", ctypes.c_int * 6),
            ("wish", _Preference),
            ("arm", _Arm * robots),
        ]

    limits = [
        np.concatenate([of_arm(robot) for robot in cell.robots])
        for of_arm in (lambda robot: robot.position_lower, lambda robot: robot.position_upper, limit_zone)
    ]
    wish = _Preference(*(pointer(array) for array in limits), LIMIT_PUSH)
    components = (ctypes.c_int * 6)(*cell.wrench_rows)
    task = Task(newton.steps, newton.settled, newton.longest, newton.reached, components, wish)
    for place, robot in zip(task.arm, cell.robots, strict=True):
        place.base_rotation[:] = robot.T_world_base.R.ravel().tolist()
        place.tip_rotation[:] = robot.T_object_tip.R.ravel().tolist()
        place.tip_position[:] = robot.T_object_tip.p.tolist()
    path = (motion.time, motion.position, motion.rotation, motion.twist, motion.acceleration)
    given = [np.ascontiguousarray(part) for part in path]
    samples = len(motion.time)
    q, dq, ddq = (np.zeros((samples, len(start))) for _ in range(3))
    about = [np.zeros((samples, robots)) for _ in range(6)]
    q[0] = start
    used = ("kinematics", "bias_acceleration", "geometric_stiffness", "geometric_stiffness_rate")
    scratch = [Scratch(compiled.loaded, compiled.records[name]) for name in used if name in compiled.records]
    compiled.loaded.mrts_track.restype = ctypes.c_longlong
    done = compiled.loaded.mrts_track(
        ctypes.c_longlong(samples),
        ctypes.byref(task),
        *(pointer(array) for array in (*given, q, dq, ddq, *about)),
        *scratch[0].at_least(*scratch[1:]).pointers(),
    )
    return KernelTrack(int(done), q, dq, ddq, *about)
