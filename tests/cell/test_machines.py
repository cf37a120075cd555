"""Arms of one machine: a joint that both would move is refused; held still, it is where Pinocchio puts it."""

import re
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest
import yaml
from conftest import DATA
from mrts_codegen.cell_model import build_cell_model
from mrts_codegen.equations.dynamics import forward_kinematics, inverse_dynamics, joint_steps
from mrts_codegen.urdf.held_joints import held_positions
from mrts_codegen.urdf.robot_model import build_robot_model
from mrts_codegen.urdf.urdf_file import parse_urdf
from published_robots import ROBOTS
from random_cells import configuration
from same_cells import same_cell

import mrts
from mrts.cell.cell_file import CellDescription

TURN = 0.3
"""Position of the turntable in the cells below [rad]."""

ARM = (DATA / "planar_arm.urdf").read_text(encoding="utf-8")


def machine():
    """The shipped cell's two arms on one torso that slides up on a turning column; a flap hangs on the left forearm."""
    parts = ['<robot name="machine"><link name="root"/><link name="column"/><link name="torso"/>']
    for side, x in (("left", 0.0), ("right", 2.5)):
        body = ARM[ARM.index("<link") : ARM.index("</robot>")]
        parts.append(re.sub(r'(name|link)="(\w+)"', rf'\1="{side}_\2"', body))
        parts.append(
            f'<joint name="{side}_mount" type="fixed"><parent link="torso"/><child link="{side}_base_link"/>'
            f'<origin xyz="{x} 0 0"/></joint>'
        )
    for name, kind, parent, child, axis in (
        ("turn", "continuous", "root", "column", "0 0 1"),
        ("lift", "prismatic", "column", "torso", "0 1 0"),
    ):
        parts.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>'
            '<limit lower="0" upper="0.5" effort="1000" velocity="1"/></joint>'
        )
    return "\n".join([*parts, "</robot>"])


def machine_cell(folder, change=None):
    """Both arms from the root, the torso neither held nor passed; `change` is done to the robots of the cell file."""
    (folder / "machine.urdf").write_text(machine(), encoding="utf-8")
    description = yaml.safe_load((DATA / "cell.yaml").read_text())
    for robot in description["robots"]:
        # so that the torso, turned by 0.3 rad and 0.4 m up, carries the arms where the shipped ones stand
        up = 0.4 * np.array([-np.sin(TURN), np.cos(TURN)])
        back = np.array([[np.cos(TURN), np.sin(TURN)], [-np.sin(TURN), np.cos(TURN)]])
        robot |= {"urdf": "machine.urdf", "base_link": "root", "tip_link": f"{robot['name']}_contact"}
        robot["base"] = {"xyz": [*(-back @ up).tolist(), 0], "rpy": [0, 0, -TURN]}
    if change is not None:
        change(description["robots"])
    for robot in description["robots"]:
        extra = ("turn", "lift")[: 0 if robot["base_link"] == "torso" else 2]
        moving = [name for name in extra if name not in robot.get("fixed", {})]
        robot["posture"] = [0.0] * len(moving) + robot["posture"]
        robot["torque"] = [1000.0] * len(moving) + robot["torque"]
    (folder / "cell.yaml").write_text(yaml.safe_dump(description), encoding="utf-8")
    return folder / "cell.yaml"


pytestmark = pytest.mark.quick

TALOS = ROBOTS / "talos_data/robots/talos_full_v2.urdf"
TIAGO = ROBOTS / "tiago_description/robots/tiago_dual.urdf"
TOLERANCE = 1e-10  # relative; both sides are exact recursions

GRAVITY = [0.3, -0.2, -9.81]
STEP = np.array([0.1, 0.0, 0.0])


def hold(**positions):
    def change(robots):
        for robot in robots:
            robot["fixed"] = dict(positions)

    return change


def read(path):
    return build_cell_model(path, CellDescription.read_file(path, "cell file"))


def test_a_shared_joint_is_refused_with_the_ways_out(tmp_path):
    path = machine_cell(tmp_path)
    with pytest.raises(mrts.InputError, match=r"'left' and 'right' .* move its joints 'turn', 'lift'") as refused:
        read(path)
    assert "'fixed: {turn: POSITION, lift: POSITION}' in both robots" in str(refused.value)
    assert "'base_link: torso'" in str(refused.value)


def test_held_still_the_machine_is_the_shipped_cell(tmp_path, planar_cell, lift):
    """The torso turned and lifted to where the shipped arms stand: the same range, the same torques."""
    cell = mrts.load_cell(machine_cell(tmp_path, hold(turn=TURN, lift=0.4)))
    assert [robot.joints for robot in cell.robots] == [
        tuple(f"{side}_{joint}" for joint in planar_cell.robots[0].joints) for side in ("left", "right")
    ]
    assert cell.robots[0].held == {"turn": TURN, "lift": 0.4}
    ours, theirs = mrts.scale(cell, lift), mrts.scale(planar_cell, lift)
    # wrench limits are in base axes, and the machine's base is turned: compared without
    free = [mrts.scale(each.without_wrench_limits(), lift) for each in (cell, planar_cell)]
    assert free[0].range.upper.c2 == pytest.approx(free[1].range.upper.c2, rel=1e-9)
    np.testing.assert_allclose(free[0].trajectory.torque, free[1].trajectory.torque, atol=1e-6)
    np.testing.assert_allclose(ours.motion.q, theirs.motion.q, atol=1e-9)


def other_path(robots):
    robots[1]["urdf"] = str(Path(robots[1]["urdf"]).parent / "copy.urdf")


def torn(robots):
    """The right arm starts past the torso, where the left arm's posture of the torso (zero) has it."""
    robots[1]["base_link"] = "torso"


