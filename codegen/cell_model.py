# SPDX-License-Identifier: MIT
"""The cell with its URDFs read: everything that the symbolic layer and the manifest need."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from mrts_codegen.joint_limits import add_joint_limits
from mrts_codegen.object_shape import build_object, check_contact_normals, mesh_surfaces
from mrts_codegen.urdf.held_joints import check_machines, held_positions
from mrts_codegen.urdf.robot_model import BuiltRobot, Joint, RobotModel, build_robot_model, frame_in_root
from mrts_codegen.urdf.urdf_file import parse_urdf

from mrts.base.errors import InputError, Mistakes, Remark, did_you_mean
from mrts.base.formats.urdf import NO_LIMIT, Urdf
from mrts.base.input_file import FileReference, read_data
from mrts.base.load_box import LoadBox, load_vector
from mrts.base.manifest import PLANE_COMPONENTS, ChainsRecord
from mrts.cell.cell_file import (
    OF_ARM,
    OF_FRICTION,
    CellDescription,
    RobotDescription,
    robot_values,
)
from mrts.cell.points import RATES, ArmPointLimit, point_names, rate_limits
from mrts.cell.record import CellManifest, CellRecord, MeshSurface
from mrts.cell.robot import Robot, RobotSource, check_plane_kept


@dataclass(frozen=True)
class CellModel:
    """A cell with its chains.

    Attributes:
        record: What the cell file comes to.
        models: The chain of each arm.
    """

    record: CellRecord
    models: tuple[RobotModel, ...]

    def chains_key(self, stem: str) -> str:
        """Hash of what functions are generated of: the chains, not the numbers of a cell file."""
        parts: list[object] = [stem, self.record.plane]
        for model in self.models:
            parts += [(joint.kind, joint.axis.tolist(), joint.body.mass) for joint in model.joints]
            parts += [None if by_held else numbers.tolist() for numbers, by_held in model.numbers()]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()

    def arms_alone(self) -> "tuple[CellModel, ...]":
        """A cell of each arm by itself."""
        return tuple(
            replace(self, record=replace(self.record, robots=(robot,), machines=()), models=(model,))
            for robot, model in zip(self.record.robots, self.models, strict=True)
        )


def read_cell_model(path: Path) -> CellModel:
    """A cell file with its URDFs."""
    return build_cell_model(path, CellDescription.read_file(path, "cell file"))


def read_cell(path: Path) -> tuple[CellModel | None, tuple[InputError, ...]]:
    """A cell file with its URDFs, None if something is wrong, and all that is."""
    mistakes = Mistakes()
    with mistakes.noted():
        data = read_data(path, "cell file")
        try:
            description = CellDescription.read(path, data, "cell file")
        except InputError as error:
            mistakes.add(error)
            _read_robots(path, data, mistakes)
        else:
            return build_cell_model(path, description), ()
    return None, tuple(mistakes.found)


def _read_robots(path: Path, data: Any, mistakes: Mistakes) -> None:
    """Check every robot by itself in a file that does not describe a cell."""
    if not isinstance(data, dict) or not isinstance(data.get("robots"), list):
        return
    plane, lenient = data.get("plane"), data.get("inertia") == "lenient"
    for index, entry in enumerate(data["robots"] if plane in [*PLANE_COMPONENTS] else []):
        if not isinstance(entry, dict):
            continue
        try:
            robot = RobotDescription.read(path, entry)
        except InputError:  # it has been noted with its place in the file
            continue
        with mistakes.noted():
            build_robot(path, index, robot, plane, path.resolve().parent, lenient=lenient)


def build_cell_model(path: Path, description: CellDescription, folder: Path | None = None) -> CellModel:
    """Read the URDFs of a cell and check every array of the cell file against them.

    Files are relative to `folder`, absolute; None is where the cell file stands.
    """
    folder = path.resolve().parent if folder is None else folder
    carried, mistakes = description.object, Mistakes()
    built = list[BuiltRobot]()
    for index, robot in enumerate(description.robots):
        with mistakes.noted():
            lenient = description.inertia == "lenient"
            built.append(build_robot(path, index, robot, description.plane, folder, lenient=lenient))
    with mistakes.noted():
        surfaces, inertia, of_object = build_object(path, folder, carried)
    around = dict[str, MeshSurface]()
    with mistakes.noted():
        taken = ["object", *(robot.name for robot in description.robots)]
        surroundings = _named(path, "surroundings", description.surroundings, "obstacle", taken)
        for at, shape in enumerate(surroundings):
            around |= mesh_surfaces(path, folder, shape, f"surroundings[{at}]")[0]
    mistakes.raise_noted()
    remarks = [*of_object, *check_contact_normals(path, description.robots, carried.shape, surfaces)]
    remarks += [remark for arm in built for remark in (*arm.model.remarks, *arm.remarks)]
    record = CellRecord(
        name=description.name,
        plane=description.plane,
        gravity=np.array(description.gravity, dtype=float),
        load=load_vector(carried.mass, np.zeros(3), inertia),
        load_box=None if carried.variation is None else LoadBox(carried.mass, inertia, carried.variation),
        power_limit=description.power,
        object_velocity_limit=rate_limits(carried.velocity),
        object_acceleration_limit=rate_limits(carried.acceleration),
        object_points=_named(path, "object.frames", carried.frames, "point", [*RATES]),
        carried=_named(path, "object.carries", carried.carries, "thing", [*RATES]),
        object_shape=carried.shape,
        surroundings=surroundings,
        surfaces=surfaces | around,
        robots=tuple(arm.robot for arm in built),
        machines=check_machines(path, built),
        remarks=tuple(dict.fromkeys(remarks)),
    )
    models = tuple(arm.model for arm in built)
    return CellModel(record, models)


def cell_manifest(cell: CellModel, chains: ChainsRecord) -> CellManifest:
    """The manifest of a cell."""
    return CellManifest(**dict(chains), cell=cell.record)


def build_robot(
    path: Path, index: int, robot: RobotDescription, plane: str | None, folder: Path, *, lenient: bool
) -> BuiltRobot:
    """Read the URDF of a robot and check all that the cell file says of it against it."""
    key = f"robots[{index}] ({robot.name})"
    reference = FileReference(robot.urdf, f"{key}.urdf")
    urdf_path, content = reference.path(path, folder), reference.content(path, folder)
    urdf = parse_urdf(urdf_path, content)
    components = PLANE_COMPONENTS[plane]
    for name in ("base_link", "tip_link"):
        if (link := getattr(robot, name)) is not None and link not in urdf.links:
            known = f"{did_you_mean(link, urdf.links)} Its links are: {', '.join(urdf.links)}."
            raise InputError(path, f"there is no such link in {urdf_path.name}{known}", key=f"{key}.{name}", value=link)
    held = held_positions(path, f"{key}.fixed", urdf_path, urdf, robot.fixed)
    model = build_robot_model(urdf_path, urdf, robot.base_link, robot.tip_link, held, lenient=lenient)
    sha256 = hashlib.sha256(content).hexdigest()
    values = model.attributes(len(components), urdf=robot.urdf, sha256=sha256, fixed=robot.fixed, held=held)
    mistakes = Mistakes()
    remarks = [*robot.base.degrees_remarks(f"{key}.base"), *robot.grasp.degrees_remarks(f"{key}.grasp")]
    with mistakes.noted():
        if robot.torque is None:
            _check_efforts(urdf_path, robot.name, path, model.joints)
    if robot.joint_limits is not None:
        with mistakes.noted():
            remarks += add_joint_limits(values, path, f"{key}.joint_limits", robot.name, robot.joint_limits, folder)
    for name in OF_ARM:
        if (given := getattr(robot, name)) is not None:
            with mistakes.noted():
                values |= robot_values(path, f"{key}.{name}", given, values, components)
    with mistakes.noted():
        values["point_limits"] = _point_limits(path, f"{key}.frames", robot, model, urdf, held)
    mistakes.raise_noted()
    source: RobotSource = values["source"]
    source = values["source"] = replace(
        source,
        effort=source.effort if robot.torque is None else None,
        velocity=source.velocity if robot.velocity is None else None,
        friction=source.friction if robot.motors.friction is None else None,
    )
    if source.friction is not None and any(map(any, source.friction)):
        remarks.append(_friction_of_urdf(robot.name, source.friction))
    try:
        built = Robot(name=robot.name, **values)
        if plane is not None:
            check_plane_kept(built, plane)
    except InputError as error:
        raise error.inside(path, key) from None
    return BuiltRobot(built, model, urdf, tuple(remarks))


def _check_efforts(urdf_path: Path, name: str, path: Path, joints: tuple[Joint, ...]) -> None:
    mistakes, names = Mistakes(), ", ".join(joint.name for joint in joints)
    for joint in joints:
        if not 0 < joint.effort < NO_LIMIT:
            rule = (
                f"its effort limit is {joint.effort or 'missing or 0'}, which says nothing about the motor. Give "
                f"'torque: [{names}]' in N m for robot '{name}' in {path.name}."
            )
            mistakes.add(InputError(urdf_path, rule, key=f"joint '{joint.name}'"))
    mistakes.raise_noted()


def _friction_of_urdf(robot: str, friction: tuple[tuple[float, ...], tuple[float, ...]]) -> Remark:
    named = [(name, values) for name, values in zip(OF_FRICTION, friction, strict=True) if any(values)]
    shown = "; ".join(f"{name} {', '.join(f'{value:g}' for value in values)}" for name, values in named)
    return Remark(
        "urdf-friction",
        f"robot '{robot}': friction is that of the URDF's <dynamics> ({shown}), which is often a placeholder. Give "
        "'motors: {friction: …}' in the cell file, or 'motors: {friction: none}' to ignore it.",
    )


def _point_limits(
    path: Path, key: str, robot: RobotDescription, model: RobotModel, urdf: Urdf, held: Mapping[str, float]
) -> tuple[ArmPointLimit, ...]:
    placed = []
    for index, (given, name) in enumerate(zip(robot.frames, point_names(robot.frames), strict=True)):
        if given.link not in urdf.links:
            rule = (
                f"there is no such link{did_you_mean(given.link, urdf.links)} Its links are: {', '.join(urdf.links)}."
            )
            raise InputError(path, rule, key=f"{key}[{index}].link", value=given.link)
        joints = len({joint.name for joint in model.joints} & {joint.name for joint in urdf.joints_to(given.link)})
        if not joints:
            rule = f"no joint of robot '{robot.name}' moves this link, so nothing limits it."
            raise InputError(path, rule, key=f"{key}[{index}].link", value=given.link)
        T = model.T_base_root @ frame_in_root(urdf, given.link, held)  # every joint at zero
        at_zero = (T.p + T.R @ np.array(given.point)).tolist()
        placed.append(ArmPointLimit(**dict(given) | {"name": name, "joints": joints, "at_zero": at_zero}))
    _check_names(path, key, [one.name for one in placed], [joint.name for joint in model.joints])
    return tuple(placed)


def _check_names(path: Path, key: str, names: Sequence[str], taken: Sequence[str]) -> None:
    for index, name in enumerate(names):
        if name in (*taken, *names[:index]):
            rule = f"must have a name of its own, other than those of {', '.join(taken)}."
            raise InputError(path, rule, key=f"{key}[{index}].name", value=name)


def _named(path: Path, key: str, given: list[Any], default: str, taken: Sequence[str]) -> tuple[Any, ...]:
    names = point_names(given, default)
    _check_names(path, key, names, taken)
    return tuple(one.model_copy(update={"name": name}) for one, name in zip(given, names, strict=True))
