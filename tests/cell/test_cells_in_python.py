"""Cells made and changed in Python are the cells that files with these numbers give, under the same rules."""

from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import DATA
from same_cells import same_cell

import mrts

SHIPPED = {path.parent.name: path for path in sorted(DATA.parent.glob("*/cell.yaml"))}


def described(name):
    return yaml.safe_load(SHIPPED[name].read_text(encoding="utf-8"))


def from_dict(description, name, **options):
    return mrts.Cell.from_description(description, folder=SHIPPED[name].parent, **options)


def robot(description, name):
    return next(robot for robot in description["robots"] if robot["name"] == name)


@pytest.mark.parametrize("name", SHIPPED)
def test_a_dictionary_is_the_file(name):
    cell = mrts.load_cell(SHIPPED[name])
    again = from_dict(described(name), name)
    assert same_cell(cell, again)
    assert (again.folder, again.remarks) == (SHIPPED[name].parent, cell.remarks)


@pytest.mark.quick
def test_numbers_of_numpy_tuples_and_paths_are_taken(planar_cell):
    description = described("planar_dual_arm")
    description["gravity"] = np.array(description["gravity"])
    description["object"]["mass"] = np.float64(description["object"]["mass"])
    description["object"]["inertia"] = np.diag(description["object"]["inertia"])
    description["robots"] = tuple(description["robots"])
    for arm in description["robots"]:
        arm["urdf"] = DATA / arm["urdf"]
        arm["posture"] = tuple(np.array(arm["posture"]))
    cell = mrts.Cell.from_description(description)
    assert np.array_equal(cell.geometry, planar_cell.geometry)
    assert np.array_equal(cell.load, planar_cell.load)
    assert np.array_equal(cell.robots[0].posture, planar_cell.robots[0].posture)


@pytest.mark.quick
def test_relative_urdfs_are_looked_up_in_the_folder(tmp_path, monkeypatch):
    description = described("planar_dual_arm")
    with pytest.raises(mrts.InputError, match=r"planar_arm\.urdf: "):
        mrts.Cell.from_description(description, folder=tmp_path)
    monkeypatch.chdir(DATA)
    assert mrts.Cell.from_description(description).folder == Path.cwd()


@pytest.mark.quick
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(grav=3), "cell description: unknown key 'grav'; did you mean 'gravity'?"),
        (lambda d: d.pop("gravity"), "cell description: gravity: this key is required."),
        (lambda d: d.update(gravity=[0, np.nan, 0]), r"cell description: gravity\[1\] = nan: must be a finite number"),
        (
            lambda d: d.update(gravity=np.zeros(2)),
            r"gravity = \[0.0, 0.0\]: has 2 values, at least 3",
        ),
        (lambda d: d["robots"][0].update(torque=[1, 2]), r"cell description: robots\[0\] \(left\).torque = .*3 values"),
        (
            lambda d: d["robots"][1].update(posture=[0.0]),
            r"robots\[1\] \(right\).posture = .*3 values",
        ),
        (
            lambda d: d["robots"][0].update(base={"rpy": [1, 0, 0]}),
            r"\(left\).base.rpy: in a cell with plane",
        ),
        (
            lambda d: d["robots"][0].update(urdf="package://no_such_pkg/a.urdf"),
            r"robots\[0\].*'no_such_pkg' is not found",
        ),
        (
            lambda d: d["robots"][0].update(wrench={"lower": [3, 0, 0], "upper": [2, 0, 0]}),
            r"wrench.lower\[0\] = 3.*at most the upper",
        ),
    ],
)
def test_the_rules_and_words_are_those_of_a_file(change, message, tmp_path):
    description = described("planar_dual_arm")
    change(description)
    with pytest.raises(mrts.InputError, match=message) as refused:
        from_dict(description, "planar_dual_arm")
    path = tmp_path / "cell.yaml"
    for arm in description["robots"]:
        arm["urdf"] = str(DATA / arm["urdf"]) if "://" not in arm["urdf"] else arm["urdf"]
    if isinstance(description.get("gravity"), np.ndarray):
        description["gravity"] = description["gravity"].tolist()
    path.write_text(yaml.safe_dump(description))
    with pytest.raises(mrts.InputError) as from_file:
        mrts.load_cell(path)
    assert str(from_file.value) == str(refused.value).replace("cell description", str(path)).replace(
        f"{path}.", "cell.yaml."
    )


