# SPDX-License-Identifier: MIT
"""The cell with its URDFs read: everything that the symbolic layer and the manifest need."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mrts_codegen.cell_file import (
    CellDescription,
    ObjectDescription,
    RobotDescription,
    TorqueBounds,
    inertia_problem,
)
from mrts_codegen.contact_normals import check_contact_normals
from mrts_codegen.hand_file import build_contacts
from mrts_codegen.motors_block import build_motors
from mrts_codegen.object_shape import build_shape
from mrts_codegen.urdf.held_joints import held_positions
from mrts_codegen.urdf.planar_cell import PLANE_COMPONENTS, check_plane_kept
from mrts_codegen.urdf.robot_model import Joint, RobotModel, build_robot_model
from mrts_codegen.urdf.shared_joints import check_machines, root_in_base
from mrts_codegen.urdf.urdf_elements import Urdf
from mrts_codegen.urdf.urdf_file import parse_urdf
from mrts_codegen.urdf.urdf_joint import NO_LIMIT

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Mistakes
from mrts.base.manifest import WRENCH_COMPONENTS, WRENCH_UNITS, ShapeRecord
from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.hands.contact import Contact
from mrts.cell.hands.wrench_limits import given_wrench_limits
from mrts.cell.motors.joint_motors import JointMotors
from mrts.cell.motors.torque_limits import given_torque_limits


@dataclass(frozen=True, kw_only=True)
class CellRobot:
    """One arm in its place.

    Attributes:
        name: Name in the cell file.
        model: The chain.
        urdf: As the cell file gives it.
        xacro_args: Where it is a xacro, values of its arguments.
        urdf_sha256: Hash of the URDF's bytes, of a xacro those that it becomes.
        held: Joints that are held still, and what moves with them, with their positions [rad or m].
        T_world_base: Base link in the world.
        T_base_root: Root of the URDF in the base link, joints in between held or at zero.
        T_object_tip: Tip link in the object frame (its grasp).
        posture: Joint positions near which the motion starts, Shape (n,) [rad or m].
        torque_lower: Shape (n,) [N m or N].
        torque_upper: Shape (n,) [N m or N].
        wrench_lower: Base axes, minus infinity where unbounded, Shape (w,) [N, N m].
        wrench_upper: Base axes, infinity where unbounded, Shape (w,) [N, N m].
        motors: What stands between motors and joints.
        remarks: What to know of where values are from.
        contacts: What its hand can exert on the object.
        contact_rate: Base axes, infinity where unbounded, Shape (w,) [N/s, N m/s].
    """

    name: str
    model: RobotModel
    urdf: str
    xacro_args: Mapping[str, str]
    urdf_sha256: str
    held: Mapping[str, float]
    T_world_base: RigidTransform
    T_base_root: RigidTransform
    T_object_tip: RigidTransform
    posture: Array
    torque_lower: Array
    torque_upper: Array
    wrench_lower: Array
    wrench_upper: Array
    motors: JointMotors
    remarks: tuple[Remark, ...]
    contacts: tuple[Contact, ...]
    contact_rate: Array


@dataclass(frozen=True)
class CellModel:
    """The whole cell.

    Attributes:
        description: The validated cell file.
        components: Rows of a six-component wrench that this cell uses.
        wrench_components: Their names.
        robots: The arms in the order of the cell file.
        machines: Names of each two that are arms of one machine.
        inertia: Of the object at the com in its frame, Shape (3, 3) [kg m²].
        shape: What the object looks like, None where that is not known.
        object_remarks: What to know of the object.
    """

    description: CellDescription
    components: tuple[int, ...]
    wrench_components: tuple[str, ...]
    robots: tuple[CellRobot, ...]
    machines: tuple[tuple[str, str], ...]
    inertia: Array
    shape: ShapeRecord | None
    object_remarks: tuple[Remark, ...]

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """What to know of the object and the URDFs, each thing once."""
        said = (remark for robot in self.robots for remark in (*robot.model.remarks, *robot.remarks))
        return tuple(dict.fromkeys((*self.object_remarks, *said)))


def build_cell_model(path: Path, description: CellDescription, folder: Path | None = None) -> CellModel:
    """Read the URDFs of a cell and check every array of the cell file against them.

    Args:
        path: The cell file, for messages.
        description: Its content.
        folder: That URDFs are relative to, absolute; None is where the cell file stands.

    Raises:
        InputError: If a URDF or an array of the cell file breaks a rule.
    """
    components = PLANE_COMPONENTS[description.plane]
    names = tuple(WRENCH_COMPONENTS[component] for component in components)
    folder = path.resolve().parent if folder is None else folder
    lenient = description.inertia == "lenient"
    mistakes = Mistakes()
    robots, urdfs = [], []
    for index, robot in enumerate(description.robots):
        with mistakes.noted():
            key = f"robots[{index}] ({robot.name})"
            built, urdf = build_robot(path, key, robot, description.plane, folder, lenient=lenient)
            robots.append(built)
            urdfs.append(urdf)
    with mistakes.noted():
        carried = _build_object(path, folder, description.object)
    mistakes.raise_noted()
    inertia, shape, remarks = carried
    remarks = (*remarks, *check_contact_normals(path, description.robots, shape))
    return CellModel(
        description=description,
        components=components,
        wrench_components=names,
        robots=tuple(robots),
        machines=check_machines(path, robots, urdfs),
        inertia=inertia,
        shape=shape,
        object_remarks=remarks,
    )


def _build_object(
    path: Path, folder: Path, carried: ObjectDescription
) -> tuple[Array, ShapeRecord | None, tuple[Remark, ...]]:
    """Inertia, shape and what to know of the object."""
    given = carried.inertia_matrix()
    if carried.shape is None:
        assert given is not None  # noqa: S101 (an object has one or the other)
        return given, None, ()
    shape, inertia, remarks = build_shape(path, folder, carried.shape, carried.mass, given)
    problem = inertia_problem(inertia)
    if problem:
        raise InputError(path, f"the inertia of a uniform body of this shape {problem}", key="object.shape")
    return inertia, shape, remarks


def build_robot(
    path: Path, key: str, robot: RobotDescription, plane: str | None, folder: Path, *, lenient: bool
) -> tuple[CellRobot, Urdf]:
    """Read the URDF of a robot and check all that the cell file says of it against it.

    Args:
        path: The cell file, for messages.
        key: Of the robot in it, likewise.
        robot: What it says.
        plane: Of the cell.
        folder: That URDFs are relative to, absolute.
        lenient: As in `mrts_codegen.urdf.link_inertia.link_inertia`.

    Returns:
        The robot, and its URDF.

    Raises:
        InputError: If the URDF or an array of the robot breaks a rule; carries all that do.
    """
    reference = robot.reference(f"{key}.urdf")
    urdf_path, content = reference.path(path, folder), reference.content(path, folder)
    urdf = parse_urdf(urdf_path, content)
    components = tuple(WRENCH_COMPONENTS[component] for component in PLANE_COMPONENTS[plane])
    held = held_positions(path, f"{key}.fixed", urdf_path, urdf, robot.fixed)
    model = build_robot_model(urdf_path, urdf, robot.base_link, robot.tip_link, held, lenient=lenient)
    joints = [joint.name for joint in model.joints]
    T_world_base = robot.base.transform
    T_object_tip = robot.grasp.transform
    bounds = robot.wrench
    mistakes = Mistakes()
    with mistakes.noted():
        if len(robot.posture) != len(joints):
            rule = f"must have {len(joints)} values, one for each of {', '.join(joints)}."
            raise InputError(path, rule, key=f"{key}.posture", value=robot.posture)
    with mistakes.noted():
        torque_lower, torque_upper = _torque_limits(path, urdf_path, key, robot, model)
        motors, of_motors = build_motors(path, f"{key}.motors", robot, model, (torque_lower, torque_upper))
    with mistakes.noted():
        wrench_lower, wrench_upper = given_wrench_limits(
            path, f"{key}.wrench", bounds.lower, bounds.upper, len(components)
        )
    with mistakes.noted():
        if plane is not None:
            rotation_keys = robot.base.rotation_key, robot.grasp.rotation_key
            check_plane_kept(path, key, plane, T_world_base, T_object_tip, model, rotation_keys)
        contacts = build_contacts(path, f"{key}.contact", robot.contact, components, T_object_tip.R)
    mistakes.raise_noted()
    built = CellRobot(
        name=robot.name,
        model=model,
        urdf=robot.urdf,
        xacro_args=reference.xacro_args,
        urdf_sha256=hashlib.sha256(content).hexdigest(),
        held=held,
        T_world_base=T_world_base,
        T_base_root=root_in_base(urdf_path, urdf, model.base_link, held),
        T_object_tip=T_object_tip,
        posture=np.array(robot.posture, dtype=float),
        torque_lower=torque_lower,
        torque_upper=torque_upper,
        wrench_lower=wrench_lower,
        wrench_upper=wrench_upper,
        motors=motors,
        remarks=(*robot.base.degrees_remarks(f"{key}.base"), *robot.grasp.degrees_remarks(f"{key}.grasp"), *of_motors),
        contacts=contacts,
        contact_rate=_contact_rate(robot.contact_rate, components),
    )
    return built, urdf


def _torque_limits(
    path: Path, urdf_path: Path, key: str, robot: RobotDescription, model: RobotModel
) -> tuple[Array, Array]:
    joints = [joint.name for joint in model.joints]
    if robot.torque is None:
        mistakes = Mistakes()
        for joint in model.joints:
            with mistakes.noted():
                _check_effort(path, urdf_path, robot, joint, joints)
        mistakes.raise_noted()
        upper = np.array([joint.effort for joint in model.joints], dtype=float)
        return -upper, upper
    given = robot.torque
    if isinstance(given, TorqueBounds):
        return given_torque_limits(path, f"{key}.torque", given.lower, given.upper, joints)
    return given_torque_limits(path, f"{key}.torque", None, given, joints)


def _check_effort(path: Path, urdf_path: Path, robot: RobotDescription, joint: Joint, joints: list[str]) -> None:
    if joint.effort is None or not 0 < joint.effort < NO_LIMIT:
        raise InputError(
            urdf_path,
            f"its effort limit is {'missing or 0' if joint.effort is None else joint.effort}, which says "
            f"nothing about the motor. Give 'torque: [{', '.join(joints)}]' in N m for robot "
            f"'{robot.name}' in {path.name}.",
            key=f"joint '{joint.name}'",
        )


def _contact_rate(given: list[float | None] | None, components: tuple[str, ...]) -> Array:
    """One a wrench component, of what is given for forces and for moments."""
    force, moment = (np.inf if rate is None else rate for rate in given or (None, None))
    return np.array([force if WRENCH_UNITS[component] == "N" else moment for component in components])
