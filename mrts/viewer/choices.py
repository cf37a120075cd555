# SPDX-License-Identifier: MIT
"""What was given to a workbench, what its user changed since, and files of both: what was edited and nothing else."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import yaml

from mrts.base.arrays import Array
from mrts.base.atomic_file import text_writer, write_together
from mrts.base.errors import InputError
from mrts.base.formats.pose import Pose
from mrts.base.input_file import read_text
from mrts.base.rigid_transform import (
    RigidTransform,
    rotations_from_vectors,
    vectors_from_rotations,
)
from mrts.base.yaml_text import Key, edited_yaml, parse_yaml, yaml_text
from mrts.cell.cell import Cell, uncompiled_cell
from mrts.cell.cell_change import CellChange, Changed, machine_of, with_machine_at
from mrts.cell.cell_keys import cell_keys, pose_keys
from mrts.cell.generation import cell_model, described_model
from mrts.motion.joint_table import JointTable
from mrts.motion.motion_file import MotionDescription, sample_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.viewer.player_state import Profile

TORQUE_RATE = 11.0
"""Of the smooth profile, where the cell gives none: a multiple of the torque limit per second [1/s]; a Panda's."""

DECIMALS = 6
"""Of a position that was moved [m]: what is less is rounding."""

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


@dataclass(frozen=True, eq=False)
class Given:
    """What a workbench starts from.

    Attributes:
        cell: The cell.
        motion: Its motion.
        description: Of a motion from pose to pose or through waypoints, whose ends can be moved; None of a table.
        cell_path: File that the cell is from; None where there is none that can be written anew.
        motion_path: File that the motion is from; likewise.
        asked: Options of `mrts.scale`.
        stands: Whether no motion was given: the cell is looked at, with `still_motion`.
    """

    cell: Cell
    motion: ObjectMotion | JointTable
    description: MotionDescription | None = None
    cell_path: Path | None = None
    motion_path: Path | None = None
    asked: Mapping[str, Any] = field(default_factory=dict)
    stands: bool = False


@dataclass(frozen=True)
class Place:
    """What can be moved: a base in the world, a grasp in the object's frame, or an end of the motion, no robot."""

    kind: Literal["base", "grasp", "start", "end"]
    robot: str = ""

    def __str__(self) -> str:
        return f"{self.robot} {self.kind}" if self.robot else f"{self.kind} of the motion"

    def given(self, given: Given) -> RigidTransform:
        """Its pose as it was given."""
        if not self.robot:
            described = given.description
            assert described is not None  # noqa: S101 (else it is no place)
            poses: Sequence[Pose | None] = described.waypoints or [described.start, described.end]
            pose = poses[0 if self.kind == "start" else -1]
            assert pose is not None  # noqa: S101 (a description has either)
            return pose.transform
        robot = next(robot for robot in given.cell.robots if robot.name == self.robot)
        return robot.T_world_base if self.kind == "base" else robot.T_object_tip


def places(given: Given) -> list[Place]:
    """All that can be moved: of a machine with several arms the base of the first, of a table's motion no end."""
    cell = given.cell
    bases = [Place("base", robot.name) for robot in cell.robots if machine_of(cell, robot.name)[0] == robot.name]
    grasps = [Place("grasp", robot.name) for robot in cell.robots]
    return [*bases, *grasps, *([Place("start"), Place("end")] if given.description is not None else [])]


@dataclass(frozen=True, eq=False, kw_only=True)
class Choices:
    """What differs from what was given; as they are, nothing does.

    Attributes:
        mass: Of the object [kg]; None is the given one.
        limits: Share of a given limit by its name, both sides alike.
        poses: Of places that were moved.
        torque_rate: Of the smooth profile, for joints whose rate is not known [1/s].
        simulated: Whether a controller plays the motion too, as `mrts.simulate` does.
    """

    mass: float | None = None
    limits: Mapping[Changed, float] = field(default_factory=dict)
    poses: Mapping[Place, RigidTransform] = field(default_factory=dict)
    profile: Profile = "constant"
    torque_rate: float = TORQUE_RATE
    simulated: bool = False

    def cell(self, cell: Cell) -> Cell:
        """A given cell as it was chosen.

        Raises:
            InputError: If a number breaks a rule of the cell.
        """
        for (kind, robot, element), share in self.limits.items():
            cell = CellChange(kind=kind, robot=robot, element=element, step=share - 1).applied(cell)
        values: dict[str, object] = {} if self.mass is None else {"object.mass": self.mass}
        for place, pose in self.poses.items():
            if place.kind == "base":
                cell = with_machine_at(cell, place.robot, pose)
            elif place.kind == "grasp":
                values[f"robots.{place.robot}.grasp"] = pose
        return cell.with_values(values)

    def motion(self, given: Given) -> ObjectMotion | JointTable:
        """The motion as it was chosen.

        Raises:
            InputError: If two waypoints became the same.
        """
        described = self.description(given)
        return given.motion if described is given.description or described is None else sample_motion(described)

    def description(self, given: Given) -> MotionDescription | None:
        """The description of the motion as it was chosen; None of a table."""
        described = given.description
        moved: dict[str, Any] = {
            place.kind: Pose(**pose_keys(pose)) for place, pose in self.poses.items() if not place.robot
        }
        if described is None or not moved:
            return described
        keys = {key: value for key, value in described if value is not None}
        if described.waypoints:
            start, *between, end = described.waypoints
            moved = {"waypoints": [moved.get("start", start), *between, moved.get("end", end)]}
        return MotionDescription(**keys | moved)

    def with_limit(self, name: Changed, share: float) -> "Choices":
        """With another share of a limit."""
        others = {key: value for key, value in self.limits.items() if key != name}
        return replace(self, limits=others if share == 1 else others | {name: share})

    def with_pose(self, place: Place, pose: RigidTransform) -> "Choices":
        """With a place elsewhere, of a base with all of its machine; positions are rounded."""
        return replace(self, poses={**self.poses, place: RigidTransform(pose.R, np.round(pose.p, DECIMALS))})

    def edited(self) -> list[str]:
        """What was changed, in words."""
        words = [] if self.mass is None else [f"mass {self.mass:.4g} kg"]
        words += [f"{robot}/{element} × {share:.4g}" for (_, robot, element), share in self.limits.items()]
        return [*words, *map(str, self.poses)]


def free_axes(cell: Cell) -> tuple[str, str]:
    """Axes along which, and about which poses of a cell may move: two and one in a plane."""
    if cell.plane is None:
        return "xyz", "xyz"
    return cell.plane, "".join(sorted({*"xyz"} - {*cell.plane}))


def offset_of(pose: RigidTransform, given: RigidTransform) -> tuple[Array, Array]:
    """How far a pose is from the given one: the shift [m] and the turn as a vector [rad], each Shape (3,)."""
    return pose.p - given.p, vectors_from_rotations((pose.R @ given.R.T)[None])[0]


def moved_by(given: RigidTransform, shift: Array, turn: Array) -> RigidTransform:
    """The opposite of `offset_of`."""
    return RigidTransform(rotations_from_vectors(turn[None])[0] @ given.R, given.p + shift)


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
