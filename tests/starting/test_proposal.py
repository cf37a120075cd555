"""Proposed cells: hands as URDFs have them, at the sides of the box, facing it; what is assumed is said."""

import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yaml
from conftest import DATA
from published_robots import ROBOTS

import mrts
from mrts.base.errors import InputError, MotionError
from mrts.base.rigid_transform import RigidTransform, rotation_from_rpy
from mrts.cell.generation import arm_of_urdf, read_urdf
from mrts.cell.remarks import joint_assumptions
from mrts.starting.arm import Arm
from mrts.starting.hold import hold_here
from mrts.starting.layouts import layouts
from mrts.starting.proposal import cell_file, motion_file, propose
from mrts.starting.request import request_of
from mrts.starting.tips import first_link, hands

EXACT = 1e-12
"""Two ways to add up the same few numbers."""

FOUND = {
    "panda_description/urdf/panda.urdf": ("panda_link0", ["panda_hand_tcp"]),
    "kinova_description/robots/kinova.urdf": ("base", ["j2s6s200_end_effector"]),
    "z1_description/urdf/z1.urdf": ("world", ["gripperStator"]),
    "baxter_description/urdf/baxter.urdf": ("base", ["left_gripper", "right_gripper"]),
    "tiago_description/robots/tiago_dual.urdf": (
        "torso_lift_link",
        ["hand_left_grasping_frame", "hand_right_grasping_frame"],
    ),
    "talos_data/robots/talos_reduced.urdf": ("torso_2_link", ["wrist_left_ft_tool_link", "wrist_right_ft_tool_link"]),
    "romeo_description/urdf/romeo.urdf": ("torso", ["l_gripper", "r_gripper"]),
    "centauro_description/urdf/centauro.urdf": ("torso_2", ["ball1", "ball2"]),
    "alex_description/urdf/alex_sake_hands.urdf": ("Torso", ["LeftSakePalmLink", "RightSakePalmLink"]),
}
"""Where the chains begin, and the hands: with fingers, cameras and feet in the same file."""


def tree_of(path):
    return read_urdf(Path("here"), Path("/"), str(path))[1]


def arm_of(path, tip):
    return Arm(*arm_of_urdf(path, tree_of(path), None, tip), path)


@pytest.mark.parametrize("urdf", FOUND)
def test_hands_are_found_among_fingers_cameras_and_feet(urdf):
    tree = tree_of(ROBOTS / urdf)
    tips = sorted(hands(tree))
    assert (first_link(tree, tips), tips) == FOUND[urdf]


@pytest.mark.parametrize(
    ("urdf", "tip"),
    [
        ("panda_description/urdf/panda.urdf", "panda_hand_tcp"),
        ("tiago_description/robots/tiago.urdf", "hand_grasping_frame"),
    ],
)
def test_places_jacobians_and_torques_at_rest_are_those_of_pinocchio(urdf, tip):
    """Also of a chain with a joint that slides."""
    path = ROBOTS / urdf
    arm = arm_of(path, tip)
    model = pin.buildModelFromUrdf(str(path))
    data, frame = model.createData(), model.getFrameId(tip)
    places = [model.joints[model.getJointId(name)].idx_v for name in arm.robot.joints]
    q = np.random.default_rng(3).uniform(-1, 1, (3, len(places)))
    state = arm.at(q)
    force = np.array([3.0, -2.0, 5.0])
    torque = arm.torque(state, np.array([0, 0, -9.81]), force)
    for sample, joints in enumerate(q):
        whole = pin.neutral(model)
        for name, position in zip(arm.robot.joints, joints, strict=True):
            whole[model.joints[model.getJointId(name)].idx_q] = position
        pin.framesForwardKinematics(model, data, whole)
        jacobian = pin.computeFrameJacobian(model, data, whole, frame, pin.LOCAL_WORLD_ALIGNED)[:, places]
        wanted = pin.computeGeneralizedGravity(model, data, whole)[places] + jacobian[:3].T @ force
        assert state.p[sample] == pytest.approx(data.oMf[frame].translation, abs=EXACT)
        assert state.R[sample] == pytest.approx(data.oMf[frame].rotation, abs=EXACT)
        assert state.jacobian[sample] == pytest.approx(jacobian, abs=EXACT)
        assert torque[sample] == pytest.approx(wanted, abs=1e3 * EXACT)


UR5 = DATA.parent / "dual_ur5" / "ur5_class_arm.urdf"
PLANAR = DATA / "planar_arm.urdf"
BAXTER = ROBOTS / "baxter_description" / "urdf" / "baxter.urdf"

PLACED = 1e-5
"""Of a hand [m, rad]: postures are written with six decimals."""


