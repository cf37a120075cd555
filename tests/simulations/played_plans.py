"""A plan played by an industrial controller on a plant that is not quite the plan's, in MuJoCo.

The controller runs at 1 kHz: torques of the plan and a PD of every joint by itself, cut at the motors' limits, held
until its next command and late by the bus; each motor follows with a lag. It knows neither the true friction nor the
true load, neither the other arm nor the wrenches. Nothing here depends on the plan that is played.
"""

from dataclasses import dataclass, replace

import mujoco
import numpy as np
from mujoco_cells import STEP, STIFF, add_arm, contact_wrenches, empty_world, quaternion, set_motors
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial import cKDTree

PERIOD = 1e-3
"""Of the controller [s]."""

DELAY = 1e-3
"""From a measurement to its command at the motors [s]."""

LAG = 3e-3
"""Time constant of a motor's torque [s]."""

BANDWIDTH, DAMPING = 20.0, 1.0
"""Of each joint's PD [rad/s], on the inertia that it has at the start while the others are held: the delays, 4.5 ms
together, leave a phase margin of 65°. In a closed chain what tracks better loads the grasps more: both arms' gains work
against each other."""

MEASURED = 2.5e-4
"""From one measurement of wrenches and errors to the next [s]: force sensors give up to 4000 a second."""

MASS_ERROR, FRICTION_ERROR = 0.03, 0.2
"""Shares by which the true load is heavier, and the true friction larger, than the plan's."""

BEFORE, AFTER = 0.1, 0.2
"""Standstill before the motion, in which the errors of load and friction settle, and after it [s]."""

FINE = 20001
"""Points of the object's path from which its distance is measured: they are micrometres apart."""


@dataclass(frozen=True)
class Spring:
    """A grasp that gives way, in the axes of the hand.

    Attributes:
        stiffness: Of a displacement and of a turn [N/m, N m/rad].
        loss: Damping over stiffness [s].
    """

    stiffness: tuple[float, float]
    loss: float


CLAMP = Spring((1e6, 1e4), 4e-4)
"""Jaws of metal 0.1 m apart: a box of 8 kg swings between two of them at 80 Hz, damped to a tenth."""


@dataclass(frozen=True)
class PlayedPlan:
    """What was measured from the start of the motion on.

    Attributes:
        time: Shape (n,) [s].
        duration: Of the plan [s].
        wrench: On the object at the contacts, base axes, Shape (n, n w) [N, N m].
        wrench_share: Share of its limit that each of its components uses, likewise: 1 is at the limit.
        error: Of the joints against the plan, Shape (n, m) [rad].
        object_error: Distance of the object from where the plan has it, Shape (n,) [m].
        off_path: Distance of the object from its path, whenever it should be there, Shape (n,) [m].
        cut: Share of the motion's commands in which a motor's limit cut some joint's torque.
    """

    time: np.ndarray
    duration: float
    wrench: np.ndarray
    wrench_share: np.ndarray
    error: np.ndarray
    object_error: np.ndarray
    off_path: np.ndarray
    cut: float

    @property
    def moving(self):
        return self.time <= self.duration

    @property
    def overstep(self):
        """The most by which a contact wrench passes its limit while the plan moves, as a share of it."""
        return float(np.max(self.wrench_share[self.moving])) - 1

    @property
    def overstep_after(self):
        """Likewise after its end."""
        return float(np.max(self.wrench_share[~self.moving])) - 1

    def rms(self, values):
        """Of joints or distances, while the plan moves."""
        return float(np.sqrt(np.mean(values[self.moving] ** 2)))


