"""Arms with more joints than the grasp takes: the joint positions that they prefer, on real robots."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from followed_motions import assert_consistent, motion
from published_robots import ROBOTS
from scipy.optimize import minimize
from shipped_cells import cell_of_arms

import mrts
import mrts.following.tracking
from mrts.cell.cell import cell_to_compile
from mrts.following.coordinate import coordinate
from mrts.following.tracking import LIMIT_PUSH, LIMIT_ZONE, NARROWEST_ZONE, WIDEST_ZONE, is_redundant

PANDA = {"urdf": "panda_description/urdf/panda.urdf", "tip_link": "panda_hand_tcp"}
UR5 = {"urdf": "ur_description/urdf/ur5_robot.urdf", "tip_link": "tool0"}
TALOS = {"urdf": "talos_data/robots/talos_full_v2.urdf", "base_link": "torso_2_link"}
OPPOSITE = ((-0.65, 0, 0, 0), (0.65, 0, 0, np.pi))
BEFORE_THE_CHEST = {"left": [0.081, 0.213, 1.278, -1.159, -0.699, 0.707, -0.007]}
BEFORE_THE_CHEST["right"] = (np.array([-1, -1, -1, 1, -1, -1, -1]) * BEFORE_THE_CHEST["left"]).tolist()

SAME_PATH = 1e-9
"""Paths of one motion in other samples, or by CasADi: both are solved to 1e-10 in the tip's pose."""


def limit_zone(robot):
    """Width of the zone beside each joint's position limits, Shape (n_i,) [rad or m]."""
    return np.clip(LIMIT_ZONE * (robot.position_upper - robot.position_lower), NARROWEST_ZONE, WIDEST_ZONE)


def stretched(robot, q):
    """h(q) of `mrts.following.tracking`, Shape (T, n_i)."""
    beyond = q - robot.position_upper, robot.position_lower - q
    over, under = (np.maximum(side / limit_zone(robot) + 1, 0) for side in beyond)
    return q + LIMIT_PUSH * (over**5 - under**5)


def both_hands(kind, postures, places=((0, 0, 0, 0),) * 2):
    """Arms in their places [m, m, m, rad about z] by name, at postures that will hold the grasps."""
    return {name: kind | {"posture": postures[name], "place": places[index]} for index, name in enumerate(postures)}


def held_cell(folder, arms, load=cell_to_compile):
    """A cell whose arms hold the object at their postures, and where the object then is: between the hands."""
    tips = {}
    for name, arm in arms.items():
        model = pin.buildModelFromUrdf(str(ROBOTS / arm["urdf"]))
        chain = chain_joints(model, arm)
        q = pin.neutral(model)
        for joint, value in zip(chain, arm["posture"], strict=True):
            at = model.joints[joint]
            q[at.idx_q : at.idx_q + at.nq] = value if at.nq == 1 else [np.cos(value), np.sin(value)]
        data = model.createData()
        pin.framesForwardKinematics(model, data, q)
        base = data.oMf[model.getFrameId(arm["base_link"])] if "base_link" in arm else pin.SE3.Identity()
        *xyz, yaw = arm["place"]
        place = pin.SE3(pin.rpy.rpyToMatrix(0, 0, yaw), np.array(xyz, dtype=float))
        tips[name] = place * base.inverse() * data.oMf[model.getFrameId(arm["tip_link"])]
    middle = np.mean([tip.translation for tip in tips.values()], axis=0)
    robots = [
        {
            "name": name,
            "urdf": str(ROBOTS / arm["urdf"]),
            "tip_link": arm["tip_link"],
            "base": {"xyz": list(arm["place"][:3]), "rpy": [0, 0, float(arm["place"][3])]},
            "grasp": {
                "xyz": (tips[name].translation - middle).tolist(),
                "rpy": pin.rpy.matrixToRpy(tips[name].rotation).tolist(),
            },
            "posture": [float(value) for value in arm["posture"]],
            "torque": [100.0] * len(arm["posture"]),
        }
        | ({"base_link": arm["base_link"]} if "base_link" in arm else {})
        for name, arm in arms.items()
    ]
    return load(cell_of_arms(folder, *robots, inertia=[0.01, 0.02, 0.02])), middle


