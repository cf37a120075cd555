# SPDX-License-Identifier: MIT
"""A cell as a cell file, and as a manifest."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from mrts.base.argument_types import as_path
from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import InputError
from mrts.base.load_box import load_vector
from mrts.cell.cell import Cell
from mrts.cell.record import CellManifest, CellRecord
from mrts.cell.robot import Robot, RobotSource
from mrts.cell.source_files import cell_file_in


def cell_text(cell: Cell, path: Path | str | None) -> str:
    """The text of a cell file; see `mrts.Cell.to_yaml`."""
    target = None if path is None else as_path("path", path)
    _refuse_what_no_file_holds(cell)
    assert cell.folder is not None  # noqa: S101 (refused above)
    try:
        beside = None if target is None else target.resolve().parent
    except (OSError, RuntimeError, ValueError):  # a loop of links, a NUL
        raise InputError("path", "is no path of a file.", value=str(path)) from None
    robots = tuple(replace(robot, source=_source_now(robot)) for robot in cell.robots)
    text = cell_file_in(manifest_of(cell).model_copy(update={"robots": robots}), cell.folder, beside)
    if target is not None:
        write_text_atomically(target, text)
    return text


def _refuse_what_no_file_holds(cell: Cell) -> None:
    where, moments = f"cell '{cell.name}'", cell.load[1:4]
    if cell.reserve:
        rule = "a cell file holds no reserve: write cell.with_reserve(0), and give the reserve to what is asked of it."
        raise InputError(where, rule, key="reserve", value=cell.reserve)
    if cell.limits:
        rule = "a cell file holds no functions: write cell.with_limits(), and give them to the cell that is read."
        raise InputError(where, rule, key="limits")
    if not cell.enforces_velocity_limits:
        rule = "a cell file cannot leave velocity limits out: write the cell before without_velocity_limits()."
        raise InputError(where, rule, key="enforces_velocity_limits", value=False)
    if np.any(moments):
        rule = "a cell file's object has its centre of mass at the origin of its frame, so it holds no first moments."
        raise InputError(where, rule, key="load", value=moments.tolist())
    box = cell.load_box
    if box is not None and not np.array_equal(load_vector(box.mass, moments, box.inertia), cell.load):
        rule = "its ranges are about another load than the cell carries. Give them anew: cell.with_variation(…)."
        raise InputError(where, rule, key="load_box", value=box.mass)
    if cell.folder is None:
        rule = (
            "it is not known where its URDFs are, because it was read from generated files or a saved result. Read its "
            "cell file: mrts.load_cell(path)."
        )
        raise InputError(where, rule, key="folder")


def manifest_of(cell: Cell) -> CellManifest:
    """The manifest of a cell as it is now."""
    ours = {name: getattr(cell, name) for name in CellRecord.model_fields}
    try:
        CellRecord(**ours)
    except InputError:
        raise InputError(
            "cell",
            "its name and its robots' names must be letters, digits and single underscores to be saved.",
            value=cell.name,
        ) from None
    return cell.functions.manifest.model_copy(update=ours).sealed()


def _source_now(robot: Robot) -> RobotSource:
    """Where an arm is from, without the limits and the friction of its URDF where it has others now."""
    source = robot.source
    return replace(
        source,
        effort=source.effort if robot.has_urdf_torque else None,
        friction=source.friction if robot.has_urdf_friction else None,
    )
