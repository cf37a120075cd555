# SPDX-License-Identifier: MIT
"""A study: a cell and a motion of which numbers vary, what is asked of each variant, and the file that says so."""

import hashlib
import json
import math
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np

from mrts.base.arrays import Array
from mrts.base.atomic_file import text_writer, write_atomically, write_together
from mrts.base.errors import InputError, as_array, as_path, check_callable, check_type, printable
from mrts.base.formats.record import Finite, Pose, Record, Rule
from mrts.base.input_file import MAX_FILE_BYTES, is_uri, named_in, read_data, read_text
from mrts.base.regular_file import is_folder, read_regular
from mrts.base.rigid_transform import rpy_from_rotation
from mrts.base.version import __version__
from mrts.base.yaml_text import MAX_YAML_BYTES, parse_yaml, yaml_text
from mrts.cell.cell import Cell, load_cell
from mrts.cell.cell_keys import ONE_FOR_ALL, Keys, cell_keys, named_files, set_value, value_at
from mrts.following.clearance import CollisionModel
from mrts.kernel.cache_folder import cache_folder
from mrts.motion.joint_table import NO_SPEED, JointTable
from mrts.motion.motion_file import DEFAULT_SAMPLES, KINDS, MotionDescription, load_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.ros_messages import is_bag
from mrts.scaling.options import Options, limited_cell
from mrts.scaling.range import mass_grid
from mrts.studies.parameters import MAX_VARIANTS, Parameter, SampleName, read_parameters, sample_points


class StudyQuestion(Record):
    """What is asked of each variant.

    Attributes:
        profile: "constant" asks for the range of c², "optimal" for the fastest timing too.
        load: The question of an uncertain load, as in `mrts.scale`.
        reserve: Share of every limit that is kept free; None is the cell's own.
        between: Share of a limit by which it may be overstepped between the samples; None looks at the samples alone.
        clearance: Whether the least distance between bodies is wanted (`mrts.clearance`).
    """

    profile: Literal["constant", "optimal"] = "constant"
    load: Annotated[str, Rule(pattern=r"^(auto|nominal|guaranteed|possible|grid(:[0-9]{1,9})?)$")] = "auto"
    reserve: Annotated[float, Rule(ge=0, lt=1)] | None = None
    between: Finite | None = None
    clearance: bool = False


