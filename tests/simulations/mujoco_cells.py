"""Cells as MuJoCo builds them: arms from their URDF through its own parser, the object welded to the hands."""

import mujoco
import numpy as np
import yaml
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

STEP = 5e-5  # s; a weld is a stiff spring in MuJoCo, and its time constant is two steps

POSITION_GAIN, VELOCITY_GAIN = 300.0, 10.0  # N m/rad, N m s/rad

STIFF = [2 * STEP, 1.0], [0.9999, 0.9999, 1e-3, 0.5, 2.0]  # solref, solimp

UR5_MOTORS = {
    "armature": [0.66, 0.66, 0.66, 0.1, 0.1, 0.1],
    "coulomb": [7.0, 7.0, 5.0, 2.0, 2.0, 2.0],
    "viscous": [8.0, 8.0, 6.0, 1.0, 1.0, 1.0],
}
"""Of the size that is published for arms of this class [kg m², N m, N m s/rad]."""

PLANAR_MOTORS = {"armature": [0.4, 0.3, 0.05], "coulomb": [4.0, 3.0, 0.5], "viscous": [1.0, 0.8, 0.1]}


def urdf_of(folder):
    return folder / yaml.safe_load((folder / "cell.yaml").read_text())["robots"][0]["urdf"]


def quaternion(R):
    return np.roll(Rotation.from_matrix(R).as_quat(), 1)


def empty_world(cell):
    spec = mujoco.MjSpec()
    spec.option.timestep = STEP
    spec.option.gravity = cell.gravity
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    return spec


def add_arm(spec, robot, urdf):
    frame = spec.worldbody.add_frame(pos=robot.T_world_base.p, quat=quaternion(robot.T_world_base.R))
    spec.attach(mujoco.MjSpec.from_file(str(urdf)), frame=frame, prefix=f"{robot.name}/")


def set_motors(model, robot):
    """Armature, damping and frictionloss of MuJoCo; its dry friction is as steep near standstill as a weld is stiff."""
    for j, joint in enumerate(robot.joints):
        dof = model.joint(f"{robot.name}/{joint}").dofadr[0]
        model.dof_armature[dof] = robot.motors.armature[j]
        model.dof_damping[dof] = robot.motors.viscous[j]
        model.dof_frictionloss[dof] = robot.motors.coulomb[j]
        model.dof_solref[dof], model.dof_solimp[dof] = STIFF


def simulator(cell, urdf, start_pose, *, motors=False):
    """Every arm of a cell from one URDF, and the object as a free body welded to all hands."""
    spec = empty_world(cell)
    carried = spec.worldbody.add_body(name="object", pos=start_pose[0], quat=quaternion(start_pose[1]))
    carried.add_freejoint()
    carried.explicitinertial = True
    carried.mass, carried.ipos = cell.mass, np.zeros(3)
    carried.inertia, carried.iquat = np.diag(cell.inertia), [1, 0, 0, 0]
    for robot in cell.robots:
        add_arm(spec, robot, urdf)
        weld = spec.add_equality(
            type=mujoco.mjtEq.mjEQ_WELD,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=f"{robot.name}/wrist_3",
            name2="object",
            solref=STIFF[0],
            solimp=STIFF[1],
        )
        R_tip_object = robot.T_object_tip.R.T
        weld.data[:11] = np.concatenate(
            [np.zeros(3), -R_tip_object @ robot.T_object_tip.p, quaternion(R_tip_object), [1.0]]
        )
    model = spec.compile()
    for robot in cell.robots if motors else ():
        set_motors(model, robot)
    return model, mujoco.MjData(model)


def closed_loop(cell, urdf, done, forward, *, motors=False):
    """Every step in which torques by time and a small feedback play a motion.

    Yields:
        Model and data after the step, its time before it [s], the feedback [N m], and errors of the joints [rad].
    """
    given = done.motion.object
    model, data = simulator(cell, urdf, (given.position[0], given.rotation[0]), motors=motors)
    joints = [model.joint(f"{robot.name}/{joint}") for robot in cell.robots for joint in robot.joints]
    q_index, v_index = [joint.qposadr[0] for joint in joints], [joint.dofadr[0] for joint in joints]
    data.qpos[q_index] = done.q[0]
    wanted = CubicSpline(done.time, done.q)
    for _ in range(int(done.duration / STEP)):
        t = data.time
        feedback = POSITION_GAIN * (wanted(t) - data.qpos[q_index])
        feedback += VELOCITY_GAIN * (wanted(t, 1) - data.qvel[v_index])
        data.qfrc_applied[v_index] = forward(t) + feedback
        mujoco.mj_step(model, data)
        yield model, data, t, feedback, data.qpos[q_index] - wanted(data.time)


def weld_wrench(model, data, weld):
    """Force and moment about the com that a weld exerts on the object, world axes."""
    rows = np.flatnonzero((data.efc_id == weld) & (data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY))
    J = data.efc_J.reshape(-1, model.nv) if not mujoco.mj_isSparse(model) else dense_jacobian(model, data)
    on_object = J[rows][:, :6].T @ data.efc_force[rows]  # free joint: force in the world, moment in the body
    R = data.body("object").xmat.reshape(3, 3)
    return np.concatenate([on_object[:3], R @ on_object[3:]])


def contact_wrenches(cell, model, data):
    """Wrenches on the object at the contacts in base axes, six a robot, Shape (6 n,), from the forces of the welds."""
    found, R = [], data.body("object").xmat.reshape(3, 3)
    for weld, robot in enumerate(cell.robots):
        force, moment = np.split(weld_wrench(model, data, weld), 2)
        moment = moment - np.cross(R @ robot.T_object_tip.p, force)
        found += [robot.T_world_base.R.T @ force, robot.T_world_base.R.T @ moment]
    return np.concatenate(found)


def dense_jacobian(model, data):
    J = np.zeros((data.nefc, model.nv))
    mujoco.mju_sparse2dense(J, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
    return J