class Plant:
    """The arms of a cell with the true friction and the true load, at rest where a plan starts."""

    def __init__(self, cell, urdf, trajectory, grasp):
        self.cell, self.grasp = cell, grasp
        pose = trajectory.motion.object.position[0], trajectory.motion.object.rotation[0]
        spec = self._spec(urdf, pose)
        still = mujoco.MjData(model := spec.compile())
        self._place(model, still, trajectory.q[0])
        for robot in cell.robots:
            held, hand = (still.site(f"{robot.name}/{name}") for name in ("held", "hand"))
            link = spec.site(f"{robot.name}/hand")
            R = hand.xmat.reshape(3, 3).T
            link.pos, link.quat = R @ (held.xpos - hand.xpos), quaternion(R @ held.xmat.reshape(3, 3))
            if grasp is None:
                spec.add_equality(
                    type=mujoco.mjtEq.mjEQ_WELD,
                    objtype=mujoco.mjtObj.mjOBJ_SITE,
                    name1=f"{robot.name}/hand",
                    name2=f"{robot.name}/held",
                    solref=STIFF[0],
                    solimp=STIFF[1],
                )
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        for robot in cell.robots:
            worse = {name: (1 + FRICTION_ERROR) * getattr(robot.motors, name) for name in ("coulomb", "viscous")}
            set_motors(self.model, replace(robot, motors=replace(robot.motors, **worse)))
        self.v_index = self._place(self.model, self.data, trajectory.q[0])
        self.sites = [[self.data.site(f"{robot.name}/{name}") for name in ("hand", "held")] for robot in cell.robots]
        self.links = [int(self.model.site_bodyid[hand.id]) for hand, _ in self.sites]
        self.carried = self.model.body("object").id
        self.preload = self._in_hand_axes(at_rest(trajectory, "wrench", 0))

    def _spec(self, urdf, pose):
        cell, spec = self.cell, empty_world(self.cell)
        carried = spec.worldbody.add_body(name="object", pos=pose[0], quat=quaternion(pose[1]))
        carried.add_freejoint()
        carried.explicitinertial = True
        carried.mass, carried.ipos = (1 + MASS_ERROR) * cell.mass, np.zeros(3)
        carried.inertia, carried.iquat = (1 + MASS_ERROR) * np.diag(cell.inertia), [1, 0, 0, 0]
        for robot in cell.robots:
            place = robot.T_object_tip
            carried.add_site(name=f"{robot.name}/held", pos=place.p, quat=quaternion(place.R))
            add_arm(spec, robot, urdf)
            spec.joint(f"{robot.name}/{robot.joints[-1]}").parent.add_site(name=f"{robot.name}/hand")
        return spec

    def _place(self, model, data, q):
        """Put the joints there; the places of their velocities."""
        joints = [model.joint(f"{robot.name}/{joint}") for robot in self.cell.robots for joint in robot.joints]
        self.q_index = [joint.qposadr[0] for joint in joints]
        data.qpos[self.q_index] = q
        mujoco.mj_forward(model, data)
        return [joint.dofadr[0] for joint in joints]

    def _in_hand_axes(self, wrench):
        """Wrenches that the grasps bear before anything moves, Shape (n, 6)."""
        found = np.zeros((len(self.cell.robots), 6))
        for of, robot, (hand, _) in zip(found, self.cell.robots, self.sites, strict=True):
            of[self.cell.wrench_rows] = wrench[self.cell.wrench_slices[robot.name]]
            R = hand.xmat.reshape(3, 3).T @ robot.T_world_base.R
            of[:] = np.concatenate([R @ of[:3], R @ of[3:]])
        return found

    def inertia(self):
        """Of every joint while the others are held, without the object, Shape (m,) [kg m²]."""
        rows = np.zeros((self.model.nv, self.model.nv))
        for row, unit in zip(rows, np.eye(self.model.nv), strict=True):
            mujoco.mj_mulM(self.model, self.data, row, unit)
        return np.diag(rows)[self.v_index]

    @property
    def q(self):
        return self.data.qpos[self.q_index].copy()

    @property
    def dq(self):
        return self.data.qvel[self.v_index].copy()

    @property
    def place(self):
        """Of the object [m]."""
        return self.data.qpos[:3].copy()

    def step(self, torque):
        """One step with these torques of the motors."""
        model, data = self.model, self.data
        if self.grasp is None:
            data.qfrc_applied[self.v_index] = torque
            mujoco.mj_step(model, data)
            return
        mujoco.mj_step1(model, data)
        data.qfrc_applied[:] = 0
        data.qfrc_applied[self.v_index] = torque
        self.pulled = [self._pulled(i) for i in range(len(self.sites))]
        mujoco.mj_step2(model, data)

    def wrench(self):
        """The contact wrenches of the last step in base axes, Shape (n w,)."""
        found = contact_wrenches(self.cell, self.model, self.data) if self.grasp is None else np.array(self.pulled)
        return found.reshape(-1, 6)[:, self.cell.wrench_rows].ravel()

    def _pulled(self, i):
        """Let the spring of a grasp act on object and hand; its wrench on the object in base axes, Shape (6,)."""
        hand, held = self.sites[i]
        R, speed = hand.xmat.reshape(3, 3), np.zeros((2, 6))
        for site, row in zip((hand, held), speed, strict=True):
            mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_SITE, site.id, row, 0)
        turning, moving = np.split(speed[0] - speed[1], 2)
        turned = R @ held.xmat.reshape(3, 3).T
        turn = np.array([turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]) / 2
        moved = np.concatenate([R.T @ (hand.xpos - held.xpos), R.T @ turn])
        rate = np.concatenate([R.T @ moving, R.T @ turning])
        local = self.preload[i] + np.repeat(self.grasp.stiffness, 3) * (moved + self.grasp.loss * rate)
        force, moment = R @ local[:3], R @ local[3:]
        on, applied = self.data, self.data.qfrc_applied
        mujoco.mj_applyFT(self.model, on, force, moment, held.xpos, self.carried, applied)
        mujoco.mj_applyFT(self.model, on, -force, -moment, held.xpos, self.links[i], applied)
        to_base = self.cell.robots[i].T_world_base.R.T
        return np.concatenate([to_base @ force, to_base @ moment])