def twice(robots):
    robots[1]["tip_link"] = robots[0]["tip_link"]


def differently(robots):
    robots[0]["fixed"], robots[1]["fixed"] = {"turn": 0, "lift": 0.1}, {"turn": 0, "lift": 0.2}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (other_path, "both move its joints 'turn', 'lift'"),
        (twice, "one and the same arm: .* Give each its own 'base'"),
        (torn, "'left' moves its joints 'turn', 'lift', on which 'right' is taken to"),
        (differently, "'lift' is held at 0.1 by one and at 0.2 by the other"),
    ],
)
def test_one_machine_is_seen_through_paths_and_base_links(change, said, tmp_path):
    (tmp_path / "copy.urdf").write_text(machine(), encoding="utf-8")
    with pytest.raises(mrts.InputError, match=said):
        read(machine_cell(tmp_path, change))


@pytest.mark.parametrize(
    ("fixed", "message"),
    [
        ({"lft": 0.1}, r"robots\[0\] \(left\).fixed.lft: machine.urdf has no such joint; did you mean 'lift'\?"),
        ({"left_mount": 0.1}, r"fixed.left_mount: this joint is of type 'fixed' and does not move anyway"),
        ({"lift": 0.6}, r"fixed.lift = 0.6: must be within the joint's limits, \[0, 0.5\] m"),
        ({"left_shoulder": 0, "left_elbow": 0, "left_wrist": 0, "turn": 0, "lift": 0}, "no joint moves between"),
    ],
)
def test_what_cannot_be_held_is_refused(fixed, message, tmp_path):
    path = machine_cell(tmp_path)
    description = yaml.safe_load(path.read_text())
    description["robots"][0]["fixed"] = fixed
    path.write_text(yaml.safe_dump(description))
    with pytest.raises(mrts.InputError, match=message):
        read(path)


@pytest.mark.parametrize(
    ("path", "tip", "fixed"),
    [
        (TIAGO, "arm_right_tool_link", {"torso_lift_joint": 0.3, "arm_right_3_joint": 1.1}),
        (TALOS, "gripper_left_base_link", {"torso_1_joint": 0.4, "torso_2_joint": 0.2, "gripper_left_joint": -0.5}),
    ],
    ids=["tiago right", "talos left"],
)
def test_held_joints_equal_pinocchios_locked_ones(path, tip, fixed):
    """On the chain, before it, beyond it, on a branch that hangs from it; what mimics a held joint has moved too."""
    urdf = parse_urdf(path, path.read_bytes())
    held = held_positions(Path("cell.yaml"), "fixed", path, urdf, fixed)
    arm = build_robot_model(path, urdf, None, tip, held)
    full = pin.buildModelFromUrdf(str(path))
    supports = set(full.supports[full.frames[full.getFrameId(tip)].parentJoint])
    at = pin.neutral(full)
    lock = [joint for joint in range(1, full.njoints) if joint not in supports or full.names[joint] in held]
    for joint in lock:
        value, start = held.get(full.names[joint], 0.0), full.joints[joint].idx_q
        wide = full.joints[joint].nq == 2
        at[start : start + full.joints[joint].nq] = [np.cos(value), np.sin(value)] if wide else [value]
    model = pin.buildReducedModel(full, lock, at)
    assert [joint.name for joint in arm.joints] == list(model.names)[1:]
    model.gravity.linear = np.array(GRAVITY)
    data, frame = model.createData(), model.getFrameId(tip)
    symbols = [ca.SX.sym(name, len(arm.joints)) for name in ("q", "dq", "ddq")]
    steps = joint_steps(arm, symbols[0])
    R_tip, p_tip = forward_kinematics(arm, steps)[-1]
    outputs = [inverse_dynamics(arm, steps, *symbols[1:], GRAVITY), p_tip, R_tip]
    ours = ca.Function("arm", symbols, outputs)
    rng = np.random.default_rng(5)
    for _ in range(20):
        q, dq, ddq = rng.uniform(-2, 2, (3, len(arm.joints)))
        torque, p, R = (np.array(value) for value in ours(q, dq, ddq))
        theirs = pin.rnea(model, data, configuration(model, q), dq, ddq)
        pin.framesForwardKinematics(model, data, configuration(model, q))
        place = data.oMf[frame]
        for value, expected in ((torque[:, 0], theirs), (p[:, 0], place.translation), (R, place.rotation)):
            np.testing.assert_allclose(value, expected, rtol=0, atol=TOLERANCE * (1 + np.max(np.abs(expected))))


def test_one_base_of_a_machine_does_not_move_alone(tmp_path):
    cell = mrts.load_cell(machine_cell(tmp_path, hold(turn=TURN, lift=0.4)))
    assert cell.machines == (("left", "right"),)
    left, right = cell.robots
    for change in (
        lambda: cell.with_values({"robots.left.base.xyz": left.T_world_base.p + STEP}),
        lambda: cell.with_values({"robots.right.base.rpy": [0, 0, 0.2]}),
        lambda: replace(cell, robots=(replace(left, T_world_base=right.T_world_base @ left.T_world_base), right)),
    ):
        with pytest.raises(mrts.InputError, match=r"are arms of one machine .* move together\. Give both"):
            change()
    step = mrts.RigidTransform.from_xyz_rpy([0.1, -0.2, 0], [0, 0, 0.4])
    moved = tuple(replace(robot, T_world_base=step @ robot.T_world_base) for robot in cell.robots)
    together = replace(cell, robots=moved)
    assert same_cell(mrts.Cell.from_description(yaml.safe_load(together.to_yaml())), together)
    assert cell.with_values({"robots.left.grasp.xyz": left.T_object_tip.p}).with_mass(1.0).robots[1] is right
