"""Paths to numbers, and their units."""

import pytest
from gantries import gantries

from mrts.base.errors import InputError
from mrts.cell.cell_keys import find_keys, number_unit, path_text, value_at

UNITS = {
    "robots.near.posture[0]": "m",
    "robots.near.torque[2]": "N m",
    "robots.near.wrench.upper[2]": "N m",
    "robots.near.contact_rate[0]": "N/s",
    "robots.near.motors.armature[0]": "kg",
    "robots.near.motors.torque_speed[0][1][0]": "m/s",
    "robots.near.motors.torque_speed[0][1][1]": "N",
    "robots.near.contact[0].pad.friction": "",
    "robots.near.contact[0].pad.half_width[0]": "m",
    "robots.near.contact[0].pad.force[1]": "N",
    "robots.near.contact[1].box.upper[2]": "N m",
    "robots.near.fixed.torque": "",
    "robots.near.grasp.rpy[2]": "rad",
    "object.variation.mass[0]": "",
    "object.variation.mx[1]": "kg m",
    "object.velocity.angular": "rad/s",
    "gravity[1]": "m/s²",
    "motion.waypoints[1].xyz[0]": "m",
}


def test_units_are_those_of_joints_hands_curves_and_the_object(tmp_path):
    rails = gantries(tmp_path)
    curve = [[0, 20], [1, 10]]
    pad = {"friction": 0.5, "half_width": [0.1], "force": [1, 2], "normal": [1, 0, 0]}
    near = {
        "name": "near", "posture": [0, 0, 0], "torque": [20, 20, 20], "wrench": {"upper": [1, 1, 1]},
        "contact_rate": [1, 1], "motors": {"armature": 0.1, "torque_speed": [curve, None, curve]},
        "fixed": {"torque": 1}, "contact": [{"pad": pad}, {"box": {"upper": [1, 1, 1]}}], "grasp": {"rpy": [0, 0, 0]},
    }  # fmt: skip
    variation = {"mass": [1, 1], "mx": [0, 0]}
    cell = {"robots": [near], "object": {"variation": variation, "velocity": {"angular": None}}, "gravity": [0, 0, 0]}
    files = {"cell": cell, "motion": {"waypoints": [{"xyz": [0, 0, 0]}] * 2}}
    for path, unit in UNITS.items():
        keys = find_keys(files, path)
        assert path_text(files, keys) == path
        assert number_unit(keys, rails) == unit, path


def test_a_path_leads_to_the_longest_key_that_it_names():
    """Joints of a URDF may be called anything."""
    fixed = {"torso": 1.0, "torso.lift": 2.0, "torso.lift[0]": 3.0, "a/b-c": 4.0}
    files = {"cell": {"robots": [{"name": "left", "fixed": fixed}]}, "motion": {}}
    for joint, value in fixed.items():
        keys = find_keys(files, f"robots.left.fixed.{joint}")
        assert value_at(files, keys) == value
    for wrong in ("", ".", "robots", "robots.", "robots[0]x", "robots.left.fixed.torso.", "robots.left.fixed.torso[0]"):
        if wrong == "robots":
            assert find_keys(files, wrong) == ("cell", "robots")
        else:
            with pytest.raises(InputError):
                find_keys(files, wrong)
