"""Unions of intervals of c² where friction and torque-speed curves stand beside inertia."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from cell_bank import compiled, random_planar_cell, random_spatial_cell
from reference import ReferenceCell
from speed_scan import Motors, SpeedScan

import mrts
from mrts.motors.joint_motors import JointMotors
from mrts.samples.range_ends import pieces
from mrts.samples.trajectory_programs import motion_ranges

CELLS = 100
END_TOLERANCE = 2e-6
"""Of c: HiGHS admits what misses a limit by 1e-9 of it, and c moves far for it where inertia balances friction."""

SAME = 1e-9
"""Ends of c from different solvers and paths, relative."""

OUTSIDE = 1e-4
"""Just outside of an end, relative: there limits must move by more than rounding."""


def speeds(found, sample):
    """Intervals of c of one sample."""
    if not found.lower[sample] <= found.upper[sample]:
        return []
    of_sample = [gap for gap in found.gaps if gap.sample == sample]
    left = pieces(found.lower[sample], found.upper[sample], of_sample)
    return [(np.sqrt(piece.lower), np.sqrt(piece.upper)) for piece in left]


def motored(rng, cell, motion):
    """The cell with random motors, of which some joints have inertia that helps against their friction at a sample."""
    sample = int(rng.integers(motion.samples // 2 + 1, motion.samples - 1))
    robots = []
    for robot in cell.robots:
        n, part = len(robot.joints), cell.joint_slices[robot.name]
        torque = np.minimum(-robot.torque_lower, robot.torque_upper)
        dq, ddq = np.abs(motion.dq[sample, part]) + 1e-3, np.abs(motion.ddq[sample, part]) + 1e-3
        scale, friction = rng.uniform(0.3, 1.2), rng.uniform(2.5, 8, n)
        helps, has = rng.random(n) < 0.25, rng.random(n) < 0.5
        curves = []
        for j in range(n):
            ends = np.array([0.0, 1.0, 2.5]) * rng.uniform(0.4, 3) * dq[j]
            given = np.column_stack([ends, torque[j] * np.array([1, 1, 0.3])])
            curves.append(given if rng.random() < 0.3 else None)
        motors = replace(
            JointMotors.unknown(n),
            armature=np.where(helps, (scale * friction) ** 2 / rng.uniform(4.2, 9, n) / ddq, 0.02 * has) * torque,
            coulomb=rng.uniform(0, 0.1, n) * torque * has,
            viscous=np.where(helps, friction * torque / dq * scale, rng.uniform(0, 0.5) * torque * has),
            torque_speed=tuple(curves),
        )
        robots.append(replace(robot, motors=motors))
    return replace(cell, robots=tuple(robots))


def random_case(seed, folder):
    rng = np.random.default_rng([15, seed])
    make, arms = (random_planar_cell, random_spatial_cell)[seed % 2], 1 + seed % 3
    case = make(rng, folder, arms)
    motion = mrts.follow_object(case.cell, case.motion)
    return case, motored(rng, case.cell, motion), motion, rng


def compared(seed, folder, seen):
    case, cell, motion, rng = random_case(seed, folder)
    if seed % 4 < 2:
        cell = compiled(cell)
    found = motion_ranges(cell, motion, "wrench", None, "kernel")
    reference = ReferenceCell(case.cell_file)
    _, samples = reference.object_motion(case.motion_file)
    joints = reference.joint_motion(samples)
    motors = [
        Motors(robot.motors.armature, robot.motors.coulomb, robot.motors.viscous, list(robot.motors.torque_speed))
        for robot in cell.robots
    ]
    with_gaps = [gap.sample for gap in found.gaps if 0 < gap.sample < motion.samples - 1]
    chosen = {int(rng.integers(1, motion.samples - 1)), *with_gaps[:1]}
    for sample in sorted(chosen):
        scan = SpeedScan(reference, motors, samples[sample], [arm[sample] for arm in joints])
        ours = speeds(found, sample)
        largest = max((end for pair in ours for end in pair if np.isfinite(end)), default=3.0)
        ends = np.array([end for pair in ours for end in pair if np.isfinite(end)])
        middles = (ends[1:] + ends[:-1]) / 2
        theirs = scan.intervals(np.concatenate([np.linspace(0, 1.3 * largest, 14), middles]))
        where = f"seed {seed}, sample {sample}: {ours}, {theirs}"
        seen["samples"] += 1
        seen["infeasible"] += not ours
        seen["several"] += len(ours) > 1
        seen["minimum"] += bool(ours) and ours[0][0] > 0
        wide = [pair for pair in ours if pair[1] > pair[0] * (1 + END_TOLERANCE)]
        assert len(theirs) == len(wide), where
        np.testing.assert_allclose(theirs, wide, rtol=END_TOLERANCE, atol=END_TOLERANCE * 1e-2, err_msg=where)


@pytest.mark.parametrize("first", range(0, CELLS, 20))
def test_unions_equal_the_scan_of_the_reference(first, tmp_path):
    seen = Counter()
    for seed in range(first, first + 20):
        compared(seed, tmp_path / str(seed), seen)
    assert seen["several"] >= 2
    assert seen["samples"] >= 20
