# SPDX-License-Identifier: MIT
"""A cell file and its URDFs with all that is wrong with them."""

from pathlib import Path
from typing import Any

from mrts_codegen.cell_file import CellDescription, RobotDescription, xacro_text
from mrts_codegen.cell_model import CellModel, build_cell_model, build_robot
from mrts_codegen.urdf.planar_cell import PLANE_COMPONENTS
from mrts_codegen.urdf.robot_model import build_robot_model
from mrts_codegen.urdf.urdf_file import parse_urdf
from mrts_codegen.urdf_reference import FileReference

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
    for index, entry in enumerate(robots if isinstance(robots, list) else []):
        if not isinstance(entry, dict):
            continue
        with mistakes.noted():
            try:
                robot = RobotDescription.read(path, entry)
            except InputError:  # it has been noted with its place in the file
                _read_chain(path, index, entry, lenient=lenient)
            else:
                if known:
                    key, folder = f"robots[{index}] ({robot.name})", path.resolve().parent
                    build_robot(path, key, robot, plane, folder, lenient=lenient)


def _read_chain(path: Path, index: int, entry: dict[str, Any], *, lenient: bool) -> None:
    """Check the URDF of a robot that says something wrong besides, as far as what it says goes."""
    reference, base_link, tip_link = (entry.get(key) for key in ("urdf", "base_link", "tip_link"))
    arguments = _xacro_arguments(entry.get("xacro_args", {}))
    if isinstance(reference, str) and reference and arguments is not None:
        named, folder = FileReference(reference, arguments, key=f"robots[{index}].urdf"), path.resolve().parent
        file = named.path(path, folder)
        urdf = parse_urdf(file, named.content(path, folder))
        if isinstance(tip_link, str) and isinstance(base_link, str | None) and "fixed" not in entry:
            build_robot_model(file, urdf, base_link, tip_link, lenient=lenient)


def _xacro_arguments(given: Any) -> dict[str, str] | None:
    if not isinstance(given, dict) or not all(isinstance(value, str | float | int) for value in given.values()):
        return None
    return {str(name): xacro_text(value) for name, value in given.items()}
