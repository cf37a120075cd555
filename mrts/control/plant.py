# SPDX-License-Identifier: MIT
"""A cell as MuJoCo simulates it: arms with their motors, and the object in grasps that give way."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, SolverError
from mrts.base.rigid_transform import quaternions_from_rotations, rotations_from_quaternions
from mrts.cell.cell import Cell
from mrts.cell.generation import chain_of
from mrts.control.controller import PlantErrors
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.motion.object_motion import ObjectMotion
from mrts.scaling.scaled_trajectory import ScaledTrajectory

SPATIAL = 6
"""Components of a grasp."""

STIFF_FRICTION = [0.9999, 0.9999, 1e-3, 0.5, 2.0]
"""MuJoCo's impedance of dry friction, at its largest: a joint at rest creeps as little as it can."""


class Plant:
    """The model of MuJoCo and its state.

    A grasp is six springs with dampers between hand and object, in the axes of the hand, that bear the plan's wrench
    at rest where the hand is in its grasp; contact wrenches are their forces.

    Args:
        cell: The cell, as it is planned with.
        errors: How it differs.
        lag: Time constant of the motors' torques, 0 for none [s].
        step: Of the simulation [s].

    Raises:
        InputError: If the cell's URDFs are not there as they were, or it has another number of grasps.
    """

    def __init__(self, cell: Cell, errors: PlantErrors, lag: float, step: float) -> None:
        if cell.folder is None:
            rule = "its URDFs are needed, and a generated cell does not say where they are: name the cell file."
            raise InputError(cell.name, rule)
        if errors.stiffness.shape not in {(2,), (len(cell.robots), 2)}:
            raise InputError("errors", f"must be one, or one for each of {len(cell.robots)} grasps.", key="stiffness")
        self.cell = cell
        self._spec, self._masses = mujoco.MjSpec(), list[tuple[str, float, Array]]()
        option = self._spec.option
        option.timestep, option.gravity = step, cell.gravity
        option.integrator = mujoco.mjtIntegrator.mjINT_EULER  # implicit ones add h c to what two bodies share
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
        self._add_object(errors)
        for robot in cell.robots:
            self._add_arm(robot, chain_of(cell, robot, cell.folder), errors)
        for joint in cell.joint_names:
            motor = self._spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
            if lag > 0:
                motor.dyntype, motor.dynprm[0] = mujoco.mjtDyn.mjDYN_FILTEREXACT, lag
        stiffness = np.broadcast_to(errors.stiffness, (len(cell.robots), 2))
        for robot, (shift, turn) in zip(cell.robots, stiffness.tolist(), strict=True):
            for axis, rigidity in enumerate([shift] * 3 + [turn] * 3):
                self._spec.add_actuator(
                    target=f"{robot.name}/held", refsite=f"{robot.name}/hand", trntype=mujoco.mjtTrn.mjTRN_SITE,
                    gear=np.eye(SPATIAL)[axis], biastype=mujoco.mjtBias.mjBIAS_AFFINE,
                    biasprm=[0.0, -rigidity, -rigidity * errors.damping_time, *[0.0] * 7],
                )  # fmt: skip
        self.model: Any = self._spec.compile()
        for name, mass, moments in self._masses:  # the compiler refuses what a URDF may have, such as a point mass
            body = self.model.body(name).id
            self.model.body_mass[body], self.model.body_inertia[body] = mass, moments
        mujoco.mj_setConst(self.model, mujoco.MjData(self.model))
        self.data: Any = mujoco.MjData(self.model)
        joints = [self.model.joint(joint) for joint in cell.joint_names]
        self.q_index = np.array([joint.qposadr[0] for joint in joints])
        self.v_index = np.array([joint.dofadr[0] for joint in joints])
        self.hands = [self.model.site(f"{robot.name}/hand").id for robot in cell.robots]
        self.held = [self.model.site(f"{robot.name}/held").id for robot in cell.robots]

    def _add_body(self, parent: Any, name: str, at: Array, R: Array, mass: float, com: Array, inertia: Array) -> Any:
        """A body; its inertia is about its centre of mass, in the axes of its frame."""
        moments, axes = np.linalg.eigh(inertia)
        axes[:, 0] *= np.sign(np.linalg.det(axes))
        body = parent.add_body(name=name, pos=at, quat=quaternion(R))
        body.explicitinertial, body.mass, body.inertia = True, 1.0, np.ones(3)
        body.ipos, body.iquat = com, quaternion(axes)
        self._masses.append((name, mass, moments))
        return body

    def _add_object(self, errors: PlantErrors) -> None:
        cell, zero = self.cell, np.zeros(3)
        heavier, com = 1 + errors.mass, cell.load[1:4] / cell.mass
        at_com = cell.inertia - cell.mass * (com @ com * np.eye(3) - np.outer(com, com))
        mass, place = heavier * cell.mass, com + errors.com
        carried = self._add_body(self._spec.worldbody, "object", zero, np.eye(3), mass, place, heavier * at_com)
        carried.add_freejoint()
        for robot in cell.robots:
            grasp = robot.T_object_tip
            carried.add_site(name=f"{robot.name}/held", pos=grasp.p, quat=quaternion(grasp.R))

    def _add_arm(self, robot: Any, chain: Any, errors: PlantErrors) -> None:
        base, motors, rougher = robot.T_world_base, robot.motors, 1 + errors.friction_error
        parent: Any = self._spec.worldbody.add_body(pos=base.p, quat=quaternion(base.R))
        for index, joint in enumerate(chain.joints):
            name, at, body = f"{robot.name}/{joint.name}", joint.placement, joint.body
            parent = self._add_body(parent, name, at.p, at.R, body.mass, body.com, body.at_com)
            kind = "mjJNT_SLIDE" if joint.kind == "prismatic" else "mjJNT_HINGE"
            parent.add_joint(
                name=name, type=getattr(mujoco.mjtJoint, kind), axis=joint.axis, armature=motors.armature[index],
                damping=rougher * motors.viscous[index], frictionloss=rougher * motors.coulomb[index],
                solimp_friction=STIFF_FRICTION, solref_friction=[2 * self._spec.option.timestep, 1.0],
            )  # fmt: skip
        parent.add_site(name=f"{robot.name}/hand", pos=chain.tip.p, quat=quaternion(chain.tip.R))

    def start(self, plan: ScaledTrajectory, torque: Array, wrench: Array) -> None:
        """Place everything where a plan starts, at rest, with torques of motors and wrenches that grasps bear."""
        data, given, joints = self.data, plan.motion.object, len(self.q_index)
        self.set_state(plan.q[0], np.zeros(joints), given.position[0], given.rotation[0], np.zeros(SPATIAL))
        data.ctrl[:joints] = torque
        data.act[:] = torque[: len(data.act)]
        mujoco.mj_forward(self.model, data)
        for robot, hand, start in zip(self.cell.robots, self.hands, self._grasps(), strict=True):
            borne = np.zeros(SPATIAL)
            borne[self.cell.wrench_rows] = wrench[self.cell.wrench_slices[robot.name]]
            R = data.site_xmat[hand].reshape(3, 3).T @ robot.T_world_base.R
            self.model.actuator_biasprm[start : start + SPATIAL, 0] = np.concatenate([R @ borne[:3], R @ borne[3:]])

    def set_state(self, q: Array, dq: Array, position: Array, rotation: Array, twist: Array) -> None:
        """Joints and object, as `ScaledTrajectory` has them at one sample."""
        data = self.data
        data.qpos[self.q_index], data.qvel[self.v_index] = q, dq
        data.qpos[:3], data.qpos[3:7] = position, quaternion(rotation)
        data.qvel[:3], data.qvel[3:6] = twist[:3], rotation.T @ twist[3:]

    def joints(self) -> Array:
        """Their positions and velocities, Shape (2, m)."""
        return np.array([self.data.qpos[self.q_index], self.data.qvel[self.v_index]])

    def inertia(self) -> Array:
        """Of every joint while the others are held, without the object, Shape (m,) [kg m²]."""
        unit = np.eye(self.model.nv)
        rows = np.zeros_like(unit)
        for row, one in zip(rows, unit, strict=True):
            mujoco.mj_mulM(self.model, self.data, row, one)
        inertia: Array = np.diag(rows)[self.v_index]
        return inertia

    def stable_step(self) -> float:
        """A step that springs and dampers of the grasps bear where the cell is now, with half of it to spare [s]."""
        model, data = self.model, self.data
        apart = []
        for hand, held in zip(self.hands, self.held, strict=True):
            J = np.zeros((2, 2, 3, model.nv))
            for site, of in zip((hand, held), J, strict=True):
                mujoco.mj_jacSite(model, data, *of, site)
            apart.append((J[1] - J[0]).reshape(SPATIAL, model.nv))
        moved = np.vstack(apart)
        pulled = np.zeros_like(moved)
        mujoco.mj_solveM(model, data, pulled, moved)
        springs = slice(len(self.q_index), None)
        rigidity, damping = (
            float(np.max(np.linalg.eigvals(-model.actuator_biasprm[springs, column, None] * (moved @ pulled.T)).real))
            for column in (1, 2)
        )
        return float(2 / (damping + np.sqrt(damping**2 + 2 * rigidity)))  # h damping + h² rigidity / 2 is 1, of 2

    def step(self, torque: Array, steps: int) -> None:
        """Some steps with these commands at the motors, Shape (m,) [N m]."""
        self.data.ctrl[: len(torque)] = torque
        mujoco.mj_step(self.model, self.data, nstep=steps)

    def sample(self) -> Array:
        """State, accelerations, forces of motors and grasps, and the hands' axes now, in one row for `trajectory`."""
        data = self.data
        mujoco.mj_forward(self.model, data)
        return np.concatenate(
            [data.qpos, data.qvel, data.qacc, data.actuator_force, data.site_xmat[self.hands].ravel()]
        )

    def check_sound(self) -> None:
        """Refuse a simulation that has run away: MuJoCo then began again.

        Raises:
            SolverError: If it has.
        """
        bad = ("mjWARN_BADQPOS", "mjWARN_BADQVEL", "mjWARN_BADQACC")
        if any(self.data.warning[getattr(mujoco.mjtWarning, name)].number for name in bad):
            raise SolverError(
                "the simulated cell runs away: its grasps are too stiff for the step. Lower 'stiffness', or change "
                "'damping_time'."
            )

    def trajectory(self, time: Array, rows: Array) -> ScaledTrajectory:
        """What was simulated as a trajectory of the cell, at c² = 1: a row of `sample` at each time, Shape (N,) [s]."""
        model, m = self.model, len(self.q_index)
        sizes = np.cumsum([model.nq, model.nv, model.nv, model.nu])
        qpos, qvel, qacc, force, axes = np.split(rows, sizes, axis=1)
        rotation = rotations_from_quaternions(qpos[:, [4, 5, 6, 3]])
        twist, acceleration = (
            np.hstack([of[:, :3], np.einsum("nij,nj->ni", rotation, of[:, 3:6])]) for of in (qvel, qacc)
        )
        carried = ObjectMotion(time, qpos[:, :3], rotation, twist, acceleration, checked=False)
        q, dq, ddq = qpos[:, self.q_index], qvel[:, self.v_index], qacc[:, self.v_index]
        motion = CoordinatedMotion(carried, q, dq, ddq, checked=False)
        wrench = []
        for index, (robot, start) in enumerate(zip(self.cell.robots, self._grasps(), strict=True)):
            R = robot.T_world_base.R.T @ axes[:, 9 * index : 9 * index + 9].reshape(-1, 3, 3)
            pushed = force[:, start : start + SPATIAL].reshape(-1, 2, 3)
            both = np.einsum("nij,nkj->nki", R, pushed).reshape(-1, SPATIAL)
            wrench.append(both[:, self.cell.wrench_rows])
        return ScaledTrajectory(self.cell, motion, 1.0, force[:, :m], np.hstack(wrench))

    def _grasps(self) -> range:
        """Where the springs of each grasp begin among the actuators."""
        m = len(self.q_index)
        return range(m, m + SPATIAL * len(self.cell.robots), SPATIAL)


@contextmanager
def without_log() -> Iterator[None]:
    """MuJoCo writes no file of warnings, as it does where one runs away."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _text: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def quaternion(R: Array) -> Array:
    """Of a rotation, as MuJoCo has it, w first, Shape (4,)."""
    found: Array = np.roll(quaternions_from_rotations(R[None])[0], 1)
    return found