def chain_joints(model, arm):
    """Indices of the joints from the base link to the tip, base first."""
    joint = model.frames[model.getFrameId(arm["tip_link"])].parentJoint
    above = model.frames[model.getFrameId(arm["base_link"])].parentJoint if "base_link" in arm else 0
    chain = []
    while joint != above:
        chain.insert(0, joint)
        joint = model.parents[joint]
    return chain


def from_to(middle, step, **changes):
    return motion((np.array(middle) + step).tolist(), start=np.array(middle).tolist(), **changes)


def margin(cell, q):
    """How far inside its limits the nearest joint stays [rad or m]."""
    lower, upper = (
        np.concatenate([getattr(robot, name) for robot in cell.robots]) for name in ("position_lower", "position_upper")
    )
    return float(np.min(np.minimum(q - lower, upper - q)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("panda_and_ur5")


@pytest.fixture(scope="module")
def panda_and_ur5(folder):
    """A redundant arm and one that is not."""
    arms = both_hands(PANDA, {"left": [0.0, 0.3, 0.0, -2.0, 0.0, 2.3, 0.8]}, OPPOSITE)
    arms |= both_hands(UR5, {"right": [0.3, -1.2, 1.8, -2.2, -1.5, 0.2]}, OPPOSITE[1:])
    cell, middle = held_cell(folder, arms, mrts.load_cell)
    assert [is_redundant(cell, robot) for robot in cell.robots] == [True, False]
    return cell, middle


@pytest.fixture(scope="module")
def talos(tmp_path_factory):
    arms = both_hands(TALOS, BEFORE_THE_CHEST)
    for name, arm in arms.items():
        arm["tip_link"] = f"gripper_{name}_base_link"
    return held_cell(tmp_path_factory.mktemp("talos"), arms)


def test_of_all_positions_that_hold_the_grasp_the_nearest_to_the_start_are_taken(panda_and_ur5):
    cell, middle = panda_and_ur5
    followed = mrts.follow_object(cell, from_to(middle, [0.03, 0.08, 0.1], rpy=(0.1, 0.0, 0.2)))
    assert_consistent(cell, followed)
    robot, start, end = cell.robots[0], followed.q[0, :7], followed.q[-1, :7]
    np.testing.assert_allclose(start, robot.posture, atol=1e-9)  # it holds the grasp
    poses = cell.functions("kinematics", 1, {"q": followed.q[-1:]})

    def off_the_grasp(q):
        ours = cell.functions("kinematics", 1, {"q": np.concatenate([q, followed.q[-1, 7:]])[None]})
        gap = (ours["position"] - poses["position"])[0, :, 0]
        return np.concatenate([gap, pin.log3(ours["rotation"][0, :, :3] @ poses["rotation"][0, :, :3].T)])

    reference = stretched(robot, start[None])[0]

    def distance(q):
        """The integral of h(q) - h(start)."""
        zone = limit_zone(robot)
        depth = np.maximum([(q - robot.position_upper) / zone + 1, (robot.position_lower - q) / zone + 1], 0)
        return np.sum(q**2 / 2 + LIMIT_PUSH * zone / 6 * np.sum(depth**6, axis=0) - reference * q)

    nearest = minimize(
        distance,
        end + 0.05,
        constraints={"type": "eq", "fun": off_the_grasp},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 200},
    )
    np.testing.assert_allclose(end, nearest.x, atol=1e-6)
    with pytest.raises(mrts.MotionError, match=r"square Jacobian: robot 'left' has 7 joints and 6"):
        mrts.scale(cell, followed, formulation="torque")


def test_a_posture_is_preferred_at_the_start(panda_and_ur5):
    """Of all positions that hold the grasp, the start is the nearest to the posture."""
    cell, middle = panda_and_ur5
    given = from_to(middle, [0.03, 0.08, 0.08])
    for first in (0.0, 0.3):
        moved = cell.with_postures({"left": [first, 0.3, 0.0, -2.0, 0.0, 2.3, 0.8]})
        start = mrts.follow_object(moved, given).q[0, :7]
        J = cell.functions("kinematics", 1, {"q": np.concatenate([start, np.zeros(6)])[None]})["jacobian"][0][:, :7]
        null = np.eye(7) - np.linalg.pinv(J) @ J
        h, wanted = (stretched(moved.robots[0], q[None])[0] for q in (start, moved.robots[0].posture))
        assert np.max(np.abs(null @ (h - wanted))) < 1e-8


def test_a_path_depends_neither_on_samples_nor_on_speed(panda_and_ur5):
    cell, middle = panda_and_ur5
    given = {"step": [0.05, -0.05, 0.12], "rpy": (0.1, 0.0, 0.2)}
    fine = mrts.follow_object(cell, from_to(middle, **given))
    coarse = mrts.follow_object(cell, from_to(middle, **given, samples=51))
    slow = mrts.follow_object(cell, from_to(middle, **given, duration=8.0))
    for order, name in enumerate(("q", "dq", "ddq")):
        value = getattr(fine, name)
        tolerance = SAME_PATH * (1 + np.max(np.abs(value)))
        np.testing.assert_allclose(getattr(coarse, name), value[::4], atol=tolerance)
        np.testing.assert_allclose(getattr(slow, name) * 10**order, value, atol=tolerance)


def test_given_joints_of_redundant_arms_are_moved_as_little_as_needed(panda_and_ur5):
    """Given joints a little off the grasps, with a motion of their own in the null space: that is kept."""
    cell, middle = panda_and_ur5
    followed = mrts.follow_object(cell, from_to(middle, [0.03, 0.08, 0.08], rpy=(0.1, 0.0, 0.2)))
    time = followed.object.time
    rate = 2 * np.pi / time[-1]
    angle = rate * time[:, None] + np.arange(13)
    wave = 4e-4 * np.array([np.sin(angle), rate * np.cos(angle), -(rate**2) * np.sin(angle)])
    parts = followed.q + wave[0], followed.dq + wave[1], followed.ddq + wave[2]
    found = coordinate(cell, mrts.CoordinatedMotion(followed.object, *parts))
    assert [remark.code for remark in found.remarks] == ["chain-closed"]
    assert_consistent(cell, found, tolerance=1e-4)
    J = cell.functions("kinematics", found.samples, {"q": found.q})["jacobian"]
    null = np.eye(7) - np.linalg.pinv(J[:, :, :7]) @ J[:, :, :7]
    for ours, given in ((found.dq, parts[1]), (found.ddq, parts[2])):
        assert np.max(np.abs(np.einsum("nij,nj->ni", null, (ours - given)[:, :7]))) < 1e-9


def test_talos_lifts_with_both_hands_inside_its_limits(talos, monkeypatch):
    """0.3 m before the chest; without the limits' push a wrist passes its limit."""
    cell, middle = talos
    given = from_to(middle, [0, 0, 0.3], samples=41)
    followed = mrts.follow_object(cell, given)
    assert margin(cell, followed.q) > 0.01
    assert_consistent(cell, followed, tolerance=1e-4)  # so few samples: errors of the rule that integrates here
    monkeypatch.setattr(mrts.following.tracking, "LIMIT_PUSH", 0.0)
    with pytest.raises(mrts.MotionError, match=r"passes a position limit .* 'arm_(left|right)_7_joint'"):
        mrts.follow_object(replace(cell), given)  # what is known of a cell is kept


def test_velocities_and_accelerations_are_derivatives_where_limits_push(talos):
    cell, middle = talos
    followed = mrts.follow_object(cell, from_to(middle, [0, 0, 0.3], samples=201))
    robot = cell.robots[0]
    assert np.max(np.abs(stretched(robot, followed.q[:, :7]) - followed.q[:, :7])) > 1  # they do
    assert_consistent(cell, followed)
