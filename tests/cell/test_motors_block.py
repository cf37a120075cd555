"""The `motors` of a cell file: what is refused and how, and where friction comes from."""

import numpy as np
import pytest
from conftest import DATA
from shipped_cells import changed_cell

import mrts

pytestmark = pytest.mark.quick

TORQUE = {"left": [150, 150, 28], "right": [150, 150, 28]}
"""[N m]: what the mistakes below are measured against."""

FALLING = [[0, 200], [2, 200], [6, 80]]


def with_motors(folder, motors, **dynamics):
    """The planar cell with these motors of its left robot; `dynamics` gives <dynamics> to joints of both."""
    text = (DATA / "planar_arm.urdf").read_text()
    for joint, given in dynamics.items():
        head, tail = text.split(f'<joint name="{joint}"', 1)
        text = f'{head}<joint name="{joint}"{tail.replace("</joint>", f"<dynamics {given}/></joint>", 1)}'
    (folder / "arm.urdf").write_text(text)

    def change(cell):
        for robot in cell["robots"]:
            robot |= {"torque": TORQUE[robot["name"]], "urdf": str(folder / "arm.urdf")}
        if motors is not None:
            cell["robots"][0]["motors"] = motors

    return changed_cell(folder, change)


MISTAKES = [
    ({"armature": -0.1}, "(left).motors.armature[0] = -0.1: must be at least 0"),
    ({"friction": {"coulomb": [1, 2]}}, "(left).motors.friction.coulomb = [1.0, 2.0]: must have 3 values"),
    ({"friction": {"coulomb": [1, -2, 0]}}, "(left).motors.friction.coulomb[1] = -2.0: must be at least 0"),
    ({"friction": [1, 2, 3]}, "robots[0].motors.friction = [1, 2, 3]: must be "),
    ({"friction": {"coulomb": [1, 1, 28]}}, "friction.coulomb[2]: Coulomb friction of joint 'wrist' is 28"),
    ({"torque_rate": [5, -5, 5]}, "(left).motors.torque_rate[1] = -5.0: must be above 0"),
    (
        {"torque_speed": [[0, 200], [2, 220]]},
        "(left).motors.torque_speed[0] = [[0.0, 200.0], [2.0, 220.0]]: its torques",
    ),
    ({"torque_speed": [[0, 200], [2, 100], [4, 80]]}, "it must fall ever more steeply (be concave)"),
    ({"torque_speed": [[1, 200], [2, 100]]}, "its first corner must be at standstill: [0, torque]"),
    ({"torque_speed": [FALLING, None]}, "one curve for all joints, or one"),
    ({"torque_speed": [[[0, 120], [2, 100]], None, None]}, "the curve of joint 'shoulder' gives 120 at standstill"),
]


@pytest.mark.parametrize(("motors", "said"), MISTAKES)
def test_a_mistake_is_refused_by_file_key_value_and_rule(motors, said, tmp_path):
    with pytest.raises(mrts.InputError) as refused:
        mrts.load_cell(with_motors(tmp_path, motors))
    assert f"{tmp_path}/cell.yaml: robots[0]" in str(refused.value)
    assert said in str(refused.value)


def test_one_number_stands_for_all_joints_and_a_list_for_each(tmp_path):
    given = {"armature": 0.2, "friction": {"coulomb": [3, 2, 1]}, "torque_speed": [FALLING, None, FALLING], "rated": 20}
    left, right = (robot.motors for robot in mrts.load_cell(with_motors(tmp_path, given)).robots)
    found = [left.armature, left.coulomb, left.viscous, left.rated, left.jerk]
    np.testing.assert_array_equal(found, [[0.2] * 3, [3, 2, 1], [0] * 3, [20] * 3, [np.inf] * 3])
    assert [curve is None for curve in left.torque_speed] == [False, True, False]
    assert not right.has_effect


def test_friction_is_that_of_the_urdf_unless_a_block_replaces_it(tmp_path):
    urdf = {"shoulder": 'friction="1.5"', "wrist": 'damping="0.25" friction="0.5"'}
    cell = mrts.load_cell(with_motors(tmp_path, None, **urdf))
    for robot in cell.robots:
        np.testing.assert_array_equal([robot.motors.coulomb, robot.motors.viscous], [[1.5, 0, 0.5], [0, 0, 0.25]])
    assert [warning.code for warning in cell.remarks] == ["urdf-friction"] * 2
    cell = mrts.load_cell(with_motors(tmp_path, {"friction": "none"}, **urdf))
    assert [robot.motors.has_effect for robot in cell.robots] == [False, True]
    assert [warning.text.split(":")[0] for warning in cell.remarks] == ["robot 'right'"]
    given = mrts.load_cell(with_motors(tmp_path, {"friction": {"coulomb": 0.5}}, **urdf)).robots[0].motors
    np.testing.assert_array_equal([given.coulomb, given.viscous], [[0.5] * 3, [0] * 3])
