# SPDX-License-Identifier: MIT
"""A cell ready to be asked: its data and its bound functions."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate, combinations
from operator import attrgetter
from os import PathLike
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Self

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Remark, as_path, check_type, is_number
from mrts.base.formats.record import Rule
from mrts.base.load_box import LoadBox
from mrts.base.manifest import GEOMETRY, WRENCH_UNITS
from mrts.base.notebook import InNotebooks, NotebookTable
from mrts.base.regular_file import is_folder
from mrts.base.rigid_transform import in_one_place
from mrts.cell.generation import (
    GeneratedFunctions,
    compiled_functions,
    described_model,
    generated_chains,
    generated_in_cache,
    is_generated,
    motion_functions_of,
    read_to_generate,
)
from mrts.cell.record import CellRecord, other_functions, read_generated
from mrts.cell.robot import JOINT_HEAD, check_plane_kept
from mrts.kernel.cell_library import CellLibrary

IN_CHAINS = (
    "is part of the generated functions, so changing it in Python would be ignored there. Change the cell file (name, "
    "plane, fixed, robots) or the URDF, and read it again: mrts.load_cell(path)."
)


KNOWN_CELLS = 16
"""Cells of which what is the same along any motion is kept, of those asked last: a call needs it a few times."""


@dataclass(frozen=True, repr=False, eq=False)
class Cell(InNotebooks, CellRecord):
    """A record of n arms and the object that they hold, ready to be asked; m joints in all.

    Attributes:
        generated: The generated functions; they take geometry and load, and `functions` evaluates them.
        enforces_velocity_limits: Whether velocity limits bound the speed, or are reported only.
        reserve: Share of every limit that is kept free, 0 or more and below 1.
        limits: Functions of a cell and its motion that give further limits; docs/extending.md.
        folder: That the URDFs of its cell file are relative to; None where that is not known.

    All but names, joints and plane can be changed in Python, by methods of this class or `dataclasses.replace`.

    Raises:
        InputError: If a value breaks a rule, or is not what the functions were generated with.
    """

    generated: GeneratedFunctions
    enforces_velocity_limits: bool = True
    reserve: Annotated[float, Rule(ge=0, lt=1)] = 0.0
    limits: tuple[Callable[..., Any], ...] = ()
    folder: Path | None = None

    def __post_init__(self) -> None:
        if self.plane != self.generated.manifest.cell.plane:  # first: the sizes of hands are told by it
            raise InputError("cell", IN_CHAINS, key="plane")
        super().__post_init__()
        _check_changes(self)

    @classmethod
    def from_description(cls, description: Mapping[str, Any], *, folder: Path | str | None = None) -> "Cell":
        """A cell from a dictionary with the keys of a cell file, under the same rules; numpy's numbers and arrays too.

        Args:
            description: The keys; see docs/cell_file.md.
            folder: That URDFs are relative to; None is the current one.

        Raises:
            InputError: If the description or a URDF breaks a rule.
            CompilerError: If there is no C compiler, or it fails.
        """
        check_type("folder", folder, str, PathLike, NoneType)
        here = (Path() if folder is None else as_path("folder", folder)).absolute()
        return cell_of(compiled_functions(*generated_chains(described_model(description, here))), here)

    def to_yaml(self, path: Path | str | None = None) -> str:
        """The text of a cell file that reads back to an equal cell: it was read again before it is handed out.

        Some rotations come back to rounding (2e-16), all other numbers as they are.

        Args:
            path: File to write it to, whole or not at all; URDFs that are near are then given relative to it.

        Raises:
            InputError: If a cell file cannot hold what the cell is now, a URDF is not there as it was, or the file
                cannot be written.
        """
        from mrts.cell.cell_keys import cell_text  # noqa: PLC0415 (it reads cells)

        return cell_text(self, path)

    def notebook_tables(self) -> Iterator[NotebookTable]:
        """The joints of all arms with their limits."""
        rows = [(robot.name, *row) for robot in self.robots for row in robot.joint_rows()]
        yield NotebookTable(("robot", "joint", *JOINT_HEAD), rows)

    def __repr__(self) -> str:
        arms = ", ".join(f"{robot.name} ({len(robot.joints)} joints)" for robot in self.robots)
        load = f"{self.mass:.4g} kg" if self.load_box is None else self.load_box.description()
        return f"<Cell '{self.name}': {arms}; {self.plane or 'spatial'}; load {load}>"

    @cached_property
    def limits_motion(self) -> bool:
        """Whether it has limits of the motion alone, beside those of velocities of joints and object."""
        sides = [side for robot in self.robots for side in (robot.acceleration_lower, robot.acceleration_upper)]
        points = self.object_points or any(robot.point_limits for robot in self.robots)
        return bool(
            points or self.carried or np.isfinite(np.concatenate([*sides, self.object_acceleration_limit])).any()
        )

    @cached_property
    def all_remarks(self) -> tuple[Remark, ...]:
        """All that is to know of it, what its numbers look like included."""
        from mrts.cell.remarks import cell_remarks  # noqa: PLC0415 (it looks at cells)

        return tuple(cell_remarks(self))

    @cached_property
    def library(self) -> CellLibrary:
        """What was compiled of it, and the kernel with it; see `GeneratedFunctions.library`."""
        return self.generated.library

    def functions(self, name: str, samples: int, inputs: dict[str, Array]) -> dict[str, Array]:
        """Evaluate one generated function for all samples in one call; the manifest has its inputs and outputs.

        Args:
            name: Short name, such as "terms".
            samples: Number of samples N.
            inputs: By input name, Shape (N, rows), (N, rows, columns), or (rows,) for one value for all samples; the
                geometry is that of the cell unless it is given.

        Returns:
            By output name, Shape (N, rows, columns); (N, rows) for a column.
        """
        return self.library.map(name, samples, {GEOMETRY: self.geometry} | inputs)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """`left/elbow`, one a joint of all robots, m of them."""
        return tuple(f"{robot.name}/{joint}" for robot in self.robots for joint in robot.joints)

    @property
    def posture(self) -> Array:
        """Of all robots, Shape (m,) [rad or m]."""
        return self.stacked("posture")

    def stacked(self, name: str) -> Array:
        """An array of all robots, one after the other, such as "torque_lower" or "motors.jerk"."""
        return np.concatenate([*map(attrgetter(name), self.robots)])

    @cached_property
    def joint_slices(self) -> dict[str, slice]:
        """Where each robot's joints stand in a vector over all joints, Shape (m,)."""
        return _slices({robot.name: len(robot.joints) for robot in self.robots})

    @cached_property
    def wrench_slices(self) -> dict[str, slice]:
        """Where each robot's wrench stands in the stacked wrenches F, Shape (n w,)."""
        return _slices({robot.name: len(self.wrench_components) for robot in self.robots})

    @cached_property
    def wrench_units(self) -> tuple[str, ...]:
        """Unit of each component of a contact wrench: "N" of a force, "N m" of a moment."""
        return tuple(WRENCH_UNITS[component] for component in self.wrench_components)

    @property
    def mass(self) -> float:
        """Mass of the object [kg]."""
        return float(self.load[0])

    @property
    def inertia(self) -> Array:
        """Inertia of the object about its frame's origin, the nominal com, object axes, Shape (3, 3) [kg m²]."""
        xx, yy, zz, xy, xz, yz = self.load[4:]
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    def with_values(self, values: Mapping[str, Any]) -> "Cell":
        """The same cell with other values of its cell file, all changed in one step.

        Args:
            values: By path as in study files: gravity, mass and rates of the object, and what the file says of a robot
                beside its URDF: {"robots.left.base.xyz[0]": -0.45, "robots.left.torque": [...]}. A pose may be a
                `RigidTransform` too.

        Raises:
            InputError: If a path leads nowhere, or a value breaks a rule of the cell file.
        """
        from mrts.cell.cell_keys import with_values  # noqa: PLC0415 (it reads cells)

        return with_values(self, values)

    def with_mass(self, mass: float) -> "Cell":
        """The same cell carrying another mass [kg]; ranges of factors are then about that mass.

        Inertia and first moments stay as they are.

        Raises:
            InputError: Unless the mass is finite and > 0.
        """
        return self.with_values({"object.mass": mass})

    def with_load(self, load: Array) -> Self:
        """The same cell carrying a known load.

        Args:
            load: Load vector (`mrts.base.manifest.LOAD_ENTRIES`), Shape (10,), as from `LoadBox.load_at`.

        Raises:
            InputError: Unless it is finite with a mass > 0.
        """
        return replace(self, load=load, load_box=None)

    def with_variation(self, **ranges: tuple[float, float]) -> Self:
        """The same cell with a load that is known only within ranges.

        Args:
            **ranges: Least and largest value by parameter: factors mass, ixx, iyy, izz; first moments mx, my, mz
                [kg m]. None at all: the load is known.

        Raises:
            InputError: If a range breaks a rule.
        """
        if not ranges:
            return replace(self, load_box=None)
        if np.any(self.load[1:4] != 0):
            raise InputError(
                "variation",
                "ranges are about an object whose centre of mass is the origin of its frame, but this cell's load has "
                "first moments. Vary the cell's own object, with ranges of mx, my, mz.",
                value=self.load[1:4].tolist(),
            )
        return replace(self, load_box=LoadBox(self.mass, self.inertia, ranges))

    def without_wrench_limits(self) -> Self:
        """The same cell with every contact wrench and its rate unbounded, and hands that hold whatever comes."""
        none = np.full(len(self.wrench_components), np.inf)
        free: dict[str, Any] = {"wrench_lower": -none, "wrench_upper": none, "contacts": (), "contact_rate": none}
        return replace(self, robots=tuple(replace(robot, **free) for robot in self.robots))

    def without_velocity_limits(self) -> Self:
        """The same cell with velocity limits that are reported, but bound nothing."""
        return replace(self, enforces_velocity_limits=False)

    def with_reserve(self, reserve: float) -> Self:
        """The same cell with all limits moved inward, each side by a share of its size.

        Args:
            reserve: The share, 0 or more and below 1; of the limits as they are given, whatever was kept before.

        Raises:
            InputError: If it is something else.
        """
        return self if is_number(reserve) and reserve == self.reserve else replace(self, reserve=reserve)

    def with_limits(self, *limits: Callable[..., Any]) -> Self:
        """The same cell with further limits beside those of its file, in the place of any that it was given before.

        Args:
            *limits: Functions of a cell and its motion that give `mrts.limits.rows.LimitRows`; docs/extending.md.

        Raises:
            InputError: If one is no function.
        """
        return replace(self, limits=limits)

    def with_postures(self, postures: Mapping[str, Sequence[float] | Array]) -> "Cell":
        """The same cell starting near other joint positions.

        Args:
            postures: Joint positions by robot name, each Shape (n_i,) [rad or m]; other robots keep theirs.

        Raises:
            InputError: If a name is unknown or a posture has the wrong length or is not finite.
        """
        check_type("postures", postures, Mapping)
        return self.with_values({f"robots.{name}.posture": posture for name, posture in postures.items()})