def at_rest(trajectory, name, end):
    """Torques or wrenches before the motion (0) or after it (1): of the row at rest if the plan has one."""
    holding = trajectory.holding
    if holding is not None and holding.ends[end]:
        return getattr(holding, name)[end]
    return getattr(trajectory, name)[-1 if end else 0]


@dataclass
class Controller:
    """Feed-forward and PD of a plan.

    Attributes:
        trajectory: The plan.
        inertia: Of the joints, Shape (m,) [kg m²].
        lower: The least that the motors can do, Shape (m,) [N m].
        upper: The most, likewise.
    """

    trajectory: object
    inertia: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    def __post_init__(self):
        plan = self.trajectory
        self.wanted = CubicHermiteSpline(plan.time, plan.q, plan.dq)

    def forward(self, t):
        """Torques of the plan, linear in time between its samples."""
        plan = self.trajectory
        if not 0 <= t <= plan.duration:
            return at_rest(plan, "torque", int(t > 0))
        return np.array([np.interp(t, plan.time, column) for column in plan.torque.T])

    def command(self, t, q, dq):
        """Torques until the next period, and whether the motors' limits cut some."""
        inside = np.clip(t, 0, self.trajectory.duration)
        speed = self.wanted(t, 1) if inside == t else np.zeros_like(dq)
        pull = BANDWIDTH**2 * (self.wanted(inside) - q) + 2 * DAMPING * BANDWIDTH * (speed - dq)
        asked = self.forward(t) + self.inertia * pull
        return np.clip(asked, self.lower, self.upper), bool(np.any((asked < self.lower) | (asked > self.upper)))


def play(cell, urdf, trajectory, grasp=None):
    """The plan in closed loop, with standstill before and after it; rigid grasps unless springs are given."""
    plant = Plant(cell, urdf, trajectory, grasp)
    lower, upper = (np.concatenate([getattr(r, f"torque_{side}") for r in cell.robots]) for side in ("lower", "upper"))
    controller = Controller(trajectory, plant.inertia(), lower, upper)
    duration, follow = trajectory.duration, 1 - np.exp(-STEP / LAG)
    torque = given = at_rest(trajectory, "torque", 0)
    sent, cut, log = [], [], []
    for k in range(-round(BEFORE / STEP), round((duration + AFTER) / STEP)):
        t = k * STEP
        if k % round(PERIOD / STEP) == 0:
            asked, was_cut = controller.command(t, plant.q, plant.dq)
            sent.append((k + round(DELAY / STEP), asked))
            cut += [was_cut] if 0 <= t <= duration else []
        while sent and sent[0][0] <= k:
            given = sent.pop(0)[1]
        torque = torque + follow * (given - torque)
        plant.step(torque)
        if k >= 0 and k % round(MEASURED / STEP) == 0:
            log.append((t, plant.wrench(), plant.q, plant.place))
    time, wrench, q, place = (np.array(column) for column in zip(*log, strict=True))
    given = trajectory.motion.object
    path = CubicHermiteSpline(trajectory.time, given.position, trajectory.c * given.twist[:, :3])
    inside = np.minimum(time, duration)
    return PlayedPlan(
        time=time,
        duration=duration,
        wrench=wrench,
        wrench_share=share_of_limits(cell, wrench),
        error=q - controller.wanted(inside),
        object_error=np.linalg.norm(place - path(inside), axis=1),
        off_path=cKDTree(path(np.linspace(0, duration, FINE))).query(place)[0],
        cut=float(np.mean(cut)),
    )


def share_of_limits(cell, wrench):
    """Of each component, of the limit that it is nearer to; these are two-sided about zero, Shape (n, n w)."""
    lower, upper = (np.concatenate([getattr(r, f"wrench_{side}") for r in cell.robots]) for side in ("lower", "upper"))
    return np.maximum(wrench / upper, wrench / lower)
