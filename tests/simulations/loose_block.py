"""A block that stands loose on a tray, which is moved along a path, in MuJoCo."""

import mujoco
import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

from mrts.simulation.plant import quaternion

STEP = 1e-4
"""Of the simulation [s]."""

SETTLED = 0.1
"""Standstill before the motion, in which the block sinks into its contacts [s]."""

TRAY_MASS = 1e5
"""So heavy that the block moves it by nothing [kg]."""


class GeodesicPlan:
    """Pose and rates of an object that goes straight from pose to pose while it turns about one axis, by time."""

    def __init__(self, motion, faster=1.0):
        first, last = (mujoco_pose(motion, place) for place in (0, -1))
        self.p, self.R, self.way = first[0], first[1], last[0] - first[0]
        self.turn = (last[1] * first[1].inv()).as_rotvec()
        gone, speed = (
            (of @ self.way) / (self.way @ self.way) for of in (motion.position - self.p, motion.twist[:, :3])
        )
        self.s = CubicHermiteSpline(motion.time / faster, gone, speed * faster)
        self.duration = motion.time[-1] / faster

    def at(self, t):
        """Position, rotation, twist and acceleration in world axes."""
        s, v, a = (self.s(np.clip(t, 0.0, self.duration), order) for order in range(3))
        if not 0 < t < self.duration:
            v = a = 0.0
        along = np.concatenate([self.way, self.turn])
        return self.p + s * self.way, Rotation.from_rotvec(s * self.turn) * self.R, v * along, a * along


def mujoco_pose(motion, place):
    return motion.position[place], Rotation.from_matrix(motion.rotation[place])


def slid(plan, thing, gravity, sides):
    """How far a block, its sides along a, b and the normal, is at most from where it stood on the tray [m]."""
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = STEP, gravity
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 1000
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.tolerance = 1e-12
    contact = {
        "friction": [thing.friction, 0, 0],
        "condim": 3,
        "solref": [1e-3, 1],
        "solimp": [0.99, 0.999, 1e-4, 0.5, 2],
    }
    tray, block = spec.worldbody.add_body(name="tray"), spec.worldbody.add_body(name="block")
    for body, mass, inertia in ((tray, TRAY_MASS, TRAY_MASS), (block, 1.0, 1e-3)):
        body.add_freejoint()
        body.explicitinertial, body.mass, body.inertia = True, mass, np.full(3, inertia)
    axes = thing.axes.T  # a, b and the normal as columns, in the tray's frame
    middle = np.array(thing.at) - 0.05 * axes[:, 2]
    tray.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.5, 0.5, 0.05], pos=middle, quat=quaternion(axes), **contact)
    block.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=np.array(sides) / 2, **contact)
    model = spec.compile()
    data = mujoco.MjData(model)
    position, rotation, *_ = plan.at(0.0)
    data.qpos[7:10] = position + rotation.apply(np.array(thing.at) + sides[2] / 2 * axes[:, 2])
    data.qpos[10:14] = quaternion(rotation.as_matrix() @ axes)
    furthest, first = 0.0, None
    for k in range(round((SETTLED + plan.duration) / STEP)):
        t = k * STEP - SETTLED
        position, rotation, twist, acceleration = plan.at(t)
        body = rotation.inv()
        data.qpos[:3], data.qpos[3:7] = position, quaternion(rotation.as_matrix())
        data.qvel[:3], data.qvel[3:6] = twist[:3], body.apply(twist[3:])
        data.qfrc_applied[:3] = TRAY_MASS * (acceleration[:3] - gravity)
        data.qfrc_applied[3:6] = TRAY_MASS * body.apply(acceleration[3:])
        place = body.apply(data.qpos[7:10] - position)
        if t >= 0:
            first = place if first is None else first
            furthest = max(furthest, float(np.linalg.norm(place - first)))
        mujoco.mj_step(model, data)
    return furthest