def _slices(sizes: dict[str, int]) -> dict[str, slice]:
    ends = accumulate(sizes.values())
    return {name: slice(end - size, end) for (name, size), end in zip(sizes.items(), ends, strict=True)}


def load_cell(path: Path | str) -> Cell:
    """Read a cell: generate and compile it on first use, from the cache after that.

    Args:
        path: A cell file, or a folder that `mrts generate` wrote.

    Raises:
        InputError: If the cell file, a URDF or the generated folder breaks a rule.
        CompilerError: If there is no C compiler, or it fails.
    """
    path = as_path("path", path)
    if is_generated(path):
        return cell_of(compiled_functions(*read_generated(path if is_folder(path) else path.parent)))
    return cell_of(compiled_functions(*generated_in_cache(path)), path.resolve().parent)


def cell_of(generated: GeneratedFunctions, folder: Path | None = None) -> Cell:
    """The cell that the manifest of functions describes."""
    return Cell(**generated.manifest.cell.record(), generated=generated, folder=folder)


def uncompiled_cell(model: Any, folder: Path) -> Cell:
    """A cell that can follow motions, and nothing else."""
    return cell_of(motion_functions_of(model), folder)


def cell_to_compile(path: Path | str) -> Cell | None:
    """The cell of a file that is yet to be generated and compiled, as `uncompiled_cell`; None of any other."""
    path = as_path("path", path)
    if is_generated(path):
        return None
    model = read_to_generate(path)
    return None if model is None else uncompiled_cell(model, path.resolve().parent)


def _check_changes(cell: Cell) -> None:
    """Check that a cell is what its functions were generated with, and that arms keep to the rules of the file."""
    made = cell.generated.manifest.cell
    if key := other_functions(cell, made):
        raise InputError("cell", IN_CHAINS, key=key)
    changed = [pair for pair in zip(cell.robots, made.robots, strict=True) if pair[0] is not pair[1]]
    if cell.plane is not None:
        for robot, _ in changed:
            check_plane_kept(robot, cell.plane)
    if any(robot.T_world_base is not generated.T_world_base for robot, generated in changed):
        _check_machines(cell)


def _check_machines(cell: Cell) -> None:
    """Arms of one machine stay where they are on it, and no two copies of one machine stand in one place."""
    arms = zip(cell.robots, cell.generated.manifest.cell.robots, strict=True)
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
