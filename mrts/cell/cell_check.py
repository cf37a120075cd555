# SPDX-License-Identifier: MIT
"""What of a cell may be changed in Python: not what its functions were generated with, and no arm out of its place."""

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from mrts.base.errors import InputError
from mrts.base.rigid_transform import RigidTransform, base_leaves, grasp_leaves, in_one_place
from mrts.cell.robot import Robot

if TYPE_CHECKING:
    from mrts.cell.cell import Cell

OF_CELL = ("name", "plane", "wrench_components", "machines")

OF_CHAINS = ("name", "joints", "joint_types", "axes", "points", "held", "held_numbers", "T_base_tip")
"""Attributes of a robot that its URDF gives, or that name inputs and outputs of the generated functions."""

SAME_NUMBER = 1e-12
"""Largest difference of what is the same number after rounding [m, rad, m/s²]."""

IN_CHAINS = (
    "is part of the generated functions, so changing it in Python would be ignored there. Change the cell file (name, "
    "plane, fixed, robots) or the URDF, and read it again: mrts.load_cell(path)."
)


def check_generated(cell: "Cell") -> None:
    """Check that what the generated functions hold is what they were generated with."""
    made = cell.functions.manifest.cell
    of_cell = [(key, getattr(cell, key), getattr(made, key)) for key in OF_CELL]
    ours, theirs = ([robot.name for robot in robots] for robots in (cell.robots, made.robots))
    for key, one, other in (*of_cell, ("robots", ours, theirs), *_of_chains(cell)):
        if not _same(one, other):
            raise InputError("cell", IN_CHAINS, key=key)


def check_placement(cell: "Cell") -> None:
    """Check that arms which stand or hold elsewhere than their file says still keep to the rules of the file."""
    moved = [ours.T_world_base is not theirs.T_world_base for ours, theirs in _changed(cell)]
    for robot, generated in _changed(cell):
        where = f"robot '{robot.name}'"
        if cell.plane is not None:
            problem = base_leaves(cell.plane, robot.T_world_base.R)
            if problem:
                raise InputError(where, problem, key="base")
            tip = robot.source.tip_link
            problem = grasp_leaves(cell.plane, robot.T_object_tip.R, generated.T_base_tip.R, tip)
            if problem:
                raise InputError(where, problem, key="grasp")
    if any(moved):
        _check_machines(cell)


def _check_machines(cell: "Cell") -> None:
    """Arms of one machine stay where they are on it, and no two copies of one machine stand in one place."""
    arms = zip(cell.robots, cell.functions.manifest.robots, strict=True)
    for (one, one_made), (other, other_made) in combinations(arms, 2):
        first, second = one_made.source, other_made.source
        if first.sha256 != second.sha256:
            continue
        names = f"robots '{one.name}' and '{other.name}'"
        if (one.name, other.name) in cell.machines:
            kept = one_made.T_world_base.inverse() @ other_made.T_world_base
            if not in_one_place(one.T_world_base.inverse() @ other.T_world_base, kept):
                raise InputError(
                    "cell",
                    f"{names} are arms of one machine (one URDF in one place): their bases move together. Give both in "
                    "one step: mrts.Cell.from_description, or dataclasses.replace(cell, robots=…).",
                    key="base",
                )
        elif in_one_place(one.T_world_base @ first.T_base_root, other.T_world_base @ second.T_base_root):
            raise InputError(
                "cell",
                f"{names} would stand in one place, which makes them arms of one machine (they have one URDF). Move "
                "one of them, or say so in a cell file, which is checked against the URDF.",
                key="base",
            )


def _changed(cell: "Cell") -> Iterator[tuple[Robot, Robot]]:
    """Robots that are others than those generated, with these."""
    pairs = zip(cell.robots, cell.functions.manifest.robots, strict=False)
    return ((robot, generated) for robot, generated in pairs if robot is not generated)


def _of_chains(cell: "Cell") -> Iterator[tuple[str, object, object]]:
    for robot, generated in _changed(cell):
        for name in OF_CHAINS:
            yield f"robot '{robot.name}' {name}", getattr(robot, name), getattr(generated, name)


def _same(ours: object, theirs: object) -> bool:
    if isinstance(ours, RigidTransform) and isinstance(theirs, RigidTransform):
        ours, theirs = ours.numbers, theirs.numbers
    if isinstance(ours, np.ndarray) and isinstance(theirs, np.ndarray):
        return theirs.shape == ours.shape and bool(np.all(np.abs(ours - theirs) <= SAME_NUMBER))
    return ours == theirs
