# SPDX-License-Identifier: MIT
"""Test vectors of an exported library: samples of a motion under several loads, and what this runtime finds."""

import numpy as np

from mrts.base.embedded_inputs import EmbeddedVector
from mrts.base.errors import InputError, MotionError
from mrts.base.rigid_transform import rpy_from_rotation
from mrts.cell.cell import Cell
from mrts.collisions.bodies import tip_at_posture
from mrts.following.coordinated_motion import CoordinatedMotion, follow_object
from mrts.motion.motion_file import MotionDescription, sample_motion
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import motion_rows
from mrts.program.range_status import RangeStatus
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import motion_ranges
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.program.torque_distribution import distribute_torques, torque_weights

SAMPLES = 101
MASS_FACTORS = (1.0, 0.2, 3.0, 10.0, 40.0)
"""Of the nominal mass: light enough to be fast, heavy enough to be infeasible."""

LIFTS = (0.05, 0.02, 0.005)
"""Ways upward that are tried for a motion of our own [m]."""

SHARE_OF_END = 0.5
"""Torques are compared at this share of c²⁺: at the end itself the feasible set is a point, and rounding decides."""

STATUS = {RangeStatus.FEASIBLE: 0, RangeStatus.UNBOUNDED: 1, RangeStatus.INFEASIBLE: 2}
"""Of the exported header."""


def make_vectors(cell: Cell, motion: CoordinatedMotion) -> list[EmbeddedVector]:
    """All samples of a motion with the nominal load first, then with other masses."""
    vectors: list[EmbeddedVector] = []
    given = motion.object
    fields = (motion.q, motion.dq, motion.ddq, given.rotation, given.twist, given.acceleration)
    for factor in MASS_FACTORS:
        heavy = cell.with_mass(cell.mass * factor)
        rows = motion_rows(heavy, motion)
        free = motion_ranges(rows, DEFAULT_SOLVER)
        even = motion_ranges(motion_rows(heavy, motion, LoadSharing()), DEFAULT_SOLVER)
        speeds = np.where([status is RangeStatus.FEASIBLE for status in free.status], SHARE_OF_END * free.upper, 0.0)
        speeds = np.where(speeds >= free.lower, speeds, 0.0)
        compared = np.flatnonzero(speeds > 0)
        torque = np.zeros((motion.samples, motion.q.shape[1]))
        if compared.size:
            problem = build_sample_problem(rows, samples=compared)
            x = distribute_torques(problem, speeds[compared], torque_weights(None, cell), DEFAULT_SOLVER)
            torque[compared] = problem.torque(x)
        vectors += [
            EmbeddedVector(
                inputs=tuple(field[sample] for field in fields),
                place="start" if sample == 0 else "end" if sample == motion.samples - 1 else "inside",
                mass=heavy.mass,
                status=STATUS[free.status[sample]],
                ends=(float(free.lower[sample]), float(free.upper[sample])),
                share_status=STATUS[even.status[sample]],
                share_ends=(float(even.lower[sample]), float(even.upper[sample])),
                c2=float(speeds[sample]),
                torque=torque[sample],
            )
            for sample in range(motion.samples)
        ]
    return vectors


def own_motion(cell: Cell) -> CoordinatedMotion:
    """A short lift against gravity from where the first robot's posture puts the object."""
    first = cell.robots[0]
    T_world_object = tip_at_posture(first) @ first.T_object_tip.inverse()
    rpy = rpy_from_rotation(T_world_object.R)
    size = float(np.linalg.norm(cell.gravity))
    up = -cell.gravity / size if size > 0 else np.array([0.0, 1.0, 0.0])
    for lift in LIFTS:
        places = {"start": T_world_object.p, "end": T_world_object.p + lift * up}
        ends = {name: {"xyz": place.tolist(), "rpy": rpy} for name, place in places.items()}
        description = {"duration": 0.5, "samples": SAMPLES, "profile": "quintic", **ends}
        try:
            return follow_object(cell, sample_motion(MotionDescription.model_validate(description)))
        except MotionError:
            continue
    raise InputError(
        "--motion",
        "the test vectors need a motion, and the arms cannot lift the object from the first robot's posture. Give a "
        "motion file that this cell can follow.",
    )
