"""Torques of a plan against MuJoCo with armature, damping and frictionloss: its inverse dynamics, and played in it."""

import mujoco
import numpy as np
import pytest
from conftest import DATA, UR5
from mujoco_cells import (
    PLANAR_MOTORS,
    UR5_MOTORS,
    add_arm,
    closed_loop,
    empty_world,
    set_motors,
    urdf_of,
)
from random_motors import equipped
from scipy.interpolate import make_interp_spline
from shipped_cells import sampled, shipped_motion

import mrts

SAME_TORQUE = 1e-9
"""Between two formulations of the same dynamics, in N m of friction and as a share of the largest torque: the rounding
of a thousand operations on terms a thousand times as large."""

STEADY = 0.05
"""Share of a joint's largest speed above which MuJoCo's soft dry friction has the size of the given one; below, it
depends on how fast the speed changes."""

TRACKED = 2e-3
"""[rad]"""


def cases(name):
    folder, columns, motion = {
        "dual_ur5": (UR5, UR5_MOTORS, "lift_and_turn.yaml"),
        "planar_dual_arm": (DATA, PLANAR_MOTORS, "lift.yaml"),
    }[name]
    cell = equipped(mrts.load_cell(folder / "cell.yaml"), **columns)
    return cell, mrts.load_motion(folder / motion), urdf_of(folder)


@pytest.mark.parametrize("name", ["dual_ur5", "planar_dual_arm"])
@pytest.mark.quick
def test_torques_are_those_of_inverse_dynamics(name):
    """Arm by arm: what MuJoCo needs for the joints' motion, and to push the object with the wrench of the plan."""
    cell, motion, urdf = cases(name)
    done = mrts.scale(cell, motion).trajectory
    given = done.motion.object
    for robot in cell.robots:
        joints, wrenches = cell.joint_slices[robot.name], cell.wrench_slices[robot.name]
        spec = empty_world(cell)
        add_arm(spec, robot, urdf)
        model = spec.compile()
        set_motors(model, robot)
        data = mujoco.MjData(model)
        places = [model.joint(f"{robot.name}/{joint}").dofadr[0] for joint in robot.joints]
        tip = model.njnt - 1
        R, six = robot.T_world_base.R, np.zeros(6)
        wanted, dry = [], []
        for k in range(len(given.time)):
            for values, ours in ((data.qpos, done.q), (data.qvel, done.dq), (data.qacc, done.ddq)):
                values[places] = ours[k, joints]
            mujoco.mj_inverse(model, data)
            six[cell.wrench_rows] = done.wrench[k, wrenches]
            J = np.zeros((2, 3, model.nv))
            point = given.position[k] + given.rotation[k] @ robot.T_object_tip.p
            mujoco.mj_jac(model, data, J[0], J[1], point, model.jnt_bodyid[tip])
            pushed = J[0].T @ R @ six[:3] + J[1].T @ R @ six[3:]
            wanted.append((data.qfrc_inverse + data.qfrc_constraint + pushed)[places])
            dry.append(-data.qfrc_constraint[places])
        wanted, dry = np.array(wanted), np.array(dry)
        moving = np.abs(done.dq[:, joints]) > STEADY * np.max(np.abs(done.dq[:, joints]), axis=0)
        ours = np.sign(done.dq[:, joints]) * robot.motors.coulomb
        np.testing.assert_allclose(dry[moving], ours[moving], atol=SAME_TORQUE)
        assert np.mean(moving) > 0.5
        viscous = done.dq[:, joints] * robot.motors.viscous
        friction = done.friction[:, joints]
        np.testing.assert_allclose(friction[moving], (ours + viscous)[moving], atol=SAME_TORQUE)
        off = done.torque[:, joints] - (friction - viscous) - wanted  # MuJoCo's own damping is in what is wanted
        print(robot.name, "largest difference [N m]", np.max(np.abs(off)), "of", np.max(np.abs(done.torque)))
        assert np.max(np.abs(off)) < SAME_TORQUE * np.max(np.abs(done.torque))


@pytest.fixture(scope="module")
def played():
    """Largest errors of the joints along the plan, with the friction of the plan fed forward, and without [rad]."""
    cell, _, urdf = cases("dual_ur5")
    cell = cell.without_velocity_limits()
    done = mrts.scale(cell, sampled(shipped_motion("dual_ur5", samples=1001))).trajectory
    found = {}
    for kind, forward in (("with", done.torque), ("without", done.torque - done.friction)):
        steps = closed_loop(cell, urdf, done, make_interp_spline(done.time, forward, k=1), motors=True)
        found[kind] = max(float(np.max(np.abs(off))) for *_, off in steps)
    return found


def test_friction_fed_forward_keeps_the_joints_on_their_path(played):
    print("largest error of a joint [rad]", played)
    assert played["with"] < TRACKED


def test_without_it_they_leave_it(played):
    """The friction is felt: else the test above says nothing about it."""
    assert played["without"] > 3 * TRACKED
