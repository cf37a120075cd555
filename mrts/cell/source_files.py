# SPDX-License-Identifier: MIT
"""What cell files and their URDFs say, as the build time reads them; nothing is generated."""

import hashlib
from pathlib import Path
from typing import Any, NamedTuple

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.urdf import Urdf
from mrts.base.manifest import MANIFEST_NAME
from mrts.base.regular_file import is_folder
from mrts.base.remark import NEAREST_INERTIA, Remark
from mrts.cell.record import CellRecord
from mrts.cell.robot import Robot

CELL_FILE = "cell.yaml"
"""What `mrts new` and `mrts demo` call a cell file."""


def is_generated(path: Path) -> bool:
    """Whether a path is that of a generated cell, and not of a cell file."""
    if is_folder(path) and not (path / MANIFEST_NAME).exists():
        inside = path / CELL_FILE
        named = f"the cell file in it: {inside}" if inside.exists() else "a cell file"
        raise InputError(
            path, f"is a folder without {MANIFEST_NAME}, so `mrts generate` did not write it; name {named}."
        )
    return is_folder(path) or path.name == MANIFEST_NAME


class UrdfReading(NamedTuple):
    """What is in a URDF, and all that is wrong with it.

    Attributes:
        path: Of the file.
        urdf: Its links and joints; None if they are none.
        mistakes: All that breaks a rule.
        remarks: What is let pass.
    """

    path: Path
    urdf: Urdf | None
    mistakes: tuple[InputError, ...]
    remarks: tuple[Remark, ...] = ()


def described(path: Path) -> Any:
    """A validated cell file: `references` are the files that it names, `model_dump` its keys with defaults."""
    from mrts.cell.cell_file import read_cell_description  # noqa: PLC0415 (build time, on demand)

    return read_cell_description(path)


def urdf_files(path: Path) -> dict[str, tuple[Path, str | None]]:
    """URDF and base link (None is its root) of every robot of a cell file, by name."""
    description = described(path)
    return {
        robot.name: (reference.path(path, path.resolve().parent), robot.base_link)
        for robot, reference in zip(description.robots, description.urdf_references, strict=True)
    }


def urdf_of(robot: Robot, folder: Path) -> Path:
    """The URDF of an arm of a cell whose files are relative to a folder."""
    from mrts.base.formats.file_reference import FileReference  # noqa: PLC0415 (build time, on demand)

    return FileReference(robot.source.urdf).path(folder / CELL_FILE, folder)


def read_urdf(where: Path, folder: Path, urdf: str) -> UrdfReading:
    """A URDF with all that is wrong with it.

    Raises:
        InputError: If it names a package that is nowhere.
    """
    from mrts_codegen.urdf.urdf_file import parse_parts, parse_urdf  # noqa: PLC0415 (build time, on demand)
    from mrts_codegen.urdf.urdf_survey import urdf_mistakes  # noqa: PLC0415

    from mrts.base.formats.file_reference import FileReference  # noqa: PLC0415

    reference = FileReference(urdf, key="")
    path = reference.path(where, folder)
    try:
        content = reference.content(where, folder)
        mistakes, remarks = urdf_mistakes(path, *parse_parts(path, content))
    except InputError as error:
        return UrdfReading(path, None, error.each())
    try:
        return UrdfReading(path, parse_urdf(path, content), mistakes, remarks)
    except InputError as error:
        return UrdfReading(path, None, (*error.each(), *mistakes), remarks)


def arm_of_urdf(path: Path, urdf: Urdf, base_link: str | None, tip_link: str) -> tuple[Robot, Array]:
    """The arm from a base link, None for the root, to a tip link, and centres of mass of its joints' bodies."""
    from mrts_codegen.urdf.urdf_survey import arm_chain  # noqa: PLC0415 (build time, on demand)

    robot, com = arm_chain(path, urdf, base_link, tip_link)
    return robot, com


def chain_of(cell: CellRecord, robot: Robot, folder: Path) -> Any:
    """The chain of an arm of a cell, with the masses that its functions were generated with; files are in a folder.

    Raises:
        InputError: If its URDF is not there as it was.
    """
    from mrts_codegen.urdf.robot_model import build_robot_model  # noqa: PLC0415 (build time, on demand)
    from mrts_codegen.urdf.urdf_file import parse_urdf  # noqa: PLC0415

    from mrts.base.formats.file_reference import FileReference  # noqa: PLC0415

    reference, where, source = FileReference(robot.source.urdf), folder / CELL_FILE, robot.source
    path, content = reference.path(where, folder), reference.content(where, folder)
    if hashlib.sha256(content).hexdigest() != source.sha256:
        raise InputError(path, "is another file than the cell was made from. Read the cell again.")
    lenient = any(remark.code == NEAREST_INERTIA for remark in cell.remarks)
    urdf = parse_urdf(path, content)
    return build_robot_model(path, urdf, source.base_link, source.tip_link, robot.held, lenient=lenient)


def read_without_generating(path: Path) -> tuple[Any, tuple[InputError, ...]]:
    """A cell with its URDFs (None if something is wrong), and all that is wrong."""
    from mrts_codegen.cell_model import read_cell  # noqa: PLC0415 (build time, on demand)

    model, mistakes = read_cell(path)
    return model, mistakes
