"""Limits of the motion alone: points against Pinocchio and differences, norms, and loose things in closed form."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import yaml
from conftest import DATA
from draws import draws
from gantries import along_x, gantries, loop
from mrts_codegen.cell_model import build_cell_model
from random_cells import configuration, random_spatial_urdf
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

import mrts
from mrts.cell.cell_file import CellDescription
from mrts.cell.points import CarriedThing
from mrts.control.plant import quaternion
from mrts.limits.motion_limits import arm_point, norm_rows, object_point
from mrts.limits.rows import RowName

STEP = 1e-4
"""Of the simulation [s]."""

SETTLED = 0.1
"""Standstill before the motion, in which the block sinks into its contacts [s]."""

TRAY_MASS = 1e5
"""So heavy that the block moves it by nothing [kg]."""


class GeodesicPlan:
    """Pose and rates of an object that goes straight from pose to pose while it turns about one axis, by time."""

    def __init__(self, motion, faster):
        first, last = ((motion.position[at], Rotation.from_matrix(motion.rotation[at])) for at in (0, -1))
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


def slid(plan, thing, gravity, sides):
    """How far a block, its sides along a, b and the normal, is at most from where it stood on the tray [m]."""
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = STEP, gravity
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 1000
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.tolerance = 1e-12
    contact = {"friction": [thing.friction, 0, 0], "condim": 3, "solref": [1e-3, 1]}
    contact |= {"solimp": [0.99, 0.999, 1e-4, 0.5, 2]}
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


INSIDE = 1e-4
"""Share of the radius by which a polygon may be inside its circle."""

G = 9.81


def random_arm(rng, folder):
    """An arm of a random chain with a limited point on each of its links that moves, and where joints are held."""
    (folder / "arm.urdf").write_text(random_spatial_urdf(rng, 7), encoding="utf-8")
    held = {name: float(rng.uniform(-1, 1)) for name in ("j0", "j4", "to_finger")}
    links = ["l1", "l2", "l3", "l4", "l5", "l6", "finger", "camera", "flange", "tip"]
    frames = [{"link": link, "point": rng.uniform(-0.3, 0.3, 3).tolist(), "speed": 1.0} for link in links]
    chain = {"base_link": "l0", "tip_link": "tip", "posture": [0.0] * 5, "torque": [1.0] * 5}
    robot = {"name": "arm", "urdf": "arm.urdf", "fixed": held, "frames": frames} | chain
    cell = {"name": "one", "gravity": [0, 0, -G], "object": {"mass": 1, "inertia": [1, 1, 1]}, "robots": [robot]}
    path = folder / "cell.yaml"
    path.write_text(yaml.safe_dump(cell), encoding="utf-8")
    return build_cell_model(path, CellDescription.read_file(path, "cell file")).record.robots[0], held


@pytest.mark.parametrize("seed", range(draws(4)))
def test_points_of_an_arm_move_as_pinocchio_says(seed, tmp_path):
    """On links of the chain and off it, with a prismatic joint, held joints, and a base link that is not the root."""
    rng = np.random.default_rng([90, seed])
    robot, held = random_arm(rng, tmp_path)
    model = pin.buildModelFromUrdf(str(tmp_path / "arm.urdf"))
    base = model.getFrameId("l0")
    frames = []
    for point in robot.point_limits:
        link = model.frames[model.getFrameId(point.link)]
        placement = link.placement * pin.SE3(np.eye(3), np.array(point.point))
        frames.append(
            model.addFrame(pin.Frame(f"on {point.link}", link.parentJoint, placement, pin.FrameType.OP_FRAME))
        )
    data, names = model.createData(), list(model.names)[1:]
    q, dq, ddq = rng.uniform(-2, 2, (3, 20, len(robot.joints)))
    for sample in range(len(q)):
        given = [dict(zip(robot.joints, values[sample], strict=True)) for values in (q, dq, ddq)]
        full, speed, change = ([of.get(name, 0.0) for name in names] for of in (held | given[0], *given[1:]))
        pin.forwardKinematics(model, data, configuration(model, full), np.array(speed), np.array(change))
        pin.updateFramePlacements(model, data)
        R = data.oMf[base].rotation.T
        for point, frame in zip(robot.point_limits, frames, strict=True):
            here = (of[sample : sample + 1] for of in (q, dq, ddq))
            velocity, acceleration = arm_point(robot, point, *here)
            axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            theirs = R @ pin.getFrameVelocity(model, data, frame, axes).linear
            np.testing.assert_allclose(velocity[0], theirs, atol=1e-9 * np.linalg.norm(theirs))
            theirs = R @ pin.getFrameClassicalAcceleration(model, data, frame, axes).linear
            np.testing.assert_allclose(acceleration[0], theirs, atol=1e-9 * np.linalg.norm(theirs))


def test_points_of_the_object_move_as_differences_say(planar_cell, dual_ur5):
    for cell, name in ((planar_cell, "planar_dual_arm/lift"), (dual_ur5, "dual_ur5/lift_and_turn")):
        motion = mrts.follow_object(cell, mrts.load_motion(f"mrts/data/{name}.yaml"))
        point, step, time = np.array([0.3, -0.1, 0.2]), 1e-4, motion.object.time[5:-5]

        def place(at, motion=motion, point=point):
            position, rotation, *_ = motion.object.course(at)
            return position + rotation @ point

        before, here, after = (place(time + shift) for shift in (-step, 0.0, step))
        velocity, acceleration = (of[5:-5] for of in object_point(motion, point))
        np.testing.assert_allclose((after - before) / (2 * step), velocity, atol=1e-6 * np.max(np.abs(velocity)))
        found = (after - 2 * here + before) / step**2
        np.testing.assert_allclose(found, acceleration, atol=1e-5 * np.max(np.abs(acceleration)))


def random_pairs(rng, count):
    """Pairs p', p'' of very different sizes, some nearly parallel, parallel or zero, each Shape (n, 3)."""
    rate, square = rng.normal(size=(2, count, 3)) * 10.0 ** rng.uniform(-6, 6, (2, count, 1))
    along = rng.choice([-1, 1], (count, 1)) * 10.0 ** rng.uniform(-6, 6, (count, 1))
    apart = rng.choice([0.0, 1e-16, 1e-13, 1e-9, 1e-5], (count, 1)) * rng.normal(size=(count, 3))
    kind = rng.integers(4, size=(count, 1))
    few = rng.integers(-3, 4, (count, 3)) / rng.choice([3.0, 7.0, 10.0], (count, 1))  # where rounding has a pattern
    square = np.where(rng.random((count, 1)) < 0.5, few, square)
    near = along * (square + apart * np.linalg.norm(square, axis=1, keepdims=True))
    rate = np.where(kind == 0, near, np.where(kind == 1, np.where(rng.random((count, 1)) < 0.5, 0.0, rate), rate))
    return rate, np.where(kind == 2, 0.0, square)


