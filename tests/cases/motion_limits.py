"""The shipped cell of two arms with every key of the cell file that limits the motion alone."""

from copy import deepcopy

import yaml
from conftest import DATA

import mrts

UR5 = DATA.parent / "dual_ur5"

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
    """Of the cell file, as a dictionary."""
    given = yaml.safe_load((UR5 / "cell.yaml").read_text(encoding="utf-8"))
    for robot in given["robots"]:
        robot["urdf"] = str(UR5 / robot["urdf"])
    given["object"] |= OBJECT
    given["robots"][0] |= LEFT
    given["robots"][1] |= RIGHT | of_right
    return deepcopy(given)


def limited_cell(**of_right):
    """The cell."""
    return mrts.Cell.from_description(description(**of_right))