def requested(*robots, folder=DATA, **others):
    return request_of(folder, robots=[str(robot) for robot in robots], **{"name": "cell"} | others)


@pytest.fixture(scope="module")
def two_ur5(dual_ur5):
    assert dual_ur5.library  # the chains of the proposal, which need no other compilation
    return propose(requested(UR5, tips=["tool0", "tool0"], mass=4.0))


def test_both_hands_face_the_box_from_its_two_sides(two_ur5):
    """Positions by Pinocchio from what the files say, not by the search's own kinematics."""
    keys = yaml.safe_load(cell_file(two_ur5))
    start = np.array(yaml.safe_load(motion_file(two_ur5))["start"]["xyz"])
    model = pin.buildModelFromUrdf(str(UR5))
    data, frame = model.createData(), model.getFrameId("tool0")
    sides = []
    for robot in keys["robots"]:
        pin.framesForwardKinematics(model, data, np.array(robot["posture"]))
        base = pin.SE3(rotation_from_rpy(*robot["base"].get("rpy", [0, 0, 0])), np.array(robot["base"]["xyz"]))
        tip = base * data.oMf[frame]
        held = pin.SE3(rotation_from_rpy(*robot["grasp"].get("rpy", [0, 0, 0])), start + robot["grasp"]["xyz"])
        assert np.max(np.abs(pin.log6(tip.actInv(held)).vector)) < PLACED
        side = tip.translation - start
        assert tip.rotation[:, 2] @ side == pytest.approx(-np.linalg.norm(side), rel=PLACED)  # z of tool0 is its tool
        sides.append(side)
        assert base.translation[2] == 0
        assert (base.translation - start)[:2] @ side[:2] > 0  # each arm stands on the side of its hand
    assert sides[0] == pytest.approx(-sides[1], abs=PLACED)
    assert two_ur5.layout.sides[0] == pytest.approx(np.linalg.norm(sides[0] - sides[1]), rel=0.05)


def test_what_is_written_is_what_was_tried_and_has_room(two_ur5, tmp_path):
    cell, motion = tmp_path / "cell.yaml", tmp_path / "motion.yaml"
    text = cell_file(two_ur5)
    cell.write_text(text.replace(two_ur5.cell["robots"][0]["urdf"], str(UR5)), encoding="utf-8")
    motion.write_text(motion_file(two_ur5), encoding="utf-8")
    result = mrts.scale(mrts.load_cell(cell), mrts.load_motion(motion))
    assert result.range.upper.c2 == pytest.approx(two_ur5.result.range.upper.c2, rel=1e-9)
    assert result.range.upper.c2 >= 4  # twice as fast
    assert result.cell.mass == 4.0
    assert not {warning.code for warning in result.warnings} & {"other-start"}
    assert mrts.load_motion(motion).position[-1, 2] > mrts.load_motion(motion).position[0, 2]
    start = np.concatenate([robot["posture"] for robot in two_ur5.cell["robots"]])
    assert two_ur5.result.motion.q[0] == pytest.approx(start, abs=1e-6)


def test_a_flange_beyond_its_tip_stays_out_of_the_box(tmp_path):
    """A collar around tool0, as of arms whose last mesh reaches beyond the origin of the last link."""
    collar = '<link name="tool0"><visual><geometry><box size="0.09 0.09 0.09"/></geometry></visual>'
    text = UR5.read_text(encoding="utf-8")
    assert text.count('<link name="tool0"/>') == 1
    (tmp_path / "arm.urdf").write_text(text.replace('<link name="tool0"/>', f"{collar}</link>"), encoding="utf-8")
    plain, collared = (layouts(requested(urdf, tips=["tool0"] * 2), 2.0)[0] for urdf in (UR5, tmp_path / "arm.urdf"))
    apart = [np.linalg.norm(np.subtract(*(stand.T_world_tip.p for stand in one.stands))) for one in (plain, collared)]
    assert apart[0] == pytest.approx(apart[1])
    assert collared.sides[0] == pytest.approx(apart[1] - 2 * 0.045, abs=1e-3)


def test_too_heavy_a_load_gives_way_and_the_file_says_so(dual_ur5):
    assert dual_ur5.library
    proposal = propose(requested(UR5, mass=400.0))
    assert proposal.mass < 400
    assert proposal.result.range.upper.c2 > 1
    assert "# 400 were asked for, which the motors cannot hold" in cell_file(proposal)


