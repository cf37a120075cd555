# SPDX-License-Identifier: MIT
"""Paths to numbers of a cell and a motion file, such as `robots.left.base.xyz[0]`, `motion.duration`; their units."""

import re
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from typing import Any

from mrts.base.errors import InputError, did_you_mean, is_number
from mrts.base.load_box import UNITS
from mrts.cell.motors import PER_JOINT, RATINGS
from mrts.cell.robot import Robot

Keys = tuple[str | int, ...]
"""Where a number stands, from "cell" or "motion" inward."""

ONE_FOR_ALL = frozenset(PER_JOINT)
"""Keys of `motors` where one number stands for all joints."""

NOTHING_THERE = "the file says nothing of {}, and there is no default. Write it there first."

NEED_NOT_BE_GIVEN = frozenset({"linear", "angular", "speed", "acceleration", "friction", "height", *RATINGS})
"""Keys where null stands for a number that is not limited or not known; so it does in lists of limits."""

BY_UNIT = {
    "m": ("xyz", "half_width", "height", "point", "at", "radius", "length", "box"),
    "rad": ("rpy",),
    "s": ("duration",),
    "m/s": ("linear", "speed"),
    "rad/s": ("angular",),
    "m/s²": ("gravity",),
    "kg": ("mass",),
    "kg m²": ("inertia",),
    "N": ("force", "holding_force"),
    "W": ("power",),
}
BY_KEY = {key: unit for unit, keys in BY_UNIT.items() for key in keys}

BY_UNITS_OF_JOINT = {
    ("rad", "m"): ("posture",),
    ("rad/s", "m/s"): ("velocity",),
    ("rad/s²", "m/s²"): ("acceleration",),
    ("rad/s³", "m/s³"): ("jerk",),
    ("N m", "N"): ("torque", "coulomb", "rated"),
    ("N m/s", "N/s"): ("torque_rate",),
    ("N m s/rad", "N s/m"): ("viscous",),
    ("kg m²", "kg"): ("armature",),
    ("W", "W"): ("power",),
}
OF_JOINT = {key: units for units, keys in BY_UNITS_OF_JOINT.items() for key in keys}
"""Units of what a joint has: of a revolute one, and of a prismatic one."""

OF_CURVE = ("rad/s", "N m"), ("m/s", "N")


def find_keys(files: Mapping[str, Any], joints: list[int], path: str) -> Keys:
    """Where a path leads.

    Args:
        files: Keys and values of the "cell" and, if there is one, the "motion" file, what they leave out filled in.
            Where one number stands for all joints and the path names a joint, it becomes a list here.
        joints: Number of joints of each robot.
        path: As a user writes it; `robots.left` and `robots[0]` are the same, and so are `duration` and
            `motion.duration`.

    Raises:
        InputError: If it leads to no number.
    """
    first = re.match(r"[^.\[]*", path)
    top = first.group() if first else ""
    if top == "motion":
        keys: Keys = ("motion",)
        rest = path[len(top) :]
    else:
        keys = ("motion" if top in files.get("motion", {}) and top not in files["cell"] else "cell",)
        rest = f".{path}"
    if keys[0] not in files:
        raise InputError("", "is of a motion: paths of a cell begin in its file.")
    if keys == ("motion",) and not files["motion"]:
        raise InputError("", "the motion is a table, of which no number varies. Give it by poses to vary it.")
    here = value_at(files, keys)
    while rest:
        if rest.startswith("[") and is_number(here) and keys[-1] in ONE_FOR_ALL:
            robot = keys[2]
            here = [here] * joints[robot if isinstance(robot, int) else 0]
            value_at(files, keys[:-1])[keys[-1]] = here
        key, rest = _step(here, keys, rest, files)
        keys, here = (*keys, key), here[key]
    if here is None and not isinstance(keys[-1], int) and keys[-1] not in NEED_NOT_BE_GIVEN:
        raise InputError("", NOTHING_THERE.format(path_text(files, keys)))
    return keys


def path_text(files: Mapping[str, Any], keys: Keys) -> str:
    """The path to a place as results name it: robots by name, numbers of the motion file after `motion`."""
    text = "motion" if keys[0] == "motion" else ""
    here = value_at(files, keys[:1])
    for place, key in enumerate(keys[1:], start=1):
        named = isinstance(key, int) and place == 2 and keys[1] == "robots"  # noqa: PLR2004 (cell, robots, this)
        here = here[key]
        word = here["name"] if named else key
        text += f"[{word}]" if isinstance(word, int) else f".{word}" if text else word
    return text


