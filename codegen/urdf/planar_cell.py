# SPDX-License-Identifier: MIT
"""What makes a planar cell planar: bases, joints and grasps that stay in its plane."""

from pathlib import Path

from mrts_codegen.urdf.robot_model import RobotModel

from mrts.base.errors import InputError
from mrts.base.rigid_transform import PLANE_TOLERANCE, RigidTransform, base_leaves, grasp_leaves, plane_normal

PLANE_COMPONENTS = {None: (0, 1, 2, 3, 4, 5), "xy": (0, 1, 5), "xz": (0, 2, 4), "yz": (1, 2, 3)}
"""Which rows of a wrench or twist [x, y, z, about x, about y, about z] a cell uses, by its `plane`."""


def check_plane_kept(
    path: Path,
    key: str,
    plane: str,
    T_world_base: RigidTransform,
    T_object_tip: RigidTransform,
    model: RobotModel,
    rotation_keys: tuple[str, str],
) -> None:
    """Check that base, joints and grasp of an arm stay in the plane of the cell."""
    problem = base_leaves(plane, T_world_base.R)
    if problem:
        raise InputError(path, problem, key=f"{key}.base.{rotation_keys[0]}")
    normal = plane_normal(plane)
    *frames, T_base_tip = model.zero_frames()
    for joint, frame in zip(model.joints, frames, strict=True):
        along = float((frame.R @ joint.axis) @ normal)
        off = abs(abs(along) - 1) if joint.kind == "revolute" else abs(along)
        if off > PLANE_TOLERANCE:
            raise InputError(
                path,
                f"joint '{joint.name}' leaves the plane {plane}: a revolute axis must be normal to it, a "
                "prismatic axis must lie in it. Turn the base, or drop 'plane'.",
                key=f"{key}.urdf",
            )
    problem = grasp_leaves(plane, T_object_tip.R, T_base_tip.R, model.tip_link)
    if problem:
        raise InputError(path, problem, key=f"{key}.grasp.{rotation_keys[1]}")
