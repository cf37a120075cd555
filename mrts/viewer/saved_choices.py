# SPDX-License-Identifier: MIT
"""Choices saved as a cell file and a motion file: what was edited and nothing else, or not at all."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mrts.base.arrays import Array
from mrts.base.atomic_file import text_writer, write_together
from mrts.base.edited_yaml import Key, edited_yaml
from mrts.base.errors import InputError
from mrts.base.input_file import read_text
from mrts.base.yaml_parser import parse_yaml, yaml_text
from mrts.cell.cell import Cell
from mrts.cell.cell_keys import cell_keys, pose_keys
from mrts.cell.generation import cell_model, described_model
from mrts.cell.loading import uncompiled_cell
from mrts.motion.motion_file import MotionDescription
from mrts.viewer.choices import Choices, Given

SUFFIXES = {".yaml", ".yml"}
LONGEST_NAME = 100
"""Of a file, in bytes: file systems count these."""

SAME = 1e-12
"""Numbers of a saved cell that differ by no more from the wanted ones are these: angles pass through cosines."""

ANEW = (
    "The {} file was written anew, without the comments of the original: it gives an edited value in a form that is "
    "not edited in place."
)

Edits = dict[tuple[Key, ...], Any]


def save_choices(
    given: Given, choices: Choices, cell_name: str, motion_name: str, *, overwrite: bool
) -> tuple[list[Path], str]:
    """Write the cell and, where it is described by poses and has a name, the motion as they were chosen; both or none.

    Returns:
        The files, and a remark, empty where there is none.

    Raises:
        InputError: If a name is no name of a file, a file exists and may not be replaced, or cannot be written.
    """
    if given.cell_path is None:
        raise InputError("saving", "takes a cell file; this cell is from generated files, or a variant of a study.")
    folder = given.cell_path.resolve().parent
    texts: dict[Path, str] = {}
    target = _target(folder, "cell file", cell_name)
    texts[target], remark = _cell_text(choices, given.cell_path, target)
    if motion_name:
        motion = _target(folder, "motion file", motion_name)
        if motion == target:
            raise InputError("motion file", "has the name of the cell file.", value=motion_name)
        texts[motion], further = motion_text(given, choices)
        remark = " ".join(filter(None, [remark, further]))
    for path in texts:
        if not overwrite and (path.exists() or path.is_symlink()):
            raise InputError(path, "exists already: choose another name, or allow to replace it.")
        if path.is_symlink() or (path.exists() and not path.is_file()):
            raise InputError(path, "is a link or no file: choose another name.")
    write_together({path: text_writer(text) for path, text in texts.items()})
    return list(texts), remark


def _target(folder: Path, where: str, name: str) -> Path:
    is_name = name.isprintable() and Path(name).name == name and not name.startswith(".") and "\\" not in name
    if not is_name or Path(name).suffix.lower() not in SUFFIXES or len(name.encode()) > LONGEST_NAME:
        rule = f"must be a name of at most {LONGEST_NAME} bytes that ends in .yaml, without a folder."
        raise InputError(where, rule, value=name)
    return folder / name


def _cell_text(choices: Choices, path: Path, target: Path) -> tuple[str, str]:
    """The original text with the edited keys; where that does not read back to the cell, a text written anew."""
    original = uncompiled_cell(cell_model(path), path.resolve().parent)
    wanted = choices.cell(original)

    def is_wanted(read: Any) -> bool:
        return _same(uncompiled_cell(described_model(read, target.parent), target.parent), wanted)

    return _edited_or_anew("cell", path, _cell_edits(original, wanted), is_wanted, wanted.to_yaml)


def _edited_or_anew(
    what: str, path: Path, edits: Edits, is_wanted: Callable[[Any], bool], anew: Callable[[], str]
) -> tuple[str, str]:
    before = read_text(path, f"{what} file")
    try:
        text = edited_yaml(before, edits)
        if is_wanted(parse_yaml(text)):
            return text, ""
    except (InputError, ValueError, yaml.YAMLError):
        pass
    return anew(), ANEW.format(what)


def _cell_edits(original: Cell, wanted: Cell) -> Edits:
    before, after = cell_keys(original), cell_keys(wanted)
    edits: Edits = {} if original.mass == wanted.mass else {("object", "mass"): wanted.mass}
    for index, (old, new) in enumerate(zip(before["robots"], after["robots"], strict=True)):
        for key in ("base", "grasp", "torque", "wrench"):
            if old[key] == new[key]:
                continue
            if key in {"base", "grasp"} and old[key]["rpy"] == new[key]["rpy"]:  # a file may give it in another form
                edits["robots", index, key, "xyz"] = new[key]["xyz"]
            else:
                edits["robots", index, key] = new[key]
    return edits


def _same(one: Cell, other: Cell) -> bool:
    ours, theirs = cell_keys(one), cell_keys(other)
    for robot in [*ours["robots"], *theirs["robots"]]:
        del robot["base"], robot["grasp"]
    return ours == theirs and np.allclose(_numbers(one), _numbers(other), rtol=SAME, atol=SAME)


def _numbers(cell: Cell) -> Array:
    contacts = [side for robot in cell.robots for own in robot.contacts for side in (own.lower, own.upper)]
    return np.concatenate([cell.geometry, *contacts])


def motion_text(given: Given, choices: Choices) -> tuple[str, str]:
    """The original text with the edited ends, or one written anew where that does not read back, and a remark on that.

    Raises:
        InputError: If the motion is from a table, or its file cannot be read.
    """
    described = choices.description(given)
    if described is None or given.motion_path is None:
        raise InputError("motion file", "a motion from a table has no ends that could have moved: save the cell alone.")
    where: dict[str, tuple[Key, ...]] = {"start": ("start",), "end": ("end",)}
    if described.waypoints:
        where = {"start": ("waypoints", 0), "end": ("waypoints", len(described.waypoints) - 1)}
    edits = {where[place.kind]: pose_keys(pose) for place, pose in choices.poses.items() if not place.robot}
    whole = {key: value for key, value in described.model_dump().items() if value is not None}
    return _edited_or_anew(
        "motion",
        given.motion_path,
        edits,
        lambda read: MotionDescription(**read) == described,
        lambda: yaml_text(whole),
    )