@dataclass(frozen=True)
class StudyFile:
    """A URDF or a mesh that a cell file names by a reference at some keys, so that a study can be solved elsewhere."""

    keys: Keys
    reference: str
    path: str
    content: bytes


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Study:
    """Many variants of one cell and one motion. It pickles with all that a worker needs; equal studies ask the same.

    Attributes:
        path: The study file.
        folder: That the cell's URDFs are relative to.
        parameters: What varies, P of them.
        sample: "grid" or "sobol".
        variants: Number of variants.
        seed: Of what is drawn.
        question: What is asked of each variant.
        cell: Keys and values of the cell file, with those that are varied.
        motion: Keys and values of the motion file, likewise; a table's are where it is.
        table: The motion, where it is a table: no number of it varies.
        files: URDFs and mesh that the cell file names.
        digest: Hash of all that the answers depend on.
        limits: Further limits of the cell, as `mrts.Cell.with_limits` takes them.
    """

    path: Path
    folder: Path
    parameters: tuple[Parameter, ...]
    sample: SampleName
    variants: int
    seed: int
    question: StudyQuestion
    cell: dict[str, Any]
    motion: dict[str, Any]
    table: ObjectMotion | JointTable | None
    files: tuple[StudyFile, ...]
    digest: str
    limits: tuple[Callable[..., Any], ...] = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Study) and (other.digest, other.limits) == (self.digest, self.limits)

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        varied = ", ".join(parameter.path for parameter in self.parameters)
        return f"<Study of cell '{self.cell['name']}': {self.variants} variants ({self.sample}) of {varied}>"

    def with_limits(self, *limits: Callable[..., Any]) -> Self:
        """The same study of a cell with further limits; workers must be able to import them.

        Args:
            *limits: As `mrts.Cell.with_limits` takes them.

        Raises:
            InputError: If one is no function.
        """
        for limit in limits:
            check_callable("limits", limit)
        return replace(self, limits=limits)

    def points(self, first: int, last: int) -> Array:
        """Values of the parameters of some variants, the same whatever block they are asked for in.

        Args:
            first: The first variant.
            last: The first that is left out.

        Returns:
            Shape (V, P), in the units of the parameters.

        Raises:
            InputError: If there are no such variants.
        """
        check_type("first", first, int, np.integer)
        check_type("last", last, int, np.integer)
        if not 0 <= first <= last <= self.variants:
            rule = f"must be a block of the variants 0 to {self.variants}, the first one and the first left out."
            raise InputError("first, last", rule, value=(first, last))
        distributions = [parameter.distribution for parameter in self.parameters]
        return sample_points(distributions, self.sample, self.seed, (int(first), int(last)))

    def descriptions(self, point: Array) -> tuple[dict[str, Any], dict[str, Any]]:
        """Keys and values of the cell file and the motion file of a variant whose parameters are a point, Shape (P,).

        Raises:
            InputError: If these are something else.
        """
        values = as_array("point", point)
        if values.shape != (len(self.parameters),) or not np.all(np.isfinite(values)):
            rule = f"must be a finite number for each of {', '.join(each.path for each in self.parameters)}."
            raise InputError("point", rule, value=point)
        files = {"cell": deepcopy(self.cell), "motion": deepcopy(self.motion)}
        for parameter, value in zip(self.parameters, values.tolist(), strict=True):
            for target in parameter.targets:
                set_value(files, target.keys, target.offset + target.factor * value)
        return files["cell"], files["motion"]

    def cell_of(self, keys: dict[str, Any]) -> Cell:
        """The cell of a variant, by the keys and values of its file, with the reserve that is asked for."""
        return limited_cell(Cell.from_description(keys, folder=self.folder), self.question.reserve, self.limits)

    def motion_of(self, keys: dict[str, Any]) -> ObjectMotion | JointTable:
        """The motion of a variant, likewise."""
        return load_motion(keys) if self.table is None else self.table

    def at_hand(self) -> Self:
        """The same study with URDFs that are where it says, with the content that it was read with.

        It is itself where they still are; elsewhere, or where one has changed, they are written into the user's cache.
        """
        if all(_holds(Path(file.path), file.content) for file in self.files):
            return self
        folder, cell = cache_folder("studies", self.digest), deepcopy(self.cell)
        for number, file in enumerate(self.files):
            path = folder / f"{number}{Path(file.path).suffix}"
            if not _holds(path, file.content):
                write_atomically(path, partial(Path.write_bytes, data=file.content), private=True)
            set_value(cell, file.keys, path.name)
        return replace(self, folder=folder, cell=cell)

    def write_variant(self, index: int, folder: Path | str) -> tuple[Path, Path]:
        """Write one variant as files that `mrts scale` reads: cell.yaml and motion.yaml.

        Args:
            index: The variant, from 0.
            folder: For the files; made if it is missing. Comments of the study's own files are not in them.

        Returns:
            The cell file and the motion file.

        Raises:
            InputError: If there is no such variant or the folder cannot be written.
        """
        check_type("index", index, int, np.integer)
        if not 0 <= index < self.variants:
            raise InputError("index", f"must be a variant, from 0 to {self.variants - 1}.", value=index)
        folder = as_path("folder", folder)
        index = int(index)
        cell, motion = self.descriptions(self.points(index, index + 1)[0])
        for key in ("file", "joints"):
            if key in motion:
                motion[key] = named_in(folder, Path(motion[key]))
        cell_file, motion_file = folder / "cell.yaml", folder / "motion.yaml"
        heading = f"# Variant {index} of {printable(self.path.name)}\n"
        texts = heading + self.cell_text(cell, folder), heading + yaml_text(motion)
        write_together({cell_file: text_writer(texts[0]), motion_file: text_writer(texts[1])})
        return cell_file, motion_file

    def cell_text(self, keys: dict[str, Any], folder: Path) -> str:
        """The text of a cell file with some keys, in a folder that paths of its files are relative to."""
        written = deepcopy(keys)
        for file in self.files:
            named = file.reference if is_uri(file.reference) else named_in(folder, Path(file.path))
            set_value(written, file.keys, named)
        return yaml_text(written)


