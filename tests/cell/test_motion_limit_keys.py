"""Keys of the cell file that limit the motion alone: kept, refused by name, told by one name each."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
import yaml
from same_cells import same_cell
from shipped_cells import shipped

import mrts
from mrts.cell.cell_change import cell_changes

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1_turn", "wrist_2_turn", "wrist_3_turn")

LEFT = {
    "velocity": [2.0, 2.1, 2.2, None, 2.4, 2.5],
    "acceleration": {"lower": [-9.0, -9.1, None, -9.3, -9.4, -9.5], "upper": [8.0, None, 8.2, 8.3, 8.4, 8.5]},
    "frames": [
        {"link": "forearm", "point": [0.1, 0.0, -0.05], "speed": 1.5},
        {"name": "camera", "link": "wrist_2", "point": [0.0, 0.1, 0.0], "speed": 1.4, "acceleration": 12.0},
        {"link": "forearm", "acceleration": 11.0},
    ],
}
RIGHT = {"acceleration": [7.0, 7.1, 7.2, 7.3, None, 7.5]}
OBJECT = {
    "velocity": {"linear": 0.9},
    "acceleration": {"linear": 6.0, "angular": 15.0},
    "frames": [
        {"point": [0.25, 0.15, 0.05], "speed": 0.95},
        {"name": "edge", "point": [-0.25, 0, 0], "acceleration": 5.5},
    ],
    "carries": [
        {"name": "cup", "at": [0.1, 0.05, 0.05], "friction": 0.5, "half_width": [0.03, 0.04], "height": 0.05},
        {"at": [-0.1, 0, 0.05], "normal": [0.1, 0, 1], "friction": 0.6},
    ],
}


def description(**of_right):
    """Of the cell file."""
    given = shipped("dual_ur5")
    given["object"] |= OBJECT
    given["robots"][0] |= LEFT
    given["robots"][1] |= RIGHT | of_right
    return deepcopy(given)


PROGRAMS = 1e-8
"""Of c² by two programs, relative."""


@pytest.fixture(scope="module")
def cell():
    return mrts.Cell.from_description(description())


def c2(cell, lift_and_turn):
    return mrts.scale(cell, lift_and_turn).range.upper.c2


def test_all_keys_come_back(cell, tmp_path):
    text = cell.to_yaml(tmp_path / "cell.yaml")
    for _ in ("made", "from the cache"):
        again = mrts.load_cell(tmp_path / "cell.yaml")
        assert same_cell(cell, again)
        assert again.to_yaml() == text
    left, right = cell.robots
    free = cell.with_values({"robots.right.velocity": [None] * 6})  # not those of the URDF
    assert same_cell(free, mrts.Cell.from_description(yaml.safe_load(free.to_yaml())))
    assert [point.name for point in left.point_limits] == ["forearm", "camera", "forearm2"]
    assert [point.joints for point in left.point_limits] == [3, 5, 3]
    assert [thing.name for thing in cell.carried] == ["cup", "thing2"]
    assert left.velocity_limit.tolist() == [2.0, 2.1, 2.2, np.inf, 2.4, 2.5]
    assert left.acceleration_lower.tolist() == [-9.0, -9.1, -np.inf, -9.3, -9.4, -9.5]
    assert left.acceleration_upper[1] == np.inf
    np.testing.assert_array_equal(right.acceleration_lower, -right.acceleration_upper)


@pytest.mark.parametrize(
    ("path", "value", "key"),
    [
        ("robots.left.acceleration", [1.0] * 5, "acceleration"),
        ("robots.left.acceleration", {"lower": [-1.0] * 6, "upper": [1.0, 1, 1, 1, 1, -0.5]}, "acceleration"),
        ("robots.right.acceleration[0]", -1.0, "acceleration"),
        ("robots.left.velocity", [0.0] * 6, "velocity"),
        ("object.acceleration.linear", 0.0, "object.acceleration"),
        ("object.acceleration.angular", "fast", "object.acceleration"),
        ("object.carries[0].friction", 0.4, "object.carries[0].friction"),
        ("robots.left.frames[0].speed", 1.0, "robots.left.frames[0].speed"),
    ],
)
def test_wrong_values_are_refused_by_their_key(path, value, key, cell):
    with pytest.raises(mrts.InputError, check=lambda error: str(error.key).startswith(key)):
        cell.with_values({path: value})


BAD = {
    "object.frames[0].name": lambda keys: keys["object"]["frames"][0].update(name="linear"),
    "object.frames[1].name": lambda keys: keys["object"]["frames"][1].update(name="point"),
    "object.carries[1].name": lambda keys: keys["object"]["carries"][1].update(name="cup"),
    "object.carries[0].normal": lambda keys: keys["object"]["carries"][0].update(normal=[0, 1e-12, 0]),
    "object.carries[1]": lambda keys: keys["object"]["carries"][1].update(height=0.1),
    "object.frames[0]": lambda keys: keys["object"]["frames"][0].pop("speed"),
    "object.carries[0].half_width": lambda keys: keys["object"]["carries"][0].update(half_width=[0.1]),
    "robots[0] (left).frames[1].name": lambda keys: keys["robots"][0]["frames"][1].update(name="elbow"),
    "robots[0] (left).frames[0].link": lambda keys: keys["robots"][0]["frames"][0].update(link="forarm"),
    "robots[0] (left).frames[2].link": lambda keys: keys["robots"][0]["frames"][2].update(link="base_link"),
    "robots[0] (left).acceleration_lower[0]": lambda keys: keys["robots"][0]["acceleration"].update(lower=[1.0] * 6),
    "robots[0] (left).acceleration.upper": lambda keys: keys["robots"][0]["acceleration"].update(upper=[1.0] * 5),
    "robots[1] (right).velocity": lambda keys: keys["robots"][1].update(velocity=[1.0] * 7),
}


@pytest.mark.parametrize("key", BAD)
def test_wrong_keys_are_refused_by_name(key):
    keys = description()
    BAD[key](keys)
    with pytest.raises(mrts.InputError, check=lambda error: error.key == key):
        mrts.Cell.from_description(keys)


EXPECTED = {
    *(("contact", "object", name) for name in ("cup", "thing2")),
    *(("velocity", "left", joint) for joint in JOINTS if joint != "wrist_1_turn"),
    *(("velocity", "right", joint) for joint in JOINTS),
    *(("acceleration", "left", joint) for joint in JOINTS),
    *(("acceleration", "right", joint) for joint in JOINTS if joint != "wrist_2_turn"),
    *(("velocity", "left", name) for name in ("forearm", "camera")),
    *(("acceleration", "left", name) for name in ("camera", "forearm2")),
    *(("velocity", "object", name) for name in ("linear", "point")),
    *(("acceleration", "object", name) for name in ("linear", "angular", "edge")),
}


def test_changes_name_each_limit_once_and_are_those_of_a_changed_cell(cell, lift_and_turn):
    ups = [change for change in cell_changes(cell) if change.step > 0]
    names = [(change.kind, change.robot, change.element) for change in ups]
    of_motion = [name for name in names if name[0] in {"velocity", "acceleration", "contact"}]
    assert set(of_motion) == EXPECTED
    assert len(names) == len(set(names))
    slow = cell.with_values({"robots.right.acceleration": [None] * 6, "object.acceleration.linear": 3.0})
    slow = replace(slow, robots=(replace(slow.robots[0], point_limits=()), slow.robots[1]))
    found = {str(one.change): one for one in mrts.scale(slow, lift_and_turn, between=None).what_if().changes}
    one = found["object/linear acceleration +10 %"]
    assert one.after.c2 > one.before.c2
    more = mrts.scale(slow.with_values({"object.acceleration.linear": 3.3}), lift_and_turn, between=None)
    assert one.after.c2 == pytest.approx(more.range.upper.c2, rel=PROGRAMS)