def test_a_dictionary_that_holds_itself_is_refused():
    description = described("planar_dual_arm")
    description["object"]["inertia"] = description
    with pytest.raises(mrts.InputError, match="cell description: its lists and keys may lie 20 deep"):
        from_dict(description, "planar_dual_arm")


CHANGES = {
    "base": (
        lambda cell, x: cell.with_base("right", xyz=x[:3], rpy=x[3:6]),
        lambda d, x: robot(d, "right").update(base={"xyz": x[:3].tolist(), "rpy": x[3:6].tolist()}),
    ),
    "grasp": (
        lambda cell, x: cell.with_grasp("left", xyz=x[:3], rpy=tuple(x[3:6])),
        lambda d, x: robot(d, "left").update(grasp={"xyz": x[:3].tolist(), "rpy": x[3:6].tolist()}),
    ),
    "torque": (
        lambda cell, x: cell.with_torque_limits("left", abs(x)),
        lambda d, x: robot(d, "left").update(torque=abs(x).tolist()),
    ),
    "torque of two sides": (
        lambda cell, x: cell.with_torque_limits("right", abs(x), lower=-2 * abs(x)),
        lambda d, x: robot(d, "right").update(torque={"lower": (-2 * abs(x)).tolist(), "upper": abs(x).tolist()}),
    ),
    "wrench": (
        lambda cell, x: cell.with_wrench_limits("right", lower=[None, *-abs(x[1:])], upper=[*x[:5] ** 2, np.inf]),
        lambda d, x: robot(d, "right").update(
            wrench={"lower": [None, *(-abs(x[1:])).tolist()], "upper": [*(x[:5] ** 2).tolist(), None]}
        ),
    ),
    "gravity": (
        lambda cell, x: cell.with_gravity(x[:3]),
        lambda d, x: d.update(gravity=x[:3].tolist()),
    ),
    "mass": (lambda cell, x: cell.with_mass(abs(x[0])), lambda d, x: d["object"].update(mass=abs(x[0]))),
    "posture": (
        lambda cell, x: cell.with_postures({"left": x.tolist()}),
        lambda d, x: robot(d, "left").update(posture=x.tolist()),
    ),
}


@pytest.mark.parametrize("what", CHANGES)
@pytest.mark.parametrize("name", ["dual_ur5", "squeeze"])
def test_a_change_is_the_file_with_these_numbers(name, what):
    cell, (change, write) = mrts.load_cell(SHIPPED[name]), CHANGES[what]
    rng = np.random.default_rng([17, *what.encode()])
    for _ in range(3):
        numbers, description = rng.uniform(-3, 3, 6), deepcopy(described(name))
        write(description, numbers)
        assert same_cell(change(cell, numbers), from_dict(description, name))


@pytest.mark.quick
def test_what_is_not_given_stays(dual_ur5):
    left = dual_ur5.robots[0]
    moved = dual_ur5.with_base("left", xyz=[1.0, 2.0, 3.0]).robots[0]
    assert moved.T_world_base.R.tobytes() == left.T_world_base.R.tobytes()
    turned = dual_ur5.with_grasp("left", rpy=[0.1, 0.2, 0.3]).robots[0]
    assert turned.T_object_tip.p.tobytes() == left.T_object_tip.p.tobytes()
    free = dual_ur5.with_wrench_limits("left").robots[0]
    assert np.all(free.wrench_lower == -np.inf)
    assert np.all(free.wrench_upper == np.inf)
    halved = dual_ur5.with_torque_limits("left", left.torque_upper / 2).with_wrench_limits(
        "left", left.wrench_lower, left.wrench_upper
    )
    np.testing.assert_array_equal(halved.robots[0].wrench_upper, left.wrench_upper)
    assert halved.robots[1] is dual_ur5.robots[1]


@pytest.mark.quick
def test_what_a_hand_can_exert_turns_with_the_grasp():
    """A tip that turns against the object takes its pad along, as in a file with this grasp."""
    name, turn = "squeeze", [0.2, np.pi / 2 + 0.1, -0.1]
    cell, description = mrts.load_cell(SHIPPED[name]), described(name)
    robot(description, "left")["grasp"]["rpy"] = turn
    motion = mrts.load_motion(SHIPPED[name].parent / "lift_and_turn.yaml")
    asked = [
        mrts.scale(each, motion, between=None).json_text()
        for each in (cell.with_grasp("left", rpy=turn), from_dict(description, name), cell)
    ]
    assert asked[0] == asked[1] != asked[2]