@pytest.mark.parametrize("count", [3000, pytest.param(60_000, marks=pytest.mark.slow)])
def test_a_norm_is_a_polygon_inside_its_circle(count, planar_cell):
    """In the plane of (r̈, ṙ²): nowhere outside, at most 1e-4 inside; with r̈ = 0, and on a line, exactly."""
    rng = np.random.default_rng(91)
    for _ in range(count // 3000):
        rate, square = random_pairs(rng, 3000)
        rows = norm_rows(planar_cell, RowName("acceleration", "object", "linear", "m/s²"), rate, square, 1.0)
        sizes = np.stack([np.linalg.norm(of, axis=1) for of in (rate, square)])
        scale = 1 / np.where(sizes > 0, sizes, 1.0)
        nothing = np.zeros((len(rate), 6))
        for angle in (*rng.uniform(0, 2 * np.pi, 20), np.pi / 2):
            r, x = scale * [[np.cos(angle)], [abs(np.sin(angle))]]
            if angle == np.pi / 2:
                r = np.zeros(len(r))
            vector, used = rate * r[:, None] + square * x[:, None], np.zeros(len(rate))
            value = rows.value(nothing, nothing, r, np.sqrt(x))
            used, size = np.max(np.abs(value), axis=1), np.linalg.norm(vector, axis=1)
            rounding = 2e-12 * (np.abs(r) * sizes[0] + x * sizes[1])
            assert np.all(used >= size * (1 - 1e-12) - rounding)
            assert np.all(used <= size * (1 + INSIDE) + rounding)
            if angle == np.pi / 2:
                np.testing.assert_allclose(used, size, rtol=1e-12)


def with_cup(folder, gravity=(0, -G, 0), **cup):
    """Strong gantries in a vertical plane, whose object carries a cup."""
    cell = gantries(folder, gravity=gravity)
    strong = {"torque_lower": np.full(3, -1e6), "torque_upper": np.full(3, 1e6)}
    robots = tuple(replace(robot, **strong) for robot in cell.robots)
    return replace(cell, robots=robots, carried=(CarriedThing(**{"name": "cup", "normal": [0, 1, 0]} | cup),))


@pytest.mark.parametrize(
    ("cup", "share", "what"),
    [
        ({"friction": 0.3}, 0.3, "slips"),
        ({"half_width": [0.03, 0.02], "height": 0.1}, None, "tips"),
        ({"friction": 0.3, "half_width": [0.03, 0.03], "height": 0.03}, 0.3, "slips"),
        ({"friction": 0.9, "half_width": [0.03, 0.03], "height": 0.05}, 0.6, "tips"),
    ],
)
def test_a_cup_on_a_straight_way_in_closed_form(cup, share, what, tmp_path):
    """c² |p''| = g × friction, or g × half width / height along the way."""
    cell = with_cup(tmp_path, **cup)
    if share is None:
        along = int(np.argmax(np.abs(cell.carried[0].axes[:, 0])))
        share = cup["half_width"][along] / cup["height"]
    motion = along_x()
    end = mrts.scale(cell, motion).range.upper
    assert end.c2 == pytest.approx(share * G / np.max(np.abs(motion.acceleration[:, 0])), rel=1e-9)
    assert {str(row.name.failure) for row in end.rows} == {f"object/cup {what}"}
    fastest = mrts.retime(cell, motion)
    assert fastest.duration == pytest.approx(2 * np.sqrt(2 / (share * G)), rel=1e-6)


def test_a_cup_on_a_tilted_tray_is_not_held_at_any_speed(tmp_path):
    """Steeper than its friction: no factor at all, and the cup is named."""
    tilt = math.atan(0.35)
    for slope, held in ((tilt - 1e-3, True), (tilt + 1e-3, False)):
        cell = with_cup(tmp_path, gravity=(G * math.sin(slope), -G * math.cos(slope), 0), friction=0.35)
        found = mrts.scale(cell, along_x(profile="quintic"))
        assert found.status.admits_motion == held
        if not held:
            assert {row.name.contact for one in found.range.samples.conflicts for row in one.rows} == {"object/cup"}
            assert not mrts.retime(cell, along_x(profile="quintic")).status.admits_motion


def test_a_loop_must_be_fast_enough_for_a_cup(tmp_path):
    """Around the top of a circle, normal inward: at φ off the top c² R ω² >= g (cos φ + |sin φ| / friction)."""
    radius, speed, friction, phi = 0.5, 1.0, 0.4, np.linspace(-0.6, 0.6, 121)
    motion = loop((phi - phi[0]) / speed, phi, np.full(121, speed), np.zeros(121), radius)
    cell = replace(with_cup(tmp_path, friction=friction), object_acceleration_limit=np.array([40.0, np.inf]))
    turned = tuple(replace(robot, posture=np.array([0, 0, np.pi + 0.6])) for robot in cell.robots)
    found = mrts.scale(replace(cell, robots=turned), motion).range
    least = np.max(np.cos(phi) + np.abs(np.sin(phi)) / friction) * G / (radius * speed**2)
    assert found.lower.c2 == pytest.approx(least, rel=1e-9)
    assert found.upper.c2 == pytest.approx(40.0 / (radius * speed**2), rel=1e-9)
    assert {row.name.failure for row in found.lower.rows} == {"object/cup slips"}
    assert {str(row.name) for row in found.upper.rows} == {"object/linear acceleration"}
    plan = mrts.scale(replace(cell, robots=turned), motion, select=found.lower.c2 * (1 + 1e-6))
    sampled = plan.at_rate(200)  # one slower would drop it: it ends a step earlier
    assert sampled.trajectory.duration <= plan.trajectory.duration <= sampled.trajectory.duration + 2 / 200


STRONG = 1e6
"""Torques that bind nothing [N m]."""

STAYS, SLIDES = 1e-3, 5e-3
"""How far a block creeps that stays, and how far at least one goes that slides [m]."""

BLOCKS = {
    "on the box": {"at": [0.1, 0.05, 0.05]},
    # pushed along the normal it would bear any acceleration, and a contact of MuJoCo throws it up
    "on a tilted surface": {"at": [-0.1, 0.0, 0.05], "normal": [0.05, -0.1, 1.0]},
}


@pytest.mark.parametrize("place", ["on a tilted surface", pytest.param("on the box", marks=pytest.mark.slow)])
def test_a_block_stays_with_the_plan_and_slides_with_one_10_percent_faster(place, dual_ur5):
    """Lifted, moved aside and turned about a tilted axis, by limits of the block alone."""
    block = CarriedThing(name="block", friction=0.4, half_width=[0.04, 0.04], height=0.02, **BLOCKS[place])
    free = dual_ur5.without_wrench_limits().without_velocity_limits()
    strong = {"torque_lower": np.full(6, -STRONG), "torque_upper": np.full(6, STRONG)}
    cell = replace(free, robots=tuple(replace(robot, **strong) for robot in free.robots), carried=(block,))
    found = mrts.retime(cell, mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml"))
    motion = found.retimed.motion.object
    gone = [slid(GeodesicPlan(motion, faster), block, cell.gravity, [0.08, 0.08, 0.04]) for faster in (1.0, 1.1)]
    assert gone[0] < STAYS
    assert gone[1] > SLIDES
