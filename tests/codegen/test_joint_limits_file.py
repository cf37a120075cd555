"""MoveIt's joint_limits.yaml as a cell file names it: what is taken, what is refused."""

import numpy as np
import pytest
import yaml
from same_cells import same_cell
from shipped_cells import changed_cell

import mrts

OTHERS = {"finger_joint": {"has_velocity_limits": True, "max_velocity": 0.1}}


@pytest.fixture
def written(tmp_path):
    """Makes cell files of the planar cell, the first arm with a file of joint limits."""

    def write(limits, **keys):
        text = limits if isinstance(limits, str) else yaml.safe_dump(limits)
        (tmp_path / "joint_limits.yaml").write_text(text, encoding="utf-8")
        given = {"joint_limits": "joint_limits.yaml"} | keys
        return changed_cell(tmp_path, lambda cell: cell["robots"][0].update(given))

    return write


def joints(*entries):
    return {"joint_limits": dict(zip(JOINTS, entries, strict=False))}


JOINTS = ("shoulder", "elbow", "wrist")

FULL = {"has_velocity_limits": True, "max_velocity": 2.0, "has_acceleration_limits": True, "max_acceleration": 5.0}
NONE = {"has_velocity_limits": False, "max_velocity": 0.0, "has_acceleration_limits": False, "max_acceleration": 0.0}
BARE = {"max_velocity": 1.5, "max_acceleration": 4, "max_jerk": 60.0}
SCALED = {"default_velocity_scaling_factor": 0.1, "default_acceleration_scaling_factor": 0.5}


def test_limits_are_those_of_the_file(written):
    """Flags that say no, flags that are absent, joints of other robots; keys of the cell file count before it."""
    cell = mrts.load_cell(written({"joint_limits": joints(FULL, NONE, BARE)["joint_limits"] | OTHERS}))
    left, right = cell.robots
    assert left.velocity_limit.tolist() == [2.0, np.inf, 1.5]
    assert left.acceleration_upper.tolist() == [5.0, np.inf, 4.0]
    assert left.acceleration_lower.tolist() == [-5.0, -np.inf, -4.0]
    assert left.motors.jerk.tolist() == [np.inf, np.inf, 60.0]
    assert np.isinf(right.acceleration_upper).all()
    assert not {remark.code for remark in cell.remarks} & {"joint-limits-scaled", "joint-limits-passed-over"}
    assert same_cell(cell, mrts.Cell.from_description(yaml.safe_load(cell.to_yaml())))
    own = {"velocity": [1.0, None, 3.0], "acceleration": {"lower": [-1, -2, -3], "upper": [3, 2, None]}}
    (left, _) = mrts.load_cell(written(joints(FULL, NONE, BARE), **own, motors={"jerk": [7.0, 8.0, 9.0]})).robots
    assert left.velocity_limit.tolist() == [1.0, np.inf, 3.0]
    assert (left.acceleration_lower.tolist(), left.acceleration_upper.tolist()) == ([-1, -2, -3], [3, 2, np.inf])
    assert left.motors.jerk.tolist() == [7.0, 8.0, 9.0]


@pytest.mark.parametrize("wrappers", [(), ("/**", "ros__parameters"), ("robot_description_planning",),
                                      ("/**", "ros__parameters", "robot_description_planning")])  # fmt: skip
def test_scaling_factors_are_applied_and_told_under_any_wrapper(wrappers, written, planar_cell):
    data = joints(FULL, NONE, BARE) | SCALED
    for name in reversed(wrappers):
        data = {name: data}
    cell = mrts.load_cell(written(data))
    assert cell.robots[0].velocity_limit.tolist() == pytest.approx([0.2, np.inf, 0.15])
    some = mrts.load_cell(written(joints(FULL) | SCALED)).robots[0]
    of_urdf = np.array(planar_cell.robots[0].velocity_limit[1:])
    assert some.velocity_limit.tolist() == pytest.approx([0.2, *(0.1 * of_urdf).tolist()])  # as MoveIt's whole model
    assert cell.robots[0].acceleration_upper.tolist() == pytest.approx([2.5, np.inf, 2.0])
    assert cell.robots[0].motors.jerk[2] == 60.0
    (remark,) = (remark for remark in cell.remarks if remark.code == "joint-limits-scaled")
    assert all(part in remark.text for part in ("velocity by 0.1", "acceleration by 0.5", "joint_limits.yaml"))


WRONG = {
    "joint_limits": [
        "joint_limits: [1, 2]",
        "nothing: here",
        "- 1",
        "",
        {"joint_limits": OTHERS},
        {"joint_limits": {1: FULL}},
        {"joint_limits": {}},
    ],
    "joint_limits.elbow": [joints(FULL, 3.0), joints(FULL, [FULL]), joints(FULL, "fast")],
    "joint_limits.elbow.max_velocity": [joints(FULL, {"max_velocity": value}) for value in ("fast", [1.0])],
    "joint_limits.shoulder.has_jerk_limits": [joints({"has_jerk_limits": 3})],
    "joint_limits.shoulder": [joints(FULL | {f"max_{of}": value}) for of in ("velocity", "acceleration", "jerk")
                            for value in (0.0, -1.0)],
    "default_velocity_scaling_factor": [joints(FULL) | {"default_velocity_scaling_factor": value}
                                        for value in (0, -0.1, 1.5, "slow", None)],
    "default_acceleration_scaling_factor": [joints(FULL) | {"default_acceleration_scaling_factor": [0.1]}],
}  # fmt: skip


@pytest.mark.parametrize(("key", "limits"), [(key, limits) for key, each in WRONG.items() for limits in each])
def test_what_is_wrong_in_it_is_refused_with_file_and_key(key, limits, written):
    with pytest.raises(mrts.InputError, match=r"joint_limits\.yaml", check=lambda error: error.key == key):
        mrts.load_cell(written(limits))
