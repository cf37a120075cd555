# SPDX-License-Identifier: MIT
"""A cell file and a motion file with all that they leave out: every number that a path can lead to."""

from copy import deepcopy
from pathlib import Path
from typing import Any

from mrts.base.errors import InputError
from mrts.base.input_file import read_text
from mrts.base.yaml_parser import MAX_YAML_BYTES, parse_yaml
from mrts.cell.cell import Cell
from mrts.cell.generation import all_cell_keys
from mrts.cell.robot import Robot
from mrts.motion.motion_file import DEFAULT_SAMPLES, KINDS, MotionDescription


def given_keys(path: Path, what: str) -> dict[str, Any]:
    """Keys and values of a YAML file as they stand there.

    Args:
        path: A file that has been validated.
        what: What it is, for messages.

    Raises:
        InputError: If it has changed since.
    """
    keys = parse_yaml(read_text(path, what, MAX_YAML_BYTES))
    if not isinstance(keys, dict):
        raise InputError(path, f"this {what} changed while it was read. Read the study again.")
    return keys


def filled_cell(path: Path, given: dict[str, Any], cell: Cell) -> dict[str, Any]:
    """A cell file's keys with all that it leaves out, and limits that it does not give as empty places.

    Args:
        path: The cell file.
        given: Its keys as they stand there.
        cell: The cell that it describes.

    Raises:
        InputError: If the file breaks a rule.
    """
    filled = all_cell_keys(path)
    for robot, arm, as_given in zip(filled["robots"], cell.robots, given["robots"], strict=True):
        _fill_robot(robot, arm, len(cell.wrench_components))
        robot["contact"] = deepcopy(as_given.get("contact") or [])
    return filled


def _fill_robot(robot: dict[str, Any], arm: Robot, components: int) -> None:
    """Fill in what a robot takes from its URDF, and places for what is not limited."""
    if robot["torque"] is None:
        robot["torque"] = arm.torque_upper.tolist()  # the URDF's effort is symmetric
    for side in ("lower", "upper"):
        robot["wrench"][side] = robot["wrench"][side] or [None] * components
    robot["contact_rate"] = robot["contact_rate"] or [None, None]
    if not isinstance(robot["motors"]["friction"], dict):
        friction = {"coulomb": arm.motors.coulomb.tolist(), "viscous": arm.motors.viscous.tolist()}
        robot["motors"]["friction"] = friction


def filled_motion(given: dict[str, Any]) -> dict[str, Any]:
    """A motion file's keys with the parts of poses and the number of samples that it leaves out.

    Args:
        given: Its keys as they stand there; a path of poses.
    """
    filled = MotionDescription(**given).model_dump()
    filled["samples"] = filled["samples"] or DEFAULT_SAMPLES
    return {key: value for key, value in filled.items() if value is not None}


def is_path_of_poses(given: dict[str, Any]) -> bool:
    """Whether a motion file gives poses, not a table."""
    return not (set(KINDS) - {"start", "waypoints"}) & set(given)