def _holds(path: Path, content: bytes) -> bool:
    try:
        return read_regular(path, "input file", MAX_FILE_BYTES) == content
    except InputError:
        return False


class StudyDescription(StudyQuestion):
    """A validated study file; docs/study_file.md has its keys."""

    cell: Annotated[str, Rule(min_length=1)]
    motion: Annotated[str, Rule(min_length=1)]
    vary: dict[str, Any]
    sample: SampleName = "grid"
    count: Annotated[int, Rule(ge=1, le=MAX_VARIANTS)] | None = None
    seed: Annotated[int, Rule(ge=0, le=2**32 - 1)] | None = None

    def problem(self) -> str:
        """The rule that its keys break with each other; empty if none."""
        if self.sample == "sobol":
            return "" if self.count else "sample: sobol takes a count: how many variants are drawn, such as 1024"
        drawn = " and ".join(key for key in ("count", "seed") if getattr(self, key) is not None)
        rule = f"a grid takes every combination, so nothing is drawn: leave {drawn} out, or take sample: sobol"
        return rule if drawn else ""


def read_study(path: Path | str) -> Study:
    """Read a study: the study file, and the cell file, the URDFs and the motion that it names.

    Args:
        path: The study file.

    Raises:
        InputError: If one of them breaks a rule, or the study varies what is not there.
        CompilerError: If the compiler fails.
    """
    path = as_path("path", path)
    described = _described(path)
    cell_path, motion_path = (path.parent / name for name in (described.cell, described.motion))
    if is_folder(cell_path):
        raise InputError(path, "must be a cell file: a study varies its numbers.", key="cell", value=described.cell)
    cell = load_cell(cell_path)
    motion = load_motion(motion_path)
    if isinstance(motion, JointTable) and motion.untimed:
        raise InputError(motion_path, NO_SPEED)
    _check_question(path, described, cell)
    given = {"cell": _given_keys(cell_path, "cell file"), "motion": _given_motion(motion_path, motion)}
    _angles_for_quaternions(given["cell"]["robots"], given["motion"])
    poses, full = not (set(KINDS) - {"start", "waypoints"}) & set(given["motion"]), cell_keys(cell)
    for motors in (robot["motors"] for robot in full["robots"]):  # one number stands for all joints
        motors |= {key: motors[key][0] for key in ONE_FOR_ALL & motors.keys() if len({*motors[key]}) == 1}
    filled = {
        "cell": _overlaid(full, given["cell"]),
        "motion": _filled_motion(given["motion"]) if poses else {},
    }
    parameters = read_parameters(path, described.vary, described.sample, given, filled, cell)
    files = tuple(_study_files(cell_path, given["cell"]))
    question = StudyQuestion(**{name: getattr(described, name) for name in StudyQuestion.model_fields})
    variants = described.count or math.prod(len(parameter.distribution.numbers) for parameter in parameters)
    if variants > MAX_VARIANTS:
        rule = f"this grid has {variants} variants, at most {MAX_VARIANTS} are allowed. Take fewer steps, or a sample: "
        raise InputError(path, rule + "sobol with a count.", key="vary")
    seed = described.seed or 0
    where = {"file", "joints"}  # what such a table says is hashed
    own = {key: value for key, value in given["motion"].items() if key not in where}
    asked = repr((parameters, described.sample, variants, seed, question))
    content = [json.dumps([__version__, asked, given["cell"], own]).encode(), *(file.content for file in files)]
    content += [] if poses else _table_content(motion)
    return Study(
        path=path.absolute(),
        folder=cell_path.resolve().parent,
        parameters=parameters,
        sample=described.sample,
        variants=variants,
        seed=seed,
        question=question,
        cell=given["cell"],
        motion=given["motion"],
        table=None if poses else motion,
        files=files,
        digest=hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in content)).hexdigest(),
    )


