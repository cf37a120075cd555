# SPDX-License-Identifier: MIT
"""A cell file and its URDFs with all that is wrong with them."""

from pathlib import Path
from typing import Any

from mrts_codegen.cell_file import CellDescription, RobotDescription
from mrts_codegen.cell_model import CellModel, build_cell_model, build_robot
from mrts_codegen.urdf.planar_cell import PLANE_COMPONENTS

from mrts.base.errors import InputError, Mistakes
from mrts.base.input_file import read_data, validated


def read_cell(path: Path) -> tuple[CellModel | None, tuple[InputError, ...]]:
    """A cell file with its URDFs, None if something is wrong, and all that is."""
    mistakes = Mistakes()
    with mistakes.noted():
        data = read_data(path, "cell file")
        try:
            description = validated(path, data, CellDescription, "cell file")
        except InputError as error:
            mistakes.add(error)
            _read_robots(path, data, mistakes)
        else:
            return build_cell_model(path, description), ()
    return None, tuple(mistakes.found)


def _read_robots(path: Path, data: Any, mistakes: Mistakes) -> None:
    """Check every robot by itself in a file that does not describe a cell."""
    robots = data.get("robots") if isinstance(data, dict) else None
    plane = data.get("plane") if isinstance(data, dict) else None
    lenient = isinstance(data, dict) and data.get("inertia") == "lenient"
    known = (plane is None or isinstance(plane, str)) and plane in PLANE_COMPONENTS
    for index, entry in enumerate(robots if known and isinstance(robots, list) else []):
        if not isinstance(entry, dict):
            continue
        try:
            robot = RobotDescription.read(path, entry)
        except InputError:  # it has been noted with its place in the file
            continue
        with mistakes.noted():
            key, folder = f"robots[{index}] ({robot.name})", path.resolve().parent
            build_robot(path, key, robot, plane, folder, lenient=lenient)
