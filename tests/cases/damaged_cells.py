"""The shipped cell of two arms and its motion, each with one mistake that people make."""

from copy import deepcopy

import numpy as np
import yaml
from conftest import UR5
from shipped_cells import cell_file, shipped, shipped_motion

URDF = UR5 / "ur5_class_arm.urdf"


def sound():
    """Cell and motion as they are shipped, the URDF by its absolute path."""
    return shipped("dual_ur5"), shipped_motion("dual_ur5", samples=21)


def written(folder, cell, motion):
    """Both as files."""
    (folder / "motion.yaml").write_text(yaml.safe_dump(motion, allow_unicode=True), encoding="utf-8")
    return cell_file(folder, cell), folder / "motion.yaml"


def _scale(block, key, factor):
    block[key] = [value * factor for value in block[key]]


DEGREES = 180 / np.pi

HINTS = {
    "grasp in degrees": ("rpy-degrees", lambda cell, _, arm: _scale(cell["robots"][arm]["grasp"], "rpy", DEGREES)),
    "motion in degrees": ("rpy-degrees", lambda _cell, motion, _: _scale(motion["end"], "rpy", DEGREES)),
    "gravity upward": ("gravity-upward", lambda cell, *_: cell.update(gravity=[0, 0, 9.81])),
    "posture in degrees": ("posture-degrees", lambda cell, _, arm: _scale(cell["robots"][arm], "posture", DEGREES)),
    "mass in grams": ("mass-grams", lambda cell, *_: cell["object"].update(mass=8000.0)),
    "inertia in kg mm²": ("inertia-unit", lambda cell, *_: _scale(cell["object"], "inertia", 1e6)),
}  # fmt: skip
"""The hint that each mistake must lead to, and the mistake."""


def damaged(name, arm=0):
    """Cell and motion with one of the mistakes of `HINTS` at an arm."""
    cell, motion = deepcopy(sound())
    HINTS[name][1](cell, motion, arm)
    return cell, motion


def _given(cell, arm, **keys):
    cell["robots"][arm].update(keys)


MISTAKES = {
    "object.mass": lambda cell, _: cell["object"].update(mass=-8.0),
    "object.inertia[1]": lambda cell, _: cell["object"].update(inertia=[0.1, "wide", 0.2]),
    "object.variation: unknown parameter": lambda cell, _: cell["object"].update(variation={"weight": [1, 2]}),
    "'gravitation'": lambda cell, _: cell.update(gravitation=[0, 0, -9.81]),
    "plane": lambda cell, _: cell.update(plane="upright"),
    "robots[0].urdf": lambda cell, _: _given(cell, 0, urdf=""),
    "robots[0].base.xyz": lambda cell, _: cell["robots"][0]["base"].update(xyz=[1.0, 2.0]),
    "robots[0].motors.friction.coulomb": lambda cell, _: cell["robots"][0].update(
        motors={"friction": {"coulomb": "no"}}
    ),
    "robots[1].posture[2]": lambda cell, _: cell["robots"][1]["posture"].__setitem__(2, None),
    "robots[1].torque.upper[0]": lambda cell, _: _given(cell, 1, torque={"lower": [-1.0], "upper": ["x"]}),
    "contact[0].pad.friction": lambda cell, _: _given(cell, 1, contact=[{"pad": {"friction": "x"}}]),
    "duration": lambda _, motion: motion.update(duration=0),
    "profile": lambda _, motion: motion.update(profile="fast"),
    "start.rpy[1]": lambda _, motion: motion["start"].update(rpy=[0, "x", 0]),
    "end.xyz": lambda _, motion: motion["end"].update(xyz=[0, 1]),
    "'finish'": lambda _, motion: motion.update(finish={}),
}
"""Mistakes that break a rule of a file, by what a message of theirs says; any of them together."""
