"""The highest interval of c² where friction and torque-speed curves stand beside inertia."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from cell_bank import random_planar_cell, random_spatial_cell
from conftest import UR5
from random_motors import equipped

import mrts
from mrts.cell.robot import JointMotors
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.infeasibility import widening_at
from mrts.program.motion_rows import motion_rows, motor_terms, travel_directions
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import closest_speed, motion_ranges, sample_ranges


def test_friction_points_along_the_travel_and_is_one_sided_at_rest(lift):
    t, rounding = np.linspace(0, 2 * np.pi, 9), 1e-8 * (-1.0) ** np.arange(9)
    dq = np.column_stack([np.sin(t / 2), np.sin(t), -np.sin(t / 2), rounding])
    ddq = np.column_stack([np.cos(t / 2) / 2, np.cos(t), -np.cos(t / 2) / 2, -rounding])
    before, after = travel_directions(CoordinatedMotion(lift, dq, dq, ddq, checked=False))
    assert np.array_equal(before[:, 0], np.ones(9))
    assert np.array_equal(after[:, 0], np.ones(9))
    assert np.array_equal(before[:, 1], [1, 1, 1, 1, 1, -1, -1, -1, -1])
    assert np.array_equal(after[:, 1], [1, 1, 1, 1, -1, -1, -1, -1, -1])
    assert np.array_equal(before[:, 2], -np.ones(9))
    assert not before[:, 3].any()
    assert not after[:, 3].any()


def test_near_a_smooth_end_friction_is_against_the_way_however_slow_a_joint_is_there(lift):
    t, ways = np.linspace(0, 1, 2001), np.array([1.0, -0.1])
    dq = (t * (1 - t))[:, None] ** 2 * ways
    before, after = travel_directions(CoordinatedMotion(lift, dq, dq, np.gradient(dq, t, axis=0), checked=False))
    for found in (before, after):
        assert np.array_equal(found, np.tile(np.sign(ways), (len(t), 1)))


@pytest.mark.quick
def test_at_a_turning_point_limits_move_inward_by_the_dry_friction(planar_cell, lift):
    motion = mrts.follow_object(planar_cell, lift)
    dq, ddq = motion.dq.copy(), motion.ddq.copy()
    dq[4, 1], ddq[4, 1] = 0.0, -3.0
    turning = replace(motion, dq=dq, ddq=ddq)
    cell = equipped(planar_cell, coulomb=2.0)
    terms = motor_terms(cell, turning)
    assert np.array_equal(np.argwhere(terms.turning), [[4, 1]])
    assert terms.dry[4, 1] == 0
    given, narrowed = (build_sample_problem(motion_rows(of, turning)) for of in (planar_cell, cell))
    unit = given.unit[1]
    torque = 2.0 * np.sign(dq) / given.unit[: dq.shape[1]]
    assert narrowed.upper[4, 1] == pytest.approx(given.upper[4, 1] - 2.0 / unit)
    assert narrowed.lower[4, 1] == pytest.approx(given.lower[4, 1] + 2.0 / unit)
    moving = np.abs(dq) > 1e-6
    moving[4, 1] = False
    shift = given.upper[:, : dq.shape[1]] - narrowed.upper[:, : dq.shape[1]]
    np.testing.assert_allclose(shift[moving], torque[moving], atol=1e-12)


SAME = 1e-9
"""Ends of c from different solvers and paths, relative."""

SOLVERS = ("kernel", "qpsol:qpoases")

OUTSIDE = 1e-4
"""Just outside of an end, relative: there limits must move by more than rounding."""


def speeds(found, sample):
    """The interval of c of one sample, in a list; an empty one where it has none."""
    low, high = found.lower[sample], found.upper[sample]
    return [(np.sqrt(low), np.sqrt(high))] if low <= high else []


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


def checked_ends(problem, found, sample):
    """Ends hold by substitution, and just outside limits must move; rows are named at every end within the caps."""
    one, cap = problem.at(np.array([sample])), problem.most[sample]
    for low, high in speeds(found, sample):
        for end, outward in ((low, -1), (high, 1)):
            if not np.isfinite(end):
                continue
            assert widening_at(one, end**2)[0] < 2e-9
            outside = (end * (1 + outward * OUTSIDE)) ** 2
            if end > 0 and outside < cap:
                assert widening_at(one, outside)[0] > 1e-9
    for side in ("lower", "upper"):
        end = getattr(found, side)[sample]
        assert not np.isfinite(end) or found.binding(sample, side) or sample in (0, len(found.time) - 1)


@pytest.mark.parametrize(
    "seed",
    [pytest.param(1, marks=pytest.mark.quick), 5, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (10, 22))],
)
def test_every_way_finds_the_same_ends_and_they_hold(seed, tmp_path):
    _, cell, motion, _ = random_case(seed, tmp_path)
    fast = motion_ranges(motion_rows(cell, motion))
    problem = build_sample_problem(motion_rows(cell, motion))
    solvers = SOLVERS if seed == 1 else SOLVERS[:2]
    others = {name: motion_ranges(motion_rows(cell, motion, solver=name)) for name in solvers}
    size = len(cell.wrench_components)
    if all(len(robot.joints) == size for robot in cell.robots):
        others["torque form"] = motion_ranges(motion_rows(cell, motion, None, "torque"))
    for sample in range(motion.samples):
        ours = speeds(fast, sample)
        for name, other in others.items():
            np.testing.assert_allclose(speeds(other, sample), ours, rtol=SAME, atol=1e-9, err_msg=f"{name} {sample}")
        checked_ends(problem, fast, sample)
    assert all(found.status == fast.status for found in others.values())
    lowest = [motion_ranges(motion_rows(cell, motion, solver=name), high=0.0) for name in ("kernel", solvers[0])]
    for sample in range(motion.samples):
        np.testing.assert_allclose(*(speeds(found, sample) for found in lowest), rtol=SAME, atol=1e-9)


@pytest.mark.parametrize("seed", [12, 161, 200])
def test_samples_that_stop_the_kernel_have_their_range(seed, dual_ur5):
    """Degenerate programs of motored cells, near rest most of them: in other scales they are decided."""
    motion = mrts.follow_object(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))
    cell = motored(np.random.default_rng(seed), dual_ur5, motion)
    found, problem = motion_ranges(motion_rows(cell, motion)), build_sample_problem(motion_rows(cell, motion))
    for sample in (1, 2, 3, 60):
        checked_ends(problem, found, sample)


def test_a_sample_without_any_speed_names_the_closest_and_what_conflicts_there(tmp_path):
    """At rest gravity is too much, and at every speed friction or inertia."""
    seen = Counter()
    for seed in range(16):
        _, cell, motion, _ = random_case(seed, tmp_path / str(seed))
        problem = build_sample_problem(motion_rows(cell, motion))
        for conflict in sample_ranges(problem, motion.object.time).conflicts[:2]:
            one = problem.at(np.array([conflict.sample]))
            seen["found"] += 1
            there = widening_at(one, conflict.c2)[0]
            assert there == pytest.approx(conflict.widening, rel=1e-6)
            near = conflict.c2 * np.linspace(0.5, 1.5, 11)
            assert min(widening_at(one, c2)[0] for c2 in near) >= there * (1 - 1e-6)
            assert f"c² = {conflict.c2:.4g}" in str(conflict)
            seen["moving"] += conflict.c2 > 1e-6
    assert seen["found"] > 4
    assert seen["moving"] > 0


def test_the_closest_speed_is_found_in_a_narrow_dip_near_rest(planar_cell, lift):
    """Of 1.055 - 0.0005 c and 1.0529 + c the larger is least where both are one; another row says what is fast."""
    motion = mrts.follow_object(planar_cell, lift)
    problem = build_sample_problem(motion_rows(planar_cell, motion, mrts.LoadSharing()), samples=np.array([50]))
    rows = len(problem.names)
    square, speed, upper = np.zeros((1, rows, 1)), np.zeros((1, rows)), np.full((1, rows), np.inf)
    square[0, 2], speed[0, :2], upper[0, :3] = 0.5, (-0.0005, 1.0), (-1.055, -1.0529, 1.0)
    dip = replace(problem, A=square, speed=speed, lower=np.full((1, rows), -np.inf), upper=upper)
    assert closest_speed(dip) == pytest.approx(0.0021 / 1.0005, rel=1e-6)