def _study_files(path: Path, given: dict[str, Any]) -> Iterator[StudyFile]:
    for keys, reference in named_files(given).items():
        folder = path.resolve().parent
        file = str(reference.path(path, folder).absolute())
        yield StudyFile(keys, value_at(given, keys), file, reference.content(path, folder))


def _described(path: Path) -> StudyDescription:
    try:
        data = read_data(path, "study file")
        return StudyDescription.read(path, data, "study file")
    except InputError as error:
        if not error.rule.endswith("but got '['."):
            raise
        rule = error.rule + ' In braces, YAML wants a path with an index in quotes: {"robots.left.base.xyz[0]": 1}.'
        raise InputError(path, rule) from None


def _given_motion(path: Path, motion: ObjectMotion | JointTable) -> dict[str, Any]:
    if is_bag(path) or path.suffix.lower() == ".csv":
        return {"joints" if isinstance(motion, JointTable) else "file": str(path.absolute())}
    given = {key: value for key, value in _given_keys(path, "motion file").items() if value is not None}
    tables = {key: str((path.parent / given[key]).absolute()) for key in ("file", "joints") if key in given}
    return given | tables


def _given_keys(path: Path, what: str) -> dict[str, Any]:
    """Keys and values of a YAML file as they stand there; what an alias repeats stands there twice."""
    keys = parse_yaml(read_text(path, what, MAX_YAML_BYTES))
    if not isinstance(keys, dict):
        raise InputError(path, f"this {what} changed while it was read. Read the study again.")
    unshared: dict[str, Any] = json.loads(json.dumps(keys))
    return unshared


def _angles_for_quaternions(robots: list[dict[str, Any]], motion: dict[str, Any]) -> None:
    """Give poses by roll, pitch and yaw, of which each can vary by itself."""
    poses = [holder.get(key) for holder in (*robots, motion) for key in ("base", "grasp", "start", "end")]
    for pose in filter(None, [*poses, *(motion.get("waypoints") or [])]):
        if any(name.startswith("quaternion") for name in pose):
            read = Pose.model_validate(dict(pose))
            pose.clear()
            pose.update(xyz=read.xyz, rpy=rpy_from_rotation(read.rotation()))


def _overlaid(full: Any, given: Any) -> Any:
    """What is given, with all that it leaves out; a word, such as `none`, leaves out what it stands for."""
    if isinstance(full, dict) and isinstance(given, dict):
        return full | {key: _overlaid(full.get(key), value) for key, value in given.items()}
    if isinstance(full, list) and isinstance(given, list) and len(full) == len(given):
        return [_overlaid(each, own) for each, own in zip(full, given, strict=True)]
    leaves_out = given is None or (isinstance(given, str) and isinstance(full, dict))
    return deepcopy(full if leaves_out else given)


def _filled_motion(given: dict[str, Any]) -> dict[str, Any]:
    filled = MotionDescription(**given).model_dump()
    filled["samples"] = filled["samples"] or DEFAULT_SAMPLES
    return {key: value for key, value in filled.items() if value is not None}


def _table_content(table: ObjectMotion | JointTable) -> list[bytes]:
    parts = [part if isinstance(part, dict) else {"": part} for part in vars(table).values()]
    columns = [(name, values) for part in parts for name, values in part.items() if isinstance(values, np.ndarray)]
    return [content for name, values in columns for content in (name.encode(), np.ascontiguousarray(values).tobytes())]


def _check_question(path: Path, described: StudyDescription, cell: Cell) -> None:
    load = described.load
    if described.profile == "optimal" and load not in {"auto", "nominal", "guaranteed"}:
        rule = "must be guaranteed or nominal where the speed varies (profile: optimal)."
        raise InputError(path, rule, key="load", value=load)
    if described.clearance:
        CollisionModel(cell)  # which says what it lacks
    try:
        Options(load=load, between=described.between).checked(cell)
        if cell.load_box is not None and load.startswith("grid"):
            mass_grid(cell.load_box, load)
    except InputError as error:
        raise InputError(path, error.rule.replace("None", "null"), key=error.where, value=error.value) from None
