"""Cells made and changed in Python are the cells that files with these numbers give, under the same rules."""

import copy
import os
import pickle
import re
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
import yaml
from conftest import DATA
from same_cells import same_cell
from shipped_cells import changed_cell

import mrts


def c2_of(cell, motion):
    """What a worker does."""
    result = mrts.scale(cell, motion)
    return result.json_text(), os.environ["MRTS_CACHE_DIR"]


def use_cache(folder):
    os.environ["MRTS_CACHE_DIR"] = folder


def pool(initializer, *arguments):
    return ProcessPoolExecutor(1, get_context("spawn"), initializer, arguments)


@pytest.mark.quick
def test_a_worker_with_an_empty_cache_finds_the_same(planar_cell, lift, lifted, tmp_path):
    """As on another machine: neither the cell file nor the cache is there, the C travels."""
    heavier = planar_cell.with_mass(4.0)
    with pool(use_cache, str(tmp_path)) as workers:
        results = list(workers.map(c2_of, [planar_cell, heavier], [lift, lifted.motion]))
    assert {folder for *_, folder in results} == {str(tmp_path)}
    assert [text for text, *_ in results] == [lifted.json_text(), mrts.scale(heavier, lift).json_text()]
    assert len(list(tmp_path.glob("lib/*/cell.so"))) == 1  # compiled once, bound twice


@pytest.mark.parametrize("again", [copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])  # noqa: S301
def test_what_a_user_holds_comes_back_as_it_was(planar_cell, lift, lifted, again):
    moved = planar_cell.with_values({"robots.left.base.xyz": [0.01, 0.02, 0], "gravity": [0, -1.6, 0]})
    other = again(moved)
    assert same_cell(other, moved)
    assert mrts.scale(other, lift).json_text() == mrts.scale(moved, lift).json_text()
    assert not other.robots[0].torque_upper.flags.writeable
    infeasible = mrts.scale(planar_cell.with_mass(24.0), lift)
    uncertain = mrts.scale(planar_cell.with_variation(mass=(0.2, 6.0)), lift)
    for result in (lifted, infeasible, uncertain, mrts.retime(planar_cell, lift)):
        assert again(result).json_text() == result.json_text()
    assert again(lifted).residuals() == lifted.residuals()


SHIPPED = {path.parent.name: path for path in sorted(DATA.parent.glob("*/cell.yaml"))}


def described(name):
    return yaml.safe_load(SHIPPED[name].read_text(encoding="utf-8"))


def from_dict(description, name, **options):
    return mrts.Cell.from_description(description, folder=SHIPPED[name].parent, **options)


def robot(description, name):
    return next(robot for robot in description["robots"] if robot["name"] == name)


@pytest.mark.quick
@pytest.mark.parametrize(
    "change",
    [
        lambda d: d.update(grav=3),
        lambda d: d.update(gravity=[0, float("nan"), 0]),
        lambda d: d["robots"][0].update(torque=[1, 2]),
        lambda d: d["robots"][0].update(base={"rpy": [1, 0, 0]}),
    ],
)
def test_the_rules_and_words_are_those_of_a_file(change, tmp_path):
    description = described("planar_dual_arm")
    change(description)
    with pytest.raises(mrts.InputError) as refused:
        from_dict(description, "planar_dual_arm")
    path = changed_cell(tmp_path, change)
    told = [(one.key, one.rule) for one in refused.value.each()]
    with pytest.raises(mrts.InputError, check=lambda error: [(one.key, one.rule) for one in error.each()] == told):
        mrts.load_cell(path)


def both(x):
    return {"lower": (-2 * abs(x)).tolist(), "upper": abs(x).tolist()}


