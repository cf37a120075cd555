"""Recordings of arms that move freely: simulated by MuJoCo with motors, or exact by the cell's own equations."""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

import mrts

STEP = 5e-5  # s; MuJoCo's velocities lag by half a step, which viscous friction makes an armature of b h / 2
SUBSTEPS = 20  # steps a sample: 1 kHz
QUANTUM = 1e-5  # rad or m, of an encoder
EFFORT_NOISE = 0.01  # of a joint's torque limit, standard deviation


@dataclass(frozen=True)
class Motors:
    """True numbers of an arm, each Shape (n,)."""

    armature: np.ndarray
    viscous: np.ndarray
    coulomb: np.ndarray


def sines(time, joints, rng, share=1.0, still=()):
    """Positions, velocities and accelerations of joints that move to and fro in five sines each, Shape (N, n)."""
    parts = np.zeros((3, len(time), joints))
    for joint in range(joints):
        for _ in range(5):
            w, phase = 2 * np.pi * rng.uniform(0.2, 1.2), rng.uniform(0, 2 * np.pi)
            size = 0 if joint in still else share * rng.uniform(0.06, 0.16)
            sine, cosine = size * np.sin(w * time + phase), size * np.cos(w * time + phase)
            parts[:, :, joint] += [sine, w * cosine, -(w**2) * sine]
    return parts


def simulated(cell, robot, urdf, motors, seconds=30.0, seed=1, still=()):
    """Time, positions and efforts of an arm that MuJoCo moves by position control, as they are, before any noise."""
    spec = mujoco.MjSpec()
    spec.option.timestep = STEP
    spec.option.gravity = cell.gravity
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    T = robot.T_world_base
    frame = spec.worldbody.add_frame(pos=T.p, quat=np.roll(Rotation.from_matrix(T.R).as_quat(), 1))
    spec.attach(mujoco.MjSpec.from_file(str(urdf)), frame=frame, prefix="arm/")
    for name, armature, viscous, coulomb in zip(
        robot.joints, motors.armature, motors.viscous, motors.coulomb, strict=True
    ):
        joint = spec.joint(f"arm/{name}")
        joint.armature, joint.frictionloss = armature, coulomb
        joint.damping[0] = viscous
        joint.solref_friction = [2 * STEP, 1.0]  # stiff: friction is full from 1 mrad/s on
        joint.solimp_friction = [0.9999, 0.9999, 1e-3, 0.5, 2.0]
        gain = 400 * (armature + 1.0)
        spec.add_actuator(
            name=name,
            target=f"arm/{name}",
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            dyntype=mujoco.mjtDyn.mjDYN_INTEGRATOR,  # between samples its target goes on, where a held one would drag
            gainprm=[gain] + 9 * [0],
            biasprm=[0, -gain, -gain / 20] + 7 * [0],
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        )
    model = spec.compile()
    data = mujoco.MjData(model)
    assert model.nv == len(robot.joints)
    time = SUBSTEPS * STEP * np.arange(round(seconds / (SUBSTEPS * STEP)))
    wanted = robot.posture + sines(time, model.nv, np.random.default_rng(seed), still=still)[0]
    q, effort = np.empty_like(wanted), np.empty_like(wanted)
    data.qpos[:] = data.act[:] = wanted[0]
    speeds = np.diff(wanted, axis=0, append=wanted[-1:]) / (SUBSTEPS * STEP)
    for row, speed in enumerate(speeds):
        data.ctrl[:] = speed
        mujoco.mj_forward(model, data)
        q[row], effort[row] = data.qpos, data.actuator_force
        mujoco.mj_step(model, data, SUBSTEPS)
    return time, q, effort


def measured(robot, q, effort, rng):
    """What a controller records of that: encoders count, efforts are noisy."""
    noise = EFFORT_NOISE * np.maximum(np.abs(robot.torque_lower), robot.torque_upper)
    return QUANTUM * np.rint(q / QUANTUM), effort + noise * rng.standard_normal(effort.shape)


def exact_efforts(cell, motors, q, dq, ddq):
    """Efforts of all arms by the cell's own equations."""
    nothing = {"load": np.zeros(10), "object_wrench": np.zeros(cell.library.wrenches)}
    rigid = cell.functions("played_torques", len(q), {"q": q, "dq": dq, "ddq": ddq, **nothing})["torque"]
    return rigid + motors.armature * ddq + motors.viscous * dq + motors.coulomb * np.sign(dq)


def recording(path, joints, time, q, effort):
    """Recorded joints by name, as a file of this path would give them."""
    columns = zip(joints, q.T, effort.T, strict=True)
    return mrts.JointRecording(path, {name: mrts.RecordedJoint(time, x, tau) for name, x, tau in columns}, {})


def names(robot):
    """Columns of an arm."""
    return [f"{robot.name}/{joint}" for joint in robot.joints]


def write_recording(path, joints, time, q, effort):
    """A table of a recording, as a logger prints it."""
    head = ["t", *(f"q.{name}" for name in joints), *(f"tau.{name}" for name in joints)]
    rows = np.column_stack([time, q, effort])
    np.savetxt(path, rows, delimiter=",", header=",".join(head), comments="", fmt="%.9g")
    return path


def exact_recording(cell, motors, seconds=20.0, rate=1000.0, seed=5, still=()):
    """Names, times, positions and efforts of all arms of a cell in one motion, without noise."""
    time = np.arange(round(seconds * rate)) / rate
    joints = [name for robot in cell.robots for name in names(robot)]
    q, dq, ddq = sines(time, len(joints), np.random.default_rng(seed), still=still)
    q += np.concatenate([robot.posture for robot in cell.robots])
    return joints, time, q, exact_efforts(cell, motors, q, dq, ddq)


def random_motors(count, seed=6):
    """Motors of so many joints."""
    rng = np.random.default_rng(seed)
    return Motors(rng.uniform(0.2, 1, count), rng.uniform(2, 8, count), rng.uniform(1, 6, count))