def value_at(files: Mapping[str, Any], keys: Keys) -> Any:
    """What stands at a place."""
    here: Any = files
    for key in keys:
        here = here[key]
    return here


def numbers_below(files: Mapping[str, Any], keys: Keys) -> Iterator[Keys]:
    """The places of all numbers at a place and inside of it."""
    here = value_at(files, keys)
    if is_number(here):
        yield keys
    elif isinstance(here, dict):
        for key in here:
            yield from numbers_below(files, (*keys, key))
    elif isinstance(here, list):
        for index in range(len(here)):
            yield from numbers_below(files, (*keys, index))


def number_unit(keys: Keys, robots: Sequence[Robot], wrench_units: Sequence[str]) -> str:
    """Unit of the number at a place; empty if it has none, or its file does not say."""
    words = [key for key in keys if isinstance(key, str)]
    if "variation" in words:
        return UNITS.get(words[words.index("variation") + 1], "")
    if words[:2] == ["cell", "robots"] and isinstance(keys[2], int):
        unit = _robot_unit(keys, words[2:], robots[keys[2]], wrench_units)
        if unit is not None:
            return unit
    if "acceleration" in words:
        return f"{BY_KEY.get(words[-1], 'm/s')}²"
    return next((BY_KEY[word] for word in words if word in BY_KEY), "")


def _robot_unit(keys: Keys, inside: list[str], robot: Robot, wrench_units: Sequence[str]) -> str | None:
    index = keys[-1] if isinstance(keys[-1], int) else 0
    if inside[0] == "fixed":
        return ""
    if inside[0] == "wrench" or "box" in inside:
        return wrench_units[index]
    if inside[0] == "contact_rate":
        return ("N/s", "N m/s")[index]
    if "torque_speed" in inside:
        curve = keys[-3] if isinstance(keys[-3], int) else 0
        return OF_CURVE[robot.joint_types[curve] == "prismatic"][index]
    if "frames" in inside:
        return None
    of_joint = next((OF_JOINT[word] for word in inside if word in OF_JOINT), None)
    return None if of_joint is None else of_joint[robot.joint_types[index] == "prismatic"]


def with_place(file: dict[str, Any], filled: Mapping[str, Any], keys: Keys) -> None:
    """Write into a file what it leaves out on the way to a place, so that the place is there."""
    here: Any = file
    full: Any = filled
    for key in keys[:-1]:
        full = full[key]
        there = here.get(key) if isinstance(here, dict) else here[key]
        if not isinstance(there, dict | list) or (isinstance(there, list) and len(there) != len(full)):
            here[key] = deepcopy(full)
        here = here[key]


def set_value(file: dict[str, Any], keys: Keys, value: Any) -> None:
    """Write a value at a place, from the file's own keys inward."""
    value_at(file, keys[:-1])[keys[-1]] = value


def _step(here: Any, keys: Keys, rest: str, files: Mapping[str, Any]) -> tuple[str | int, str]:
    where = path_text(files, keys) or "the cell file"
    if here is None:
        raise InputError("", NOTHING_THERE.format(where))
    if not isinstance(here, dict | list):
        raise InputError("", f"{where} is {here!r}; nothing stands inside of it.")
    if isinstance(here, dict):
        names: dict[str, str | int] = {key: key for key in here}
        inside = "; ".join(here)
    else:
        names = {each["name"]: at for at, each in enumerate(here) if isinstance(each, dict) and "name" in each}
        inside = f"{where}[0] to {where}[{len(here) - 1}]"
        index = re.match(r"\[(\d{1,9})\]", rest)
        if index and int(index.group(1)) < len(here):
            return int(index.group(1)), rest[index.end() :]
    path = rest.removeprefix(".")
    if not here or not names or path == rest:
        raise InputError("", f"{where} has {len(here)} values: {inside}." if here else f"{where} is empty.")
    fitting = [name for name in names if path == name or path.startswith((f"{name}.", f"{name}["))]
    if fitting:
        name = max(fitting, key=len)  # names may hold dots
        return names[name], path[len(name) :]
    wrong = re.split(r"[.\[]", path)[0]
    raise InputError("", f"there is no '{wrong}' in {where}{did_you_mean(wrong, names)} There are {', '.join(names)}.")
