# SPDX-License-Identifier: MIT
"""What makes a planar cell planar: bases, joints and grasps that stay in its plane."""

from pathlib import Path

import numpy as np
from mrts_codegen.urdf.robot_model import RobotModel

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.rigid_transform import RigidTransform, multiply

PLANE_COMPONENTS = {None: (0, 1, 2, 3, 4, 5), "xy": (0, 1, 5), "xz": (0, 2, 4), "yz": (1, 2, 3)}
"""Which rows of a wrench or twist [x, y, z, about x, about y, about z] a cell uses, by its `plane`."""

PLANE_TOLERANCE = 1e-9
"""Largest entry of a rotation that still counts as zero: 1 nm at 1 m, far below any calibration."""


def plane_normal(plane: str) -> Array:
    """First × second coordinate axis of a plane, Shape (3,): 'xz' has -y."""
    first, second = (np.eye(3)["xyz".index(axis)] for axis in plane)
    return np.cross(first, second)


def check_plane_kept(
    path: Path,
    key: str,
    plane: str,
    T_world_base: RigidTransform,
    T_object_tip: RigidTransform,
    model: RobotModel,
) -> None:
    """Check that base, joints and grasp of an arm stay in the plane of the cell.

    Raises:
        InputError: If the base or the tip is tilted, or a joint leaves the plane.
    """
    normal = plane_normal(plane)
    tilt = T_world_base.R @ normal - normal
    if np.max(np.abs(tilt)) > PLANE_TOLERANCE:
        raise InputError(
            path,
            f"in a cell with plane {plane} a base may turn about the plane's normal only.",
            key=f"{key}.base.rpy",
        )
    T = RigidTransform.identity()
    for joint in model.joints:
        T = T @ joint.placement
        along = float((T.R @ joint.axis) @ normal)
        off = abs(abs(along) - 1) if joint.kind == "revolute" else abs(along)
        if off > PLANE_TOLERANCE:
            raise InputError(
                path,
                f"joint '{joint.name}' leaves the plane {plane}: a revolute axis must be normal to it, a "
                "prismatic axis must lie in it. Turn the base, or drop 'plane'.",
                key=f"{key}.urdf",
            )
    R_base_tip = multiply(T.R, model.tip.R)
    R_tip_object = multiply(R_base_tip, T_object_tip.R.T)
    if np.max(np.abs(R_tip_object @ normal - normal)) > PLANE_TOLERANCE:
        angle = np.degrees(np.arccos(np.clip((R_tip_object @ normal) @ normal, -1, 1)))
        raise InputError(
            path,
            f"the tip frame '{model.tip_link}' is tilted by {angle:.4g}° against the object. Choose a grasp "
            f"rotation that differs from the tip's own only about the plane's normal ({plane}).",
            key=f"{key}.grasp.rpy",
        )