CHANGES = {
    "base in parts": lambda x: {"robots.right.base.xyz": x[:3], "robots.right.base.rpy": tuple(x[3:6])},
    "grasp": lambda x: {"robots.left.grasp": {"xyz": x[:3].tolist(), "quaternion_wxyz": [0.6, 0, 0.8, 0]}},
    "one number": lambda x: {"robots[0].grasp.xyz[1]": x[0], "gravity[2]": x[1], "robots.left.posture[3]": x[2]},
    "torque of two sides": lambda x: {"robots.right.torque": both(x)},
    "wrench": lambda x: {
        "robots.right.wrench": {"lower": [None, *(-abs(x[1:])).tolist()], "upper": [*x[:5] ** 2, None]}
    },
    "motors": lambda x: {"robots.left.motors": {"rated": (abs(x) + 1).tolist(), "armature": abs(x[0])}},
    "a hand": lambda x: {"robots.left.contact": [{"box": {"upper": (abs(x) + 1).tolist(), "frame": "object"}}]},
    "gravity and mass": lambda x: {"gravity": x[:3], "object.mass": np.int64(abs(x[0]) + 1)},
}


def written(description, values):
    """A description with other values at their paths."""
    for path, value in values.items():
        here, (*keys, last) = description, [int(key) if key.isdigit() else key for key in re.findall(r"\w+", path)]
        for key in keys:
            here = robot(description, key) if here is description["robots"] and isinstance(key, str) else here[key]
        here[last] = value
    return description


@pytest.mark.parametrize("what", CHANGES)
@pytest.mark.parametrize("name", ["dual_ur5", "squeeze"])
def test_a_change_is_the_file_with_these_numbers(name, what):
    cell = mrts.load_cell(SHIPPED[name])
    numbers = np.random.default_rng([17, *what.encode()]).uniform(-3, 3, 6)
    values = CHANGES[what](numbers)
    assert same_cell(cell.with_values(values), from_dict(written(described(name), values), name))


@pytest.mark.quick
def test_what_a_hand_can_exert_turns_with_the_grasp():
    """A tip that turns against the object takes its pad along, as in a file with this grasp."""
    name, turn = "squeeze", [0.2, np.pi / 2 + 0.1, -0.1]
    cell, description = mrts.load_cell(SHIPPED[name]), described(name)
    robot(description, "left")["grasp"]["rpy"] = turn
    motion = mrts.load_motion(SHIPPED[name].parent / "lift_and_turn.yaml")
    asked = [
        mrts.scale(each, motion, between=None).json_text()
        for each in (cell.with_values({"robots.left.grasp.rpy": turn}), from_dict(description, name), cell)
    ]
    assert asked[0] == asked[1] != asked[2]


@pytest.mark.quick
@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"robots.lef.base": {}}, r"values: robots.lef.base: there is no 'lef' in robots; did you mean 'left'\?"),
        ({"robots.left.base.xyz[3]": 1.0}, r"robots.left.base.xyz has 3 values"),
        ({"robots.left.urdf": "x"}, r"values: robots.left.urdf: is not changed in Python"),
        ({3: 1.0}, r"values: path = 3: must be text"),
        ({"robots.left.base.xyz": [0, 0, 1e13]}, r"robot 'left': base.xyz\[2\] = 1.*: must be <= 1e\+12"),
        ({"robots.left.grasp.rpy": [0, 0.1, 0]}, r"left': grasp: the tip frame 'contact' is tilted"),
        (
            {"robots.left.torque": {"lower": [0, 0, 2], "upper": [1, 1, 1]}},
            r"torque_lower\[2\] = 2.0: must be below torque_upper, 1",
        ),
        (
            {"robots.left.wrench": {"lower": [1, 1, 1], "upper": [2, 0, 2]}},
            r"wrench_lower\[1\] = 1.0: must be at most wrench",
        ),
        ({"robots.left.wrench": {"max": [1.0, 1.0, 1.0]}}, r"robot 'left': wrench: unknown key 'max'"),
        ({"robots.left.motors.friction.coulomb": -1}, r"left': motors.friction.coulomb.0. = -1.0: must be at least 0"),
        ({"robots.left.posture": [0.0]}, r"robot 'left': posture = \[0.0\]: must have 3 values"),
        ({"object.mass": 0.0}, r"cell: object.mass = 0.0: must be > 0"),
        ({"robots.right.base": {}}, r"cell: base: robots 'left' and 'right' would"),
        ({"robots.left.base.xyz[0]": -0.9, "robots[0].base": {"xyz": [0, 0, 0]}}, r"values: .*say each number once"),
    ],
)
def test_a_wrong_change_is_refused_in_the_words_of_the_file(values, message, planar_cell):
    with pytest.raises(mrts.InputError, match=message):
        planar_cell.with_values(values)
