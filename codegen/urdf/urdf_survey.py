# SPDX-License-Identifier: MIT
"""What is in a URDF, for somebody who has not yet written a cell file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from mrts_codegen.urdf.link_inertia import link_inertia
from mrts_codegen.urdf.robot_model import build_robot_model, check_tree
from mrts_codegen.urdf.shared_joints import root_in_base
from mrts_codegen.urdf.urdf_file import Urdf
from mrts_codegen.urdf.urdf_joint import (
    MOVING_TYPES,
    NO_LIMIT,
    friction,
    position_limits,
    unit_axis,
    velocity_limit,
)

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Mistakes
from mrts.base.formats.urdf_tree import JointEnds, UrdfTree
from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.motors import JointMotors
from mrts.cell.robot import Robot, RobotSource


def urdf_mistakes(path: Path, urdf: Urdf) -> tuple[tuple[InputError, ...], tuple[Remark, ...]]:
    """What breaks a rule in the joints and the masses of a URDF, on any chain or none, and what is let pass."""
    mistakes, remarks = Mistakes(), list[Remark]()
    with mistakes.noted():
        check_tree(path, {link.name: link for link in urdf.links}, urdf.joints)
    for link in urdf.links:
        with mistakes.noted():
            link_inertia(path, link, remarks)
    for joint in urdf.joints:
        for rule in (unit_axis, position_limits, velocity_limit, friction) if joint.type in MOVING_TYPES else ():
            with mistakes.noted():
                rule(path, joint)
    return tuple(mistakes.found), tuple(remarks)


def urdf_tree(path: Path, urdf: Urdf) -> UrdfTree:
    """Links and joints of a URDF."""
    links = tuple(link.name for link in urdf.links)
    check_tree(path, dict.fromkeys(links), urdf.joints)
    joints = {
        joint.child: JointEnds(joint.name, joint.type, joint.parent, joint.child, joint.mimic is not None)
        for joint in urdf.joints
    }
    return UrdfTree(next(link for link in links if link not in joints), links, joints)


def arm_chain(path: Path, urdf: Urdf, base_link: str | None, tip_link: str) -> tuple[Robot, Array]:
    """The chain of a URDF from a base link to a tip link, which stands and holds nowhere yet.

    Returns:
        The arm, efforts that the URDF lacks infinite, and the centre of mass of what each joint carries up to the next,
        base frame with every joint at zero, Shape (n, 3) [m].
    """
    model = build_robot_model(path, urdf, base_link, tip_link)
    efforts = [joint.effort or np.inf for joint in model.joints]
    effort = np.array([value if 0 < value < NO_LIMIT else np.inf for value in efforts])
    friction = {name: tuple(getattr(joint, name) for joint in model.joints) for name in ("coulomb", "viscous")}
    robot = Robot(
        name=tip_link,
        **model.of_robot(),
        T_world_base=RigidTransform.identity(),
        T_object_tip=RigidTransform.identity(),
        posture=np.zeros(len(effort)),
        torque_lower=-effort,
        torque_upper=effort,
        wrench_lower=np.full(6, -np.inf),
        wrench_upper=np.full(6, np.inf),
        source=RobotSource(
            urdf=str(path),
            xacro_args={},
            sha256="",
            base_link=model.base_link,
            tip_link=model.tip_link,
            fixed={},
            T_base_root=root_in_base(path, urdf, model.base_link, {}),
            carried_mass=tuple(joint.body.mass for joint in model.joints),
            point_links=tuple(joint.point_links for joint in model.joints),
            effort=(*effort.tolist(),),
            friction=(friction["coulomb"], friction["viscous"]),
        ),
        held={},
        motors=replace(
            JointMotors.unknown(len(effort)),
            coulomb=np.array(friction["coulomb"]),
            viscous=np.array(friction["viscous"]),
        ),
        contacts=(),
        contact_rate=np.full(6, np.inf),
    )
    pairs = zip(model.zero_frames()[:-1], model.joints, strict=True)
    return robot, np.array([frame.p + frame.R @ joint.body.com for frame, joint in pairs])
