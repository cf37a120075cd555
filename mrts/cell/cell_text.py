# SPDX-License-Identifier: MIT
"""A cell as a cell file, and as a manifest."""

from pathlib import Path

import numpy as np

from mrts.base.argument_types import as_path
from mrts.base.arrays import without_infinity
from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import InputError
from mrts.base.load_box import load_vector
from mrts.base.manifest import Manifest
from mrts.cell.cell import Cell
from mrts.cell.robot import robot_record
from mrts.cell.source_files import cell_file_in


def cell_text(cell: Cell, path: Path | str | None) -> str:
    """The text of a cell file; see `mrts.Cell.to_yaml`.

    Raises:
        InputError: If a cell file cannot hold the cell, a URDF is not there as it was, or the file cannot be written.
    """
    target = None if path is None else as_path("path", path)
    _refuse_what_no_file_holds(cell)
    assert cell.folder is not None  # noqa: S101 (refused above)
    try:
        beside = None if target is None else target.resolve().parent
    except (OSError, RuntimeError, ValueError):  # a loop of links, a NUL
        raise InputError("path", "is no path of a file.", value=str(path)) from None
    text = cell_file_in(manifest_of(cell), cell.folder, beside)
    if target is not None:
        write_text_atomically(target, text)
    return text


def _refuse_what_no_file_holds(cell: Cell) -> None:
    where, moments = f"cell '{cell.name}'", cell.load[1:4]
    if cell.reserve:
        rule = "a cell file holds no reserve: write cell.with_reserve(0), and give the reserve to what is asked of it."
        raise InputError(where, rule, key="reserve", value=cell.reserve)
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


def manifest_of(cell: Cell) -> Manifest:
    """The manifest of a cell as it is now.

    Raises:
        InputError: If a manifest cannot hold it.
    """
    generated, box = cell.functions.manifest, cell.load_box
    linear, angular = without_infinity(cell.object_velocity_limit)
    carried = {
        "mass": cell.mass if box is None else box.mass,
        "inertia": (cell.inertia if box is None else box.inertia).tolist(),
        "variation": {} if box is None else dict(box.ranges),
        "outer_hull": box is not None and box.outer_hull,
        "linear_velocity": linear,
        "angular_velocity": angular,
        "shape": None if cell.object_shape is None else cell.object_shape.model_dump(),
    }
    try:
        robots = [robot_record(robot, record) for robot, record in zip(cell.robots, generated.robots, strict=True)]
        ours = {"name": cell.name, "gravity": cell.gravity.tolist(), "robots": robots}
        changed = generated.model_copy(update=ours).model_dump()
        return type(generated).model_validate(changed | {"object": carried}).sealed()
    except ValueError:
        raise InputError(
            "cell",
            "its name and its robots' names must be letters, digits and single underscores, and its torque limits, "
            "postures and poses finite, to be saved.",
            value=cell.name,
        ) from None
