"""Inverse kinematics of spatial and redundant arms, and its outcomes."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import toppra
import toppra.constraint
import yaml
from casadi_cells import casadi_cell
from cell_bank import random_spatial_cell
from conftest import DATA
from followed_motions import assert_consistent, motion
from published_robots import CASES, ROBOTS
from random_cells import chain_model, configuration

import mrts
from mrts.following.coordinate import coordinate

UR5 = DATA.parent / "dual_ur5"


def test_a_dual_arm_cell_follows_a_turning_object(dual_ur5):
    followed = mrts.follow_object(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))
    assert_consistent(dual_ur5, followed)


@pytest.mark.parametrize("profile", ["sinusoid", "trapezoid", "cubic", "quintic"])
def test_the_geodesic_is_followed_with_every_profile(dual_ur5, profile):
    followed = mrts.follow_object(dual_ur5, motion([0.03, 0.2, 0.5], (0.2, 0.1, 0.3), profile=profile))
    # a trapezoid's acceleration jumps inside a step of the rule that integrates it here
    assert_consistent(dual_ur5, followed, tolerance=2e-3 if profile == "trapezoid" else 1e-6)


@pytest.fixture(scope="module")
def two_pandas(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pandas")
    reference, tip = CASES["panda"]
    robots = [
        {
            "name": name,
            "urdf": str(ROBOTS / reference),
            "tip_link": tip,
            "base": {"xyz": [x, 0, 0], "rpy": [0, 0, yaw]},
            "grasp": {"xyz": [float(np.sign(x) * 0.2), 0, 0], "rpy": [np.pi, 0, float(np.pi if x > 0 else 0)]},
            "posture": [0.0, 0.3, 0.0, -2.0, 0.0, 2.3, 0.8],
        }
        for name, x, yaw in (("left", -0.75, 0.0), ("right", 0.75, np.pi))
    ]
    cell = {
        "name": "pandas",
        "gravity": [0, 0, -9.81],
        "object": {"mass": 1.0, "inertia": [0.01, 0.02, 0.02]},
        "robots": robots,
    }
    (folder / "cell.yaml").write_text(yaml.safe_dump(cell), encoding="utf-8")
    return mrts.load_cell(folder / "cell.yaml")


def test_given_joints_of_redundant_arms_are_moved_as_little_as_needed(two_pandas):
    """Given joints a little off the grasps, with a motion of their own in the null space: that is kept."""
    followed = mrts.follow_object(two_pandas, motion([0.03, 0.08, 0.48], (0.1, 0.0, 0.2), start=(0, 0, 0.4)))
    time = followed.object.time
    rate = 2 * np.pi / time[-1]
    angle = rate * time[:, None] + np.arange(14)
    wave = 4e-4 * np.array([np.sin(angle), rate * np.cos(angle), -(rate**2) * np.sin(angle)])
    parts = followed.q + wave[0], followed.dq + wave[1], followed.ddq + wave[2]
    found = coordinate(two_pandas, mrts.CoordinatedMotion(followed.object, *parts))
    assert [remark.code for remark in found.remarks] == ["chain-closed"]
    assert_consistent(two_pandas, found, tolerance=1e-4)
    J = two_pandas.functions("kinematics", found.samples, {"q": found.q})["jacobian"]
    for joints in two_pandas.joint_slices.values():
        null = np.eye(7) - np.linalg.pinv(J[:, :, joints]) @ J[:, :, joints]
        for ours, given in ((found.dq, parts[1]), (found.ddq, parts[2])):
            changed = np.einsum("nij,nj->ni", null, ours[:, joints] - given[:, joints])
            assert np.max(np.abs(changed)) < 1e-9


@pytest.mark.quick
def test_unreachable_names_robot_sample_and_distance(dual_ur5):
    with pytest.raises(mrts.MotionError, match=r"robot 'left' cannot reach .* sample \d+ .* no nearer than .* m and"):
        mrts.follow_object(dual_ur5, motion([0.9, 0.1, 0.35]))
    with pytest.raises(
        mrts.MotionError, match=r"cannot reach its grasp at sample 0 .* its shoulder and reaches .* m too far"
    ):
        mrts.follow_object(dual_ur5, motion([0.0, 0.1, 2.0], start=(0, 0.1, 1.9)))
    too_near = dual_ur5.with_values({"robots.left.base.xyz": [-0.25, 0.1, 0.35]})
    with pytest.raises(mrts.MotionError, match=r"'left' cannot reach its grasp at sample 0 .* 41 starts were tried"):
        mrts.follow_object(too_near, motion([0.03, 0.2, 0.5]))


def test_joint_limits_are_checked(dual_ur5):
    given = motion([0.03, 0.35, 0.5])
    q = mrts.follow_object(dual_ur5, given).q[:, 6:]
    far = int(np.argmax(np.max(q, axis=0) - q[0]))
    upper = np.full(6, 7.0)
    upper[far] = np.max(q[:, far]) - 0.01
    tight = replace(dual_ur5.robots[1], position_upper=upper, position_lower=np.full(6, -3.2))
    cell = replace(dual_ur5, robots=(dual_ur5.robots[0], tight))
    with pytest.raises(mrts.MotionError, match=r"robot 'right' passes a position limit .* '\w+' would be at"):
        mrts.follow_object(cell, given)


def limited(cell, index, lower, upper):
    robots = list(cell.robots)
    robots[index] = replace(robots[index], position_lower=lower, position_upper=upper)
    return replace(cell, robots=tuple(robots))


def test_further_starts_are_tried_where_the_posture_leads_past_a_limit(dual_ur5):
    given = motion([0.03, 0.2, 0.5])
    free = mrts.follow_object(dual_ur5, given)
    assert free.remarks == ()
    upper = np.full(6, 7.0)
    upper[0] = free.q[0, 6] - 0.01
    cell = limited(dual_ur5, 1, np.full(6, -3.2), upper)
    moved = mrts.follow_object(cell, given)
    assert [remark.code for remark in moved.remarks] == ["other-start"]
    assert "'right'" in moved.remarks[0].text
    assert np.all(moved.q[:, 6:] <= upper)
    np.testing.assert_allclose(moved.q[:, :6], free.q[:, :6], atol=1e-9)
    np.testing.assert_array_equal(mrts.follow_object(cell, given).q, moved.q)
    away = limited(dual_ur5, 1, np.full(6, 2.0), np.full(6, 2.1))
    with pytest.raises(mrts.MotionError, match=r"'right' passes a position limit at sample 0 .* 41 starts were tried"):
        mrts.follow_object(away, given)


def test_further_starts_of_joints_without_limits(dual_ur5):
    upper = np.full(6, 7.0)
    upper[0] = mrts.follow_object(dual_ur5, motion([0.03, 0.2, 0.5])).q[0, 6] - 0.01
    lower = np.array([-3.2, -np.inf, -np.inf, -np.inf, -3.2, -3.2])
    upper[1:4] = [np.inf, 3.2, np.inf]
    moved = mrts.follow_object(limited(dual_ur5, 1, lower, upper), motion([0.03, 0.2, 0.5]))
    assert [remark.code for remark in moved.remarks] == ["other-start"]


def test_whole_turns_bring_a_joint_inside_its_limits(dual_ur5):
    given = motion([0.03, 0.2, 0.5])
    free = mrts.follow_object(dual_ur5, given)
    upper = np.append(np.max(free.q[:, 6]) - 0.01, np.full(5, 7.0))
    lower = np.full(6, -7.0)
    tight = replace(dual_ur5.robots[1], position_lower=lower, position_upper=upper)
    turned = mrts.follow_object(replace(dual_ur5, robots=(dual_ur5.robots[0], tight)), given)
    np.testing.assert_allclose(free.q - turned.q, np.tile(2 * np.pi * np.eye(12)[6], (201, 1)), atol=1e-9)


def test_too_few_joints_are_refused(tmp_path):
    case = random_spatial_cell(np.random.default_rng(1), tmp_path, 1)
    description = yaml.safe_load(case.cell_file.read_text())
    robot = description["robots"][0]
    robot |= {"tip_link": "l3", "posture": [0.0] * 4, "torque": [10.0] * 4}
    robot.pop("wrench", None)
    case.cell_file.write_text(yaml.safe_dump(description))
    with pytest.raises(mrts.InputError, match="4 moving joints, but holding the object takes 6"):
        mrts.follow_object(casadi_cell(case.cell_file), case.motion)


GIVEN_MISTAKES = {
    "all joints elsewhere": (lambda m: replace(m, q=np.full_like(m.q, 0.3)), "do not close the chain"),
    "one joint off": (lambda m: replace(m, q=m.q + 0.01 * np.eye(12)[4]), "'left' is off its grasp"),
    "no velocities": (lambda m: replace(m, dq=0 * m.dq), "velocities do not fit"),
    "no accelerations": (lambda m: replace(m, ddq=0 * m.ddq), "accelerations do not fit"),
    "arms swapped": (lambda m: replace(m, q=np.roll(m.q, 6, axis=1)), "do not close the chain"),
}


@pytest.mark.quick
@pytest.mark.parametrize("mistake", GIVEN_MISTAKES)
def test_a_motion_given_by_hand_is_checked(dual_ur5, mistake):
    followed = mrts.follow_object(dual_ur5, motion([0.03, 0.2, 0.5]))
    spoil, message = GIVEN_MISTAKES[mistake]
    with pytest.raises(mrts.MotionError, match=message):
        mrts.scale(dual_ur5, spoil(followed))


def test_a_motion_of_another_cell_is_refused(dual_ur5, planar_cell, lift):
    followed = mrts.follow_object(planar_cell, lift)
    with pytest.raises(mrts.InputError, match="6 columns, cell 'dual_ur5' has 12 joints"):
        mrts.scale(dual_ur5, followed)


OBJECT_MISTAKES = {
    "no rates": (lambda m: {"twist": 0 * m.twist}, "position: its rates do not lead"),
    "degrees": (lambda m: {"twist": m.twist * [1, 1, 1, 57.3, 57.3, 57.3]}, "rotation: its rates do not lead"),
    "accelerations turned": (lambda m: {"acceleration": -m.acceleration}, "accelerations do not lead"),
    "twice the rotation": (lambda m: {"rotation": 2 * m.rotation}, "R Rᵀ = I"),
    "a mirror": (lambda m: {"rotation": m.rotation * [1, 1, -1]}, "det R = 1"),
}


@pytest.mark.parametrize("mistake", OBJECT_MISTAKES)
def test_an_object_motion_given_by_hand_is_checked(mistake):
    given = motion([0.03, 0.2, 0.5], (0.2, 0.1, 0.3))
    spoil, message = OBJECT_MISTAKES[mistake]
    with pytest.raises(mrts.InputError, match=message):
        replace(given, **spoil(given))


def test_one_arm_equals_hollerbachs_scaling(tmp_path):
    """n = 1 without wrench limits: c² from the torque rows of inverse dynamics alone, object welded to the hand."""
    case = random_spatial_cell(np.random.default_rng(3), tmp_path, 1)
    cell = case.cell.without_wrench_limits().without_velocity_limits()
    strong = np.array([60.0, 60, 60, 60, 60, 60])
    cell = replace(cell, robots=(replace(cell.robots[0], torque_lower=-strong, torque_upper=strong),))
    followed = mrts.follow_object(cell, case.motion)
    robot = cell.robots[0]
    model = chain_model(tmp_path / "arm0.urdf")
    model.gravity.linear = robot.T_world_base.R.T @ cell.gravity
    # Hollerbach (1984): the load is part of the last link
    frame = model.frames[model.getFrameId("tip")]
    tip_object = pin.SE3(robot.T_object_tip.R, robot.T_object_tip.p).inverse()
    load = pin.Inertia(cell.mass, np.zeros(3), cell.inertia)
    model.appendBodyToJoint(frame.parentJoint, load, frame.placement * tip_object)
    data = model.createData()
    lower, upper = np.zeros(followed.samples), np.zeros(followed.samples)
    feasible = np.ones(followed.samples, dtype=bool)
    for k in range(followed.samples):
        q = configuration(model, followed.q[k])
        G = pin.computeGeneralizedGravity(model, data, q).copy()
        a = pin.rnea(model, data, q, followed.dq[k], followed.ddq[k]) - G
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.sort(np.stack([(robot.torque_lower - G) / a, (robot.torque_upper - G) / a]), axis=0)
        lower[k], upper[k] = max(0.0, np.max(ends[0])), np.min(ends[1])
        feasible[k] = lower[k] <= upper[k]
    samples = mrts.scale(cell, followed).range.samples
    assert [status.value != "infeasible" for status in samples.status] == feasible.tolist()
    moving = feasible & np.isfinite(samples.upper)
    assert np.sum(moving) > 5
    np.testing.assert_allclose(samples.upper[moving], upper[moving], rtol=1e-8)
    np.testing.assert_allclose(samples.lower[moving], lower[moving], rtol=1e-8, atol=1e-8)


def test_torque_coefficients_equal_toppras(tmp_path):
    """toppra's own constraint coefficients on the same arm and path: a u + b x + c is A r̈ + E ṙ² + G."""
    cell = random_spatial_cell(np.random.default_rng(5), tmp_path, 1).cell
    model = chain_model(tmp_path / "arm0.urdf")
    robot = cell.robots[0]
    model.gravity.linear = robot.T_world_base.R.T @ cell.gravity
    data = model.createData()
    rng = np.random.default_rng(6)
    path = toppra.SplineInterpolator(np.linspace(0, 1, 5), rng.uniform(-1, 1, (5, 6)))
    limits = np.column_stack([robot.torque_lower, robot.torque_upper])
    constraint = toppra.constraint.JointTorqueConstraint(
        lambda q, dq, ddq: pin.rnea(model, data, configuration(model, q), dq, ddq), limits, np.zeros(6)
    )
    grid = np.linspace(0, 1, 40)
    a, b, c = constraint.compute_constraint_params(path, grid)[:3]
    inputs = {
        "q": path(grid),
        "dq": path(grid, 1),
        "ddq": path(grid, 2),
        "object_rotation": np.broadcast_to(np.eye(3), (40, 3, 3)),
        "object_twist": np.zeros(6),
        "object_acceleration": np.zeros(6),
        "load": cell.load,
    }
    terms = cell.functions("terms", 40, inputs)
    for ours, theirs in ((terms["A"], a), (terms["E"], b), (terms["G"], c)):
        np.testing.assert_allclose(ours, theirs, atol=1e-10 * (1 + np.max(np.abs(theirs))))
