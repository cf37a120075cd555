# SPDX-License-Identifier: MIT
"""What is in a URDF, for somebody who has not yet written a cell file."""

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

from mrts.base.errors import InputError, Mistakes
from mrts.base.formats.urdf_tree import ArmChain, JointEnds, UrdfTree
from mrts.base.remark import Remark


def urdf_mistakes(path: Path, urdf: Urdf) -> tuple[tuple[InputError, ...], tuple[Remark, ...]]:
    """What breaks a rule in the joints and the masses of a URDF, on any chain or none, and what is let pass.

    Args:
        path: The file, for messages.
        urdf: What `parse_urdf` returned.
    """
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
    """Links and joints of a URDF.

    Args:
        path: The file, for messages.
        urdf: What `parse_urdf` returned.

    Raises:
        InputError: If it is no tree.
    """
    links = tuple(link.name for link in urdf.links)
    check_tree(path, dict.fromkeys(links), urdf.joints)
    joints = {
        joint.child: JointEnds(joint.name, joint.type, joint.parent, joint.child, joint.mimic is not None)
        for joint in urdf.joints
    }
    return UrdfTree(next(link for link in links if link not in joints), links, joints)


def arm_chain(path: Path, urdf: Urdf, base_link: str | None, tip_link: str) -> ArmChain:
    """The chain of a URDF from a base link to a tip link.

    Args:
        path: The file, for messages.
        urdf: What `parse_urdf` returned.
        base_link: Where it begins; None is the root.
        tip_link: Where it ends.

    Raises:
        InputError: If there is no such chain, or it breaks a rule of cells.
    """
    model = build_robot_model(path, urdf, base_link, tip_link)
    *frames, tip = model.zero_frames()
    pairs = list(zip(frames, model.joints, strict=True))
    return ArmChain(
        base_link=model.base_link,
        tip_link=model.tip_link,
        joints=tuple(joint.name for joint in model.joints),
        types=tuple(joint.kind for joint in model.joints),
        axes=np.array([frame.R @ joint.axis for frame, joint in pairs]),
        points=np.array([frame.p for frame in frames]),
        lower=np.array([joint.lower for joint in model.joints]),
        upper=np.array([joint.upper for joint in model.joints]),
        effort=tuple(
            joint.effort if joint.effort is not None and 0 < joint.effort < NO_LIMIT else None for joint in model.joints
        ),
        velocity=tuple(joint.velocity for joint in model.joints),
        mass=np.array([joint.body.mass for joint in model.joints]),
        point_links=tuple(joint.point_links for joint in model.joints),
        com=np.array([frame.p + frame.R @ joint.body.com for frame, joint in pairs]),
        T_base_tip=tip,
        T_root_base=root_in_base(path, urdf, model.base_link, {}).inverse(),
    )
