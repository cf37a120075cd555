# SPDX-License-Identifier: MIT
"""What is in a URDF, for somebody who has not yet written a cell file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from mrts_codegen.urdf.link_inertia import link_inertia
from mrts_codegen.urdf.robot_model import build_robot_model

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Mistakes
from mrts.base.formats.urdf import NO_LIMIT, Link, Urdf, UrdfJoint
from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.motors import JointMotors
from mrts.cell.robot import Robot


def urdf_mistakes(
    path: Path, links: dict[str, Link], joints: list[UrdfJoint]
) -> tuple[tuple[InputError, ...], tuple[Remark, ...]]:
    """What breaks a rule in the masses and the joints of a URDF, on any chain or none, and what is let pass."""
    mistakes, remarks = Mistakes(), list[Remark]()
    for link in links.values():
        with mistakes.noted():
            link_inertia(path, link, remarks)
    for joint in joints:
        with mistakes.noted():
            if joint.moves:
                joint.check(path)
    return tuple(mistakes.found), tuple(remarks)


def arm_chain(path: Path, urdf: Urdf, base_link: str | None, tip_link: str) -> tuple[Robot, Array]:
    """The chain of a URDF from a base link to a tip link, which stands and holds nowhere yet.

    Returns:
        The arm, efforts that the URDF lacks infinite, and the centre of mass of what each joint carries up to the next,
        base frame with every joint at zero, Shape (n, 3) [m].
    """
    model = build_robot_model(path, urdf, base_link, tip_link)
    effort = np.array([joint.effort if 0 < joint.effort < NO_LIMIT else np.inf for joint in model.joints])
    coulomb, viscous = (tuple(getattr(joint, name) for joint in model.joints) for name in ("coulomb", "viscous"))
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
        source=model.source(
            urdf=str(path),
            sha256="",
            fixed={},
            effort=(*effort.tolist(),),
            velocity=None,
            joint_limits=None,
            friction=(coulomb, viscous),
        ),
        held={},
        motors=replace(JointMotors.unknown(len(effort)), coulomb=np.array(coulomb), viscous=np.array(viscous)),
        contacts=(),
        contact_rate=np.full(6, np.inf),
        point_limits=(),
    )
    pairs = zip(model.zero_frames()[:-1], model.joints, strict=True)
    return robot, np.array([frame.p + frame.R @ joint.body.com for frame, joint in pairs])
