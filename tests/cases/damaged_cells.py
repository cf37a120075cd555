"""The shipped cell of two arms and its motion, each with one mistake that people make."""

from copy import deepcopy

import numpy as np
import yaml
from conftest import DATA

FOLDER = DATA.parent / "dual_ur5"
URDF = FOLDER / "ur5_class_arm.urdf"


def sound():
    """Cell and motion as they are shipped, the URDF by its absolute path."""
    cell = yaml.safe_load((FOLDER / "cell.yaml").read_text(encoding="utf-8"))
    for robot in cell["robots"]:
        robot["urdf"] = str(URDF)
    motion = yaml.safe_load((FOLDER / "lift_and_turn.yaml").read_text(encoding="utf-8"))
    return cell, motion | {"samples": 21}


def written(folder, cell, motion):
    """Both as files."""
    paths = folder / "cell.yaml", folder / "motion.yaml"
    for path, data in zip(paths, (cell, motion), strict=True):
        path.write_text(yaml.safe_dump(data, allow_unicode=True), encoding="utf-8")
    return paths


def _scaled(values, factor):
    return [value * factor for value in values]


def base_in_mm(cell, _motion, arm):
    cell["robots"][arm]["base"]["xyz"] = _scaled(cell["robots"][arm]["base"]["xyz"], 1000)


def grasp_in_mm(cell, _motion, arm):
    cell["robots"][arm]["grasp"]["xyz"] = _scaled(cell["robots"][arm]["grasp"]["xyz"], 1000)


def motion_in_mm(_cell, motion, _arm):
    for key in ("start", "end"):
        motion[key]["xyz"] = _scaled(motion[key]["xyz"], 1000)


def posture_in_degrees(cell, _motion, arm):
    cell["robots"][arm]["posture"] = np.degrees(cell["robots"][arm]["posture"]).tolist()


def grasp_in_degrees(cell, _motion, arm):
    cell["robots"][arm]["grasp"]["rpy"] = np.degrees(cell["robots"][arm]["grasp"]["rpy"]).tolist()


def motion_in_degrees(_cell, motion, _arm):
    motion["end"]["rpy"] = np.degrees(motion["end"]["rpy"]).tolist()


def gravity_upward(cell, _motion, _arm):
    cell["gravity"] = [0, 0, 9.81]


def gravity_in_mm(cell, _motion, _arm):
    cell["gravity"] = [0, 0, -9810]


def torques_in_nmm(cell, _motion, arm):
    cell["robots"][arm]["torque"] = [150e3, 150e3, 150e3, 28e3, 28e3, 28e3]


def mass_in_grams(cell, _motion, _arm):
    cell["object"]["mass"] = 8000.0


def inertia_in_kg_mm2(cell, _motion, _arm):
    cell["object"]["inertia"] = _scaled(cell["object"]["inertia"], 1e6)


def bases_swapped(cell, _motion, _arm):
    left, right = cell["robots"]
    left["base"], right["base"] = right["base"], left["base"]


def grasps_swapped(cell, _motion, _arm):
    left, right = cell["robots"]
    left["grasp"], right["grasp"] = right["grasp"], left["grasp"]


def other_side(cell, _motion, arm):
    cell["robots"][arm]["grasp"]["rpy"][1] *= -1
    sign = (-1) ** arm
    cell["robots"][arm]["base"]["xyz"][0] = -0.95 * sign


def quaternion_in_the_other_order(cell, _motion, _arm):
    """Half a turn about z with the real part last, read as half a turn about y: the arm hangs upside down."""
    cell["robots"][1]["base"] = {"xyz": [0.97, 0, 0], "quaternion_wxyz": [0.0, 0.0, 1.0, 0.0]}


HINTS = {
    base_in_mm: "base-millimetres",
    grasp_in_mm: "grasp-millimetres",
    motion_in_mm: "motion-millimetres",
    posture_in_degrees: "posture-degrees",
    grasp_in_degrees: "rpy-degrees",
    motion_in_degrees: "rpy-degrees",
    gravity_upward: "gravity-upward",
    gravity_in_mm: "gravity-millimetres",
    torques_in_nmm: "torque-millimetres",
    mass_in_grams: "mass-grams",
    inertia_in_kg_mm2: "inertia-unit",
    bases_swapped: "swapped-bases",
    grasps_swapped: "swapped-grasps",
    other_side: "other-side",
    quaternion_in_the_other_order: "quaternion-order",
}
"""The hint that each mistake must lead to."""


def damaged(damage, arm=0):
    """Cell and motion with a mistake at an arm."""
    cell, motion = deepcopy(sound())
    damage(cell, motion, arm)
    return cell, motion


def _given(cell, arm, **keys):
    cell["robots"][arm].update(keys)


MISTAKES = {
    "object.mass": lambda cell, _: cell["object"].update(mass=-8.0),
    "object.inertia[1]": lambda cell, _: cell["object"].update(inertia=[0.1, "wide", 0.2]),
    "object.variation: unknown key": lambda cell, _: cell["object"].update(variation={"weight": [1, 2]}),
    "'gravitation'": lambda cell, _: cell.update(gravitation=[0, 0, -9.81]),
    "plane": lambda cell, _: cell.update(plane="upright"),
    "robots[0].urdf": lambda cell, _: _given(cell, 0, urdf=""),
    "robots[0].base.xyz": lambda cell, _: cell["robots"][0]["base"].update(xyz=[1.0, 2.0]),
    "robots[0].motors.friction.coulomb": lambda cell, _: cell["robots"][0].update(
        motors={"friction": {"coulomb": "no"}}
    ),
    "robots[1].posture[2]": lambda cell, _: cell["robots"][1]["posture"].__setitem__(2, None),
    "robots[1].torque.upper[0]": lambda cell, _: _given(cell, 1, torque={"lower": [-1.0], "upper": ["x"]}),
    "robots[1].contact[0].pad.friction": lambda cell, _: _given(cell, 1, contact=[{"pad": {"friction": "x"}}]),
    "duration": lambda _, motion: motion.update(duration=0),
    "profile": lambda _, motion: motion.update(profile="fast"),
    "start.rpy[1]": lambda _, motion: motion["start"].update(rpy=[0, "x", 0]),
    "end.xyz": lambda _, motion: motion["end"].update(xyz=[0, 1]),
    "'finish'": lambda _, motion: motion.update(finish={}),
}
"""Mistakes that break a rule of a file, by what a message of theirs says; any of them together."""