@pytest.mark.quick
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda cell: cell.with_base("lef", xyz=[0, 0, 0]), r"name = 'lef': there is no such robot; .* left, right\."),
        (lambda cell: cell.with_grasp(["left"]), r"name = \['left'\]: there is no such robot"),
        (lambda cell: cell.with_base("left", [0, 0]), r"robot 'left': base.xyz = \[0, 0\]: has 2 values, at least 3"),
        (
            lambda cell: cell.with_base("left", rpy=[0, 0, np.inf]),
            r"left': base.rpy\[2\] = inf: must be a finite",
        ),
        (lambda cell: cell.with_base("left", xyz=[0, 0, 1e13]), r"base.xyz\[2\] = 1.*: must be <= 1e\+12"),
        (lambda cell: cell.with_base("left", xyz=3.0), r"robot 'left': base.xyz = 3.0: must be a list"),
        (
            lambda cell: cell.with_base("left", rpy=[0.1, 0, 0]),
            r"left': base: in a cell with plane xy a base may",
        ),
        (
            lambda cell: cell.with_grasp("left", rpy=[0, 0.1, 0]),
            r"left': grasp: the tip frame 'contact' is tilted",
        ),
        (lambda cell: cell.with_limits(3), "limits = 3: must be a function"),
        (lambda cell: cell.with_torque_limits("left", [1, 2]), r"torque = \[1.0, 2.0\]: must have 3 values, .* wrist"),
        (lambda cell: cell.with_torque_limits("left", [1, 0, 1]), r"limit -?0 of joint 'elbow' must be below"),
        (
            lambda cell: cell.with_torque_limits("left", [1, 1, 1], [0, 0, 2]),
            r"limit 2 of joint 'wrist' must be",
        ),
        (lambda cell: cell.with_torque_limits("left", ["a", 1, 1]), r"torque.upper\[0\] = 'a': must be a number"),
        (lambda cell: cell.with_torque_limits("left", [1, np.inf, 1]), r"torque.upper\[1\] = inf: must be a finite"),
        (lambda cell: cell.with_wrench_limits("left", [0] * 6), r"wrench.lower = .*must have 3 values"),
        (lambda cell: cell.with_wrench_limits("left", [np.inf] * 3), r"wrench.lower\[0\] = inf: must be a finite"),
        (
            lambda cell: cell.with_wrench_limits("left", [1, 1, 1], [2, 0, 2]),
            r"wrench.lower\[1\] = 1.0: .* at most the upper one, 0",
        ),
        (lambda cell: cell.with_gravity(-9.81), r"cell: gravity = -9.81: must be a list"),
        (lambda cell: cell.with_gravity([True, 0, 0]), r"cell: gravity\[0\] = True: must be a number"),
        (
            lambda cell: cell.with_base("right", [0, 0, 0], [0, 0, 0]),
            r"cell: base: robots 'left' and 'right' would",
        ),
    ],
)
def test_a_wrong_change_is_refused_in_the_words_of_the_file(change, message, planar_cell):
    with pytest.raises(mrts.InputError, match=message):
        change(planar_cell)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("R", "p"),
    [
        (np.diag([1.0, 1.0, -1.0]), np.zeros(3)),
        (np.eye(3) * 1.001, np.zeros(3)),
        (np.eye(4), np.zeros(3)),
        (np.eye(3), np.array([0, np.nan, 0])),
        (np.eye(3), np.zeros(2)),
        ("x", np.zeros(3)),
    ],
)
def test_a_pose_that_is_none_is_refused(R, p, planar_cell):
    with pytest.raises(mrts.InputError, match=r"robot 'left': T_world_base"):
        replace(planar_cell.robots[0], T_world_base=mrts.RigidTransform(R, p))


@pytest.mark.quick
def test_nobody_writes_into_a_pose(planar_cell):
    mine = np.array([0.01, 0.0, 0.0])
    left, right = planar_cell.robots
    cell = replace(planar_cell, robots=(replace(left, T_world_base=mrts.RigidTransform(np.eye(3), mine)), right))
    mine[0] = 5.0
    assert cell.geometry[12] == cell.robots[0].T_world_base.p[0] == 0.01
    with pytest.raises(ValueError, match="read-only"):
        cell.robots[0].T_world_base.p[0] = 1.0
