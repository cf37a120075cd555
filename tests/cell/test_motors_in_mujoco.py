"""Torques of a plan against MuJoCo's inverse dynamics, which reads the URDFs itself, with its own motors."""

import mujoco
import numpy as np
import pytest
from conftest import DATA, UR5
from random_motors import equipped
from scipy.spatial.transform import Rotation

import mrts

SAME_TORQUE = 1e-9
"""Between two formulations of the same dynamics, in N m of friction and as a share of the largest torque: the rounding
of a thousand operations on terms a thousand times as large."""

STEADY = 0.05
"""Share of a joint's largest speed above which MuJoCo's soft dry friction has the size of the given one; below, it
depends on how fast the speed changes."""

UR5_MOTORS = {
    "armature": [0.66, 0.66, 0.66, 0.1, 0.1, 0.1],
    "coulomb": [7.0, 7.0, 5.0, 2.0, 2.0, 2.0],
    "viscous": [8.0, 8.0, 6.0, 1.0, 1.0, 1.0],
}
"""Of the size that is published for arms of this class [kg m², N m, N m s/rad]."""

PLANAR_MOTORS = {"armature": [0.4, 0.3, 0.05], "coulomb": [4.0, 3.0, 0.5], "viscous": [1.0, 0.8, 0.1]}

SMALL_STEP = 1e-4
"""Dry friction of MuJoCo is as steep near standstill as the step is small [s]."""


def cases(name):
    folder, columns, motion = {
        "dual_ur5": (UR5, UR5_MOTORS, "lift_and_turn.yaml"),
        "planar_dual_arm": (DATA, PLANAR_MOTORS, "lift.yaml"),
    }[name]
    cell = equipped(mrts.load_cell(folder / "cell.yaml"), **columns)
    return cell, mrts.load_motion(folder / motion), folder / cell.robots[0].source.urdf


def arm_of_urdf(cell, robot, urdf):
    """The arm by itself, with its motors."""
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = SMALL_STEP, cell.gravity
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    quaternion = np.roll(Rotation.from_matrix(robot.T_world_base.R).as_quat(), 1)
    frame = spec.worldbody.add_frame(pos=robot.T_world_base.p, quat=quaternion)
    spec.attach(mujoco.MjSpec.from_file(str(urdf)), frame=frame, prefix=f"{robot.name}/")
    model = spec.compile()
    for j, joint in enumerate(robot.joints):
        dof = model.joint(f"{robot.name}/{joint}").dofadr[0]
        model.dof_armature[dof] = robot.motors.armature[j]
        model.dof_damping[dof] = robot.motors.viscous[j]
        model.dof_frictionloss[dof] = robot.motors.coulomb[j]
        model.dof_solref[dof] = [2 * SMALL_STEP, 1.0]
        model.dof_solimp[dof] = [0.9999, 0.9999, 1e-3, 0.5, 2.0]
    return model


@pytest.mark.parametrize("name", ["dual_ur5", "planar_dual_arm"])
@pytest.mark.quick
def test_torques_are_those_of_inverse_dynamics(name):
    """Arm by arm: what MuJoCo needs for the joints' motion, and to push the object with the wrench of the plan."""
    cell, motion, urdf = cases(name)
    done = mrts.scale(cell, motion).trajectory
    given = done.motion.object
    for robot in cell.robots:
        joints, wrenches = cell.joint_slices[robot.name], cell.wrench_slices[robot.name]
        model = arm_of_urdf(cell, robot, urdf)
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