def test_an_arm_without_efforts_gets_torques_that_hold_it(dual_ur5, tmp_path):
    """Twice its worst torque at rest: more than the arm and its share of the load take at the start."""
    assert dual_ur5.library
    text = UR5.read_text(encoding="utf-8")
    (tmp_path / "arm.urdf").write_text(re.sub(r'effort="[^"]*"', 'effort="0"', text), encoding="utf-8")
    request = requested(tmp_path / "arm.urdf")
    proposal = propose(request)
    assert "# assumed: the URDF has no effort. Put the data sheet's here" in cell_file(proposal)
    assert "no-effort-limit" in {remark.code for remark in joint_assumptions([request.arms[0].robot])}
    assert all(np.all(np.isinf(each.robot.torque_upper)) for each in request.arms)
    assert proposal.result.range.upper.c2 >= 4
    sides = [robot["grasp"]["xyz"][0] for robot in proposal.cell["robots"]]
    assert sides[0] == -sides[1] != 0


def test_arms_of_one_machine_hold_in_front_of_it():
    """Without a compiler: the layout alone. Left is left, and the bases are the URDF's."""
    request = requested(BAXTER)
    assert request.one_machine
    best = layouts(request, 2.0)[0]
    assert best.position[0] > 0.2
    left, right = best.stands
    assert left.T_world_tip.p[1] > best.position[1] > right.T_world_tip.p[1]
    model = pin.buildModelFromUrdf(str(BAXTER))
    data, whole = model.createData(), pin.neutral(model)
    for each, stand in zip(request.arms, best.stands, strict=True):
        chain = each.robot
        assert np.all((stand.posture >= chain.position_lower) & (stand.posture <= chain.position_upper))
        for joint, position in zip(chain.joints, stand.posture, strict=True):
            whole[model.joints[model.getJointId(joint)].idx_q] = position
    pin.framesForwardKinematics(model, data, whole)
    for each, stand in zip(request.arms, best.stands, strict=True):
        tip = data.oMf[model.getFrameId(each.robot.source.tip_link)]
        assert tip.translation == pytest.approx(stand.T_world_tip.p, abs=PLACED)
        assert tip.rotation == pytest.approx(stand.T_world_tip.R, abs=PLACED)


def test_bases_that_are_given_stay():
    bases = [
        RigidTransform.from_xyz_rpy([-0.6, 0.1, 0.3], [0, 0, 0.5]),
        RigidTransform(np.eye(3), np.array([0.6, 0, 0.3])),
    ]
    found = layouts(requested(UR5, bases=bases), 2.0)
    for stand, base in zip(found[0].stands, bases, strict=True):
        assert stand.T_world_base.p == pytest.approx(base.p)
        assert np.allclose(stand.T_world_base.R, base.R)
    assert len(found) > 1
    assert found[0].score >= found[-1].score > 0
    apart = [RigidTransform(np.eye(3), np.array([x, 0.0, 0.0])) for x in (-3, 3)]
    with pytest.raises(MotionError, match="no posture was found"):
        layouts(requested(UR5, bases=apart), 2.0)


@pytest.mark.parametrize(
    ("robots", "others", "said"),
    [
        ([UR5], {"tips": ["tool"]}, r"--tip = 'tool': there is no such link in ur5_class_arm\.urdf; its links are"),
        ([UR5], {"tips": ["wrist_1"]}, "has 4 joints, and holding an object takes 6"),
        ([UR5], {"bases": [RigidTransform.identity()]}, "--base = 1: give it once for each robot, in their order: 2"),
        ([BAXTER, UR5], {}, "--base: is needed for each robot where one has several arms"),
        ([PLANAR], {}, "no link that so many joints move: holding an object takes 6; .* the one of `mrts demo`"),
        ([ROBOTS / "hector_description" / "robots" / "quadrotor_base.urdf"], {}, "no link that so many joints move"),
    ],
)
def test_what_cannot_be_begun_says_what_to_do(robots, others, said):
    with pytest.raises(InputError, match=said):
        requested(*robots, **others)


START = [0.03, 0.15, 0.4]
TURN = [0.1, -0.2, 0.3]

SAME = 1e-9
"""Rounding of poses; nothing is searched."""


@pytest.mark.quick
def test_the_arms_start_at_their_postures(dual_ur5):
    """Where the compiled kinematics, not the ones that found the grasps, have the hands."""
    held = hold_here(dual_ur5, START, TURN)
    q = np.concatenate([robot.posture for robot in held.robots])
    keys = {"xyz": START, "rpy": TURN}
    end = {"xyz": [0.03, 0.15, 0.41], "rpy": TURN}
    motion = mrts.load_motion({"start": keys, "end": end, "duration": 1.0, "profile": "cubic"})
    assert mrts.follow_object(held, motion).q[0] == pytest.approx(q, abs=SAME)
    assert [robot.T_world_base for robot in held.robots] == [robot.T_world_base for robot in dual_ur5.robots]
