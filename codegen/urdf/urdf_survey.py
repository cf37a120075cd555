# SPDX-License-Identifier: MIT
"""What is in a URDF, for somebody who has not yet written a cell file."""

from pathlib import Path

import numpy as np
from mrts_codegen.urdf.robot_model import build_robot_model, check_tree
from mrts_codegen.urdf.shared_joints import root_in_base
from mrts_codegen.urdf.urdf_elements import Urdf
from mrts_codegen.urdf.urdf_joint import NO_LIMIT

from mrts.base.formats.urdf_tree import ArmChain, JointEnds, UrdfTree


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
