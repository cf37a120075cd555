# SPDX-License-Identifier: MIT
"""Units of the numbers of a cell file and a motion file."""

from collections.abc import Sequence

from mrts.cell.robot import Robot
from mrts.studies.number_paths import Keys

BY_KEY = {
    "xyz": "m",
    "rpy": "rad",
    "duration": "s",
    "gravity": "m/s²",
    "inertia": "kg m²",
    "linear": "m/s",
    "angular": "rad/s",
    "mass": "kg",
    "half_width": "m",
    "radius": "m",
    "force": "N",
    "holding_force": "N",
}
"""Unit of every number at or inside of a key."""

OF_VARIATION = {"m": "kg m", "c": "m"}
"""Unit of a range of the object's variation by the first letter of its key (mx, com_x); factors have none."""

OF_JOINT = {
    "posture": ("rad", "m"),
    "torque": ("N m", "N"),
    "armature": ("kg m²", "kg"),
    "coulomb": ("N m", "N"),
    "viscous": ("N m s/rad", "N s/m"),
    "torque_rate": ("N m/s", "N/s"),
    "jerk": ("rad/s³", "m/s³"),
    "rated": ("N m", "N"),
}
"""Units of what a joint has: of a revolute one, and of a prismatic one."""


def number_unit(keys: Keys, robots: Sequence[Robot], wrench_units: Sequence[str]) -> str:
    """Unit of the number at a place; empty if it has none, or its file does not say.

    Args:
        keys: The place.
        robots: Of the cell.
        wrench_units: Of the cell's contact wrenches.
    """
    words = [key for key in keys if isinstance(key, str)]
    index = keys[-1] if isinstance(keys[-1], int) else 0
    if "variation" in words:
        key = words[words.index("variation") + 1]
        return "" if key == "mass" else OF_VARIATION.get(key[0], "")
    if words[:2] == ["cell", "robots"] and isinstance(keys[2], int):
        robot, inside = robots[keys[2]], words[2:]
        if inside[0] == "wrench" or "box" in inside:
            return wrench_units[index]
        if inside[0] == "contact_rate":
            return ("N/s", "N m/s")[index]
        if "torque_speed" in inside:
            curve = keys[-3] if isinstance(keys[-3], int) else 0
            turning = robot.joint_types[curve] == "revolute"
            return (("rad/s", "N m") if turning else ("m/s", "N"))[index]
        for word in inside:
            if word in OF_JOINT:
                return OF_JOINT[word][robot.joint_types[index] == "prismatic"]
    return next((BY_KEY[word] for word in words if word in BY_KEY), "")
