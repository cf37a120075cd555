# SPDX-License-Identifier: MIT
"""The study file: which numbers of a cell file and a motion file vary, how, and what is asked of each variant."""

import hashlib
import json
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from mrts.base.argument_types import as_path
from mrts.base.errors import InputError
from mrts.base.formats.pose import Pose
from mrts.base.formats.record import Rule
from mrts.base.input_file import read_data, read_text, validated
from mrts.base.regular_file import is_folder
from mrts.base.rigid_transform import rpy_from_rotation
from mrts.base.version import __version__
from mrts.base.yaml_parser import MAX_YAML_BYTES, parse_yaml
from mrts.cell.cell import Cell
from mrts.cell.cell_keys import cell_keys
from mrts.cell.loading import load_cell
from mrts.cell.number_paths import ONE_FOR_ALL, Keys, value_at
from mrts.cell.source_files import described
from mrts.collisions.clearance import CollisionModel
from mrts.motion.joint_table import NO_SPEED, JointTable
from mrts.motion.motion_file import DEFAULT_SAMPLES, KINDS, MotionDescription, load_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.ros_messages import is_bag
from mrts.scaling.loads import mass_grid
from mrts.scaling.options import Options
from mrts.studies.parameters import Parameter, read_parameters
from mrts.studies.sampling import MAX_VARIANTS, SampleName, grid_size
from mrts.studies.study import Study, StudyFile, StudyQuestion


class StudyDescription(StudyQuestion):
    """A validated study file; docs/study_file.md has its keys."""

    cell: Annotated[str, Rule(min_length=1)]
    motion: Annotated[str, Rule(min_length=1)]
    vary: dict[str, Any]
    sample: SampleName = "grid"
    count: Annotated[int, Rule(ge=1, le=MAX_VARIANTS)] | None = None
    seed: Annotated[int, Rule(ge=0, le=2**32 - 1)] | None = None


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
    poses, full = _is_path_of_poses(given["motion"]), cell_keys(cell)
    for motors in (robot["motors"] for robot in full["robots"]):  # one number stands for all joints
        motors |= {key: motors[key][0] for key in ONE_FOR_ALL & motors.keys() if len({*motors[key]}) == 1}
    filled = {
        "cell": _overlaid(full, given["cell"]),
        "motion": _filled_motion(given["motion"]) if poses else {},
    }
    parameters = read_parameters(path, described.vary, described.sample, given, filled, cell)
    files = tuple(_study_files(cell_path, given["cell"]))
    question = StudyQuestion(**{name: getattr(described, name) for name in StudyQuestion.model_fields})
    variants, seed = _variants(path, described, parameters), described.seed or 0
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
    robots, around = given["robots"], given.get("surroundings") or []
    named: list[Keys] = [("robots", at, "urdf") for at in range(len(robots))]
    if (given["object"].get("shape") or {}).get("mesh"):
        named.append(("object", "shape", "mesh"))
    named += [("robots", at, "joint_limits") for at, robot in enumerate(robots) if robot.get("joint_limits")]
    named += [("surroundings", at, "mesh") for at, one in enumerate(around) if one.get("mesh")]
    for keys, reference in zip(named, described(path).references, strict=True):
        file, content = (of(path, path.resolve().parent) for of in (reference.path, reference.content))
        yield StudyFile(keys, value_at(given, keys), str(file.absolute()), content)


def _described(path: Path) -> StudyDescription:
    try:
        data = read_data(path, "study file")
        if isinstance(data, dict) and (data.get("between") is False or data.get("between") == "off"):
            data["between"] = None  # `off`, as on the command line, is False in YAML
        return validated(path, data, StudyDescription, "study file")
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


def _is_path_of_poses(given: dict[str, Any]) -> bool:
    return not (set(KINDS) - {"start", "waypoints"}) & set(given)


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


def _variants(path: Path, described: StudyDescription, parameters: tuple[Parameter, ...]) -> int:
    if described.sample == "grid":
        for key, value in (("count", described.count), ("seed", described.seed)):
            if value is not None:
                rule = "a grid takes every combination, so nothing is drawn. Leave this out, or take sample: sobol."
                raise InputError(path, rule, key=key, value=value)
        size = grid_size([parameter.distribution for parameter in parameters])
        if size > MAX_VARIANTS:
            rule = f"this grid has {size} variants, at most {MAX_VARIANTS} are allowed. Take fewer steps, or a sample: "
            raise InputError(path, rule + "sobol with a count.", key="vary")
        return size
    if described.count is None:
        rule = "this key is required with sample: sobol: how many variants are drawn, such as 1024."
        raise InputError(path, rule, key="count")
    return described.count
