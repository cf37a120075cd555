# SPDX-License-Identifier: MIT
"""What is in a URDF, for somebody who has not yet written a cell file."""

from pathlib import Path

import numpy as np
from mrts_codegen.urdf.link_inertia import link_inertia
from mrts_codegen.urdf.robot_model import build_robot_model

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Mistakes
from mrts.base.formats.urdf import Link, Urdf, UrdfJoint
from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.base.remark import Remark
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
    attributes = model.attributes(len(WRENCH_COMPONENTS), urdf=str(path), sha256="", fixed={}, held={})
    robot = Robot(name=tip_link, **attributes)
    pairs = zip(model.zero_frames()[:-1], model.joints, strict=True)
    return robot, np.array([frame.p + frame.R @ joint.body.com for frame, joint in pairs])
