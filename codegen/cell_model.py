# SPDX-License-Identifier: MIT
"""The cell with its URDFs read: everything that the symbolic layer and the manifest need."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mrts_codegen.cell_file import Bounds, CellDescription, RobotDescription, TorqueBounds, resolve_urdf
from mrts_codegen.hand_file import build_contacts
from mrts_codegen.motors_block import build_motors
from mrts_codegen.urdf.held_joints import held_positions
from mrts_codegen.urdf.planar_cell import PLANE_COMPONENTS, check_plane_kept
from mrts_codegen.urdf.robot_model import RobotModel, build_robot_model
from mrts_codegen.urdf.shared_joints import check_machines
from mrts_codegen.urdf.urdf_file import read_urdf
from mrts_codegen.urdf.urdf_joint import NO_LIMIT

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.input_file import MAX_URDF_BYTES
from mrts.base.manifest import WRENCH_COMPONENTS, WRENCH_UNITS
from mrts.base.regular_file import read_regular
from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform
from mrts.hands.contact import Contact
from mrts.motors.joint_motors import JointMotors


@dataclass(frozen=True, kw_only=True)
class CellRobot:
    """One arm in its place.

    Attributes:
        name: Name in the cell file.
        model: The chain.
        urdf: As the cell file gives it.
        urdf_sha256: Hash of the URDF's bytes.
        held: Joints that are held still, and what moves with them, with their positions [rad or m].
        T_world_base: Base link in the world.
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
    urdf_sha256: str
    held: Mapping[str, float]
    T_world_base: RigidTransform
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
    """

    description: CellDescription
    components: tuple[int, ...]
    wrench_components: tuple[str, ...]
    robots: tuple[CellRobot, ...]

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """What to know of the URDFs, each thing once."""
        said = (remark for robot in self.robots for remark in (*robot.model.remarks, *robot.remarks))
        return tuple(dict.fromkeys(said))


def build_cell_model(path: Path, description: CellDescription) -> CellModel:
    """Read the URDFs of a cell and check every array of the cell file against them.

    Args:
        path: The cell file, for messages and for relative URDF paths.
        description: Its content.

    Raises:
        InputError: If a URDF or an array of the cell file breaks a rule.
    """
    components = PLANE_COMPONENTS[description.plane]
    names = tuple(WRENCH_COMPONENTS[component] for component in components)
    files = [resolve_urdf(path, robot.urdf) for robot in description.robots]
    urdfs = [read_urdf(file) for file in files]
    robots = tuple(
        _build_robot(path, description, index, names, file, urdf)
        for index, (file, urdf) in enumerate(zip(files, urdfs, strict=True))
    )
    check_machines(path, robots, urdfs)
    return CellModel(description, components, names, robots)


def _build_robot(
    path: Path, cell: CellDescription, index: int, components: tuple[str, ...], urdf_path: Path, urdf: Any
) -> CellRobot:
    robot = cell.robots[index]
    key = f"robots[{index}] ({robot.name})"
    held = held_positions(path, f"{key}.fixed", urdf_path, urdf, robot.fixed)
    model = build_robot_model(urdf_path, urdf, robot.base_link, robot.tip_link, held)
    joints = [joint.name for joint in model.joints]
    if len(robot.posture) != len(joints):
        raise InputError(
            path,
            f"must have {len(joints)} values, one for each of {', '.join(joints)}.",
            key=f"{key}.posture",
            value=robot.posture,
        )
    torque_lower, torque_upper = _torque_limits(path, urdf_path, key, robot, model)
    wrench_lower, wrench_upper = _wrench_limits(path, key, robot.wrench, len(components))
    motors, remarks = build_motors(path, f"{key}.motors", robot, model, (torque_lower, torque_upper))
    T_world_base = RigidTransform.from_xyz_rpy(robot.base.xyz, robot.base.rpy)
    T_object_tip = RigidTransform.from_xyz_rpy(robot.grasp.xyz, robot.grasp.rpy)
    if cell.plane is not None:
        check_plane_kept(path, key, cell.plane, T_world_base, T_object_tip, model)
    return CellRobot(
        name=robot.name,
        model=model,
        urdf=robot.urdf,
        urdf_sha256=hashlib.sha256(read_regular(urdf_path, "URDF", MAX_URDF_BYTES)).hexdigest(),
        held=held,
        T_world_base=T_world_base,
        T_object_tip=T_object_tip,
        posture=np.array(robot.posture, dtype=float),
        torque_lower=torque_lower,
        torque_upper=torque_upper,
        wrench_lower=wrench_lower,
        wrench_upper=wrench_upper,
        motors=motors,
        remarks=remarks,
        contacts=build_contacts(path, f"{key}.contact", robot.contact, components, T_object_tip.R),
        contact_rate=_contact_rate(robot.contact_rate, components),
    )


def _torque_limits(
    path: Path, urdf_path: Path, key: str, robot: RobotDescription, model: RobotModel
) -> tuple[Array, Array]:
    joints = [joint.name for joint in model.joints]
    if robot.torque is None:
        for joint in model.joints:
            if joint.effort is None or not 0 < joint.effort < NO_LIMIT:
                raise InputError(
                    urdf_path,
                    f"its effort limit is {'missing or 0' if joint.effort is None else joint.effort}, which says "
                    f"nothing about the motor. Give 'torque: [{', '.join(joints)}]' in N m for robot "
                    f"'{robot.name}' in {path.name}.",
                    key=f"joint '{joint.name}'",
                )
        upper = np.array([joint.effort for joint in model.joints], dtype=float)
        return -upper, upper
    if isinstance(robot.torque, TorqueBounds):
        sides = {"torque.lower": robot.torque.lower, "torque.upper": robot.torque.upper}
    else:
        sides = {"torque": robot.torque}
    for name, values in sides.items():
        if len(values) != len(joints):
            raise InputError(
                path,
                f"must have {len(joints)} values, one for each of {', '.join(joints)}.",
                key=f"{key}.{name}",
                value=values,
            )
    upper = np.array(list(sides.values())[-1], dtype=float)
    lower = np.array(sides["torque.lower"], dtype=float) if "torque.lower" in sides else -upper
    if np.any(lower >= upper):
        joint_index = int(np.argmax(lower >= upper))
        raise InputError(
            path,
            f"the lower torque limit {lower[joint_index]:g} of joint '{joints[joint_index]}' must be below "
            f"the upper one, {upper[joint_index]:g} (a symmetric limit must be > 0).",
            key=f"{key}.torque",
        )
    return lower, upper


def _wrench_limits(path: Path, key: str, bounds: Bounds, size: int) -> tuple[Array, Array]:
    sides = []
    for name, values, unbounded in (("lower", bounds.lower, -np.inf), ("upper", bounds.upper, np.inf)):
        if values is not None and len(values) != size:
            what = "fx, fy, fz, nx, ny, nz" if size != 3 else "two forces and the moment about the plane's normal"  # noqa: PLR2004
            raise InputError(
                path,
                f"must have {size} values ({what}); null is unbounded.",
                key=f"{key}.wrench.{name}",
                value=values,
            )
        filled = [unbounded if value is None else value for value in values or [None] * size]
        sides.append(np.array(filled, dtype=float))
    lower, upper = sides
    if np.any(lower > upper):
        component = int(np.argmax(lower > upper))
        raise InputError(
            path,
            f"its lower bound {lower[component]:g} exceeds its upper bound {upper[component]:g}.",
            key=f"{key}.wrench[{component}]",
        )
    return lower, upper


def _contact_rate(given: list[float | None] | None, components: tuple[str, ...]) -> Array:
    """One a wrench component, of what is given for forces and for moments."""
    force, moment = (np.inf if rate is None else rate for rate in given or (None, None))
    return np.array([force if WRENCH_UNITS[component] == "N" else moment for component in components])
