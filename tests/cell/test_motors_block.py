"""The `motors` of a cell file: what is refused and how, where friction comes from, and what keeps it."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
import yaml
from conftest import DATA

import mrts
from mrts.cell.motors.joint_motors import torque_speed_lines
from mrts.cli import main

pytestmark = pytest.mark.quick

TORQUE = {"left": [150, 150, 28], "right": [150, 150, 28]}
"""[N m]: what the mistakes below are measured against."""

FALLING = [[0, 200], [2, 200], [6, 80]]


@pytest.fixture
def files(tmp_path):
    """A copy of the shipped planar cell to change."""
    for path in DATA.iterdir():
        shutil.copy(path, tmp_path / path.name)
    return tmp_path


def with_motors(files, motors, **urdf):
    """The cell file with these motors of its left robot; `urdf` gives <dynamics> to a joint of both."""
    data = yaml.safe_load((files / "cell.yaml").read_text())
    for robot in data["robots"]:
        robot["torque"] = TORQUE[robot["name"]]
        if robot["name"] == "left" and motors is not None:
            robot["motors"] = motors
    (files / "cell.yaml").write_text(yaml.safe_dump(data))
    arm = files / "planar_arm.urdf"
    text = arm.read_text()
    for joint, dynamics in urdf.items():
        head, tail = text.split(f'<joint name="{joint}"', 1)
        text = f'{head}<joint name="{joint}"{tail.replace("</joint>", f"<dynamics {dynamics}/></joint>", 1)}'
    arm.write_text(text)
    return files / "cell.yaml"


MISTAKES = {
    "negative armature": ({"armature": -0.1}, ["robots[0] (left).motors.armature[0]", "-0.1", "must be >= 0"]),
    "wrong length": (
        {"friction": {"coulomb": [1, 2]}},
        [
            "robots[0] (left).motors.friction.coulomb",
            "[1.0, 2.0]",
            "one number for all joints, or 3",
            "shoulder, elbow, wrist",
        ],
    ),
    "negative friction": (
        {"friction": {"coulomb": [1, -2, 0]}},
        ["robots[0] (left).motors.friction.coulomb[1]", "-2", "must be >= 0"],
    ),
    "friction of another form": (
        {"friction": [1, 2, 3]},
        ["robots[0].motors.friction = [1, 2, 3]", "'none'", "coulomb, viscous"],
    ),
    "friction above the torque": (
        {"friction": {"coulomb": [1, 1, 28]}},
        ["robots[0] (left).motors.friction.coulomb[2]", "'wrist' is 28", "-28 to 28"],
    ),
    "torque rate negative": (
        {"torque_rate": [5, -5, 5]},
        ["robots[0] (left).motors.torque_rate[1]", "-5", "must be > 0"],
    ),
    "rising curve": (
        {"torque_speed": [[0, 200], [2, 220]]},
        ["robots[0] (left).motors.torque_speed[0]", "must not rise"],
    ),
    "curve bent upward": (
        {"torque_speed": [[0, 200], [2, 100], [4, 80]]},
        ["robots[0] (left).motors.torque_speed[0]", "concave", "Leave out"],
    ),
    "curve from a speed on": ({"torque_speed": [[1, 200], [2, 100]]}, ["torque_speed[0]", "standstill: [0, torque]"]),
    "curves of too few joints": (
        {"torque_speed": [FALLING, None]},
        ["robots[0] (left).motors.torque_speed", "one curve for all joints, or 3", "null for none"],
    ),
    "curve that contradicts the torque": (
        {"torque_speed": [[[0, 120], [2, 100]], None, None]},
        ["robots[0] (left).motors.torque_speed[0]", "'shoulder' gives 120 at standstill", "150", "at most 120"],
    ),
}


@pytest.mark.parametrize(("motors", "words"), MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_is_refused_by_file_key_value_and_rule(motors, words, files, capsys):
    path = with_motors(files, motors)
    assert main(["scale", str(path), str(files / "lift.yaml")]) == 2
    said = capsys.readouterr().err
    assert said.startswith("mrts: error: ")
    assert "Traceback" not in said
    for word in ["cell.yaml", *words]:
        assert word in said, said


def test_one_number_stands_for_all_joints_and_a_list_for_each(files):
    path = with_motors(
        files,
        {"armature": 0.2, "friction": {"coulomb": [3, 2, 1]}, "torque_speed": [FALLING, None, FALLING], "rated": 20},
    )
    motors = mrts.load_cell(path).robots[0].motors
    np.testing.assert_array_equal(motors.armature, [0.2, 0.2, 0.2])
    np.testing.assert_array_equal(motors.coulomb, [3, 2, 1])
    np.testing.assert_array_equal(motors.viscous, [0, 0, 0])
    np.testing.assert_array_equal(motors.rated, [20, 20, 20])
    assert [curve is None for curve in motors.torque_speed] == [False, True, False]
    assert np.all(np.isinf(motors.jerk))
    other = mrts.load_cell(path).robots[1].motors
    assert not other.has_effect


def test_lines_of_a_curve_meet_its_corners():
    for (speed, torque), (a, m) in zip(FALLING[1:], torque_speed_lines(np.array(FALLING)), strict=False):
        assert a - m * speed == pytest.approx(torque)
    assert len(torque_speed_lines(np.array(FALLING))) == 1  # its flat part is that of the torque limit


def test_friction_is_that_of_the_urdf_unless_a_block_replaces_it(files):
    path = with_motors(files, None, shoulder='friction="1.5"', wrist='damping="0.25" friction="0.5"')
    cell = mrts.load_cell(path)
    for robot in cell.robots:
        np.testing.assert_array_equal([robot.motors.coulomb, robot.motors.viscous], [[1.5, 0, 0.5], [0, 0, 0.25]])
    assert [warning.code for warning in cell.remarks] == ["urdf-friction"] * 2
    cell = mrts.load_cell(with_motors(files, {"friction": "none"}))
    assert [robot.motors.has_effect for robot in cell.robots] == [False, True]
    assert [warning.text.split(":")[0] for warning in cell.remarks] == ["robot 'right'"]
    given = mrts.load_cell(with_motors(files, {"friction": {"coulomb": 0.5}})).robots[0].motors
    np.testing.assert_array_equal([given.coulomb, given.viscous], [[0.5] * 3, [0] * 3])


def test_a_urdf_with_impossible_friction_is_refused(files):
    path = with_motors(files, None, elbow='friction="-1"')
    with pytest.raises(mrts.InputError, match=r"planar_arm.urdf: joint 'elbow', <dynamics> friction = -1.0: must be"):
        mrts.load_cell(path)


def changed(cell, **columns):
    """The cell whose left robot has other motors."""
    left, right = cell.robots
    motors = replace(left.motors, **columns)
    return replace(cell, robots=(replace(left, motors=motors), right))


def test_motors_are_changed_in_python_and_checked_again(planar_cell, lift):
    heavy = changed(planar_cell, armature=np.full(3, 0.4), coulomb=np.array([2.0, 1.0, 0.5]))
    assert mrts.scale(heavy, lift).range.upper.c2 < mrts.scale(planar_cell, lift).range.upper.c2
    for columns, words in (
        ({"coulomb": np.full(3, -1.0)}, "coulomb"),
        ({"coulomb": np.full(3, 1e6)}, "overcomes"),
        ({"armature": np.full(2, 0.1)}, "one value for each of 3 joints"),
        ({"torque_speed": (np.array([[0, 1.0], [2, 0.5]]), None, None)}, "contradict each other"),
    ):
        with pytest.raises(mrts.InputError, match=words):
            changed(planar_cell, **columns)


def test_a_saved_result_keeps_motors_and_friction_without_functions(planar_cell, lift, tmp_path):
    cell = changed(
        planar_cell,
        armature=np.full(3, 0.1),
        coulomb=np.array([2.0, 1.0, 0.5]),
        rated=np.array([20.0, np.inf, 5.0]),
        jerk=np.full(3, 700.0),
    )
    result = mrts.scale(cell, lift)
    mrts.save_result(result, tmp_path / "result.npz")
    again = mrts.load_result(tmp_path / "result.npz")
    ours, theirs = (one.cell.robots[0].motors for one in (result, again))
    for name in ("armature", "coulomb", "viscous", "rated", "jerk", "torque_rate"):
        np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))
    np.testing.assert_array_equal(again.trajectory.friction, result.trajectory.friction)
    assert again.to_json() == result.to_json()
