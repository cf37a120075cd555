# SPDX-License-Identifier: MIT
"""The geometry of an arm that moves in a plane: what closed-form inverse kinematics needs."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mrts_codegen.robot_model import RobotModel

from mrts.errors import InputError
from mrts.rigid_transform import Array, RigidTransform, multiply

PLANE_TOLERANCE = 1e-9
"""Largest entry of a rotation that still counts as zero: 1 nm at 1 m, far below any calibration."""

CLOSED_FORM_JOINTS = 3
"""Two links reach a point, a third turns the tip: the chain with a closed-form inverse."""


@dataclass(frozen=True)
class PlanarChain:
    """Three revolute joints whose axes are normal to the plane, all in base axes at joint position 0.

    In-plane vectors are the plane's two coordinates in the order of its name; angles are positive about
    `normal` = first × second coordinate axis.

    Attributes:
        anchor: Joint 1, Shape (2,) [m].
        links: Joint 1 to 2, 2 to 3, 3 to tip, Shape (3, 2) [m].
        signs: +1 or -1: sense of each joint about the normal, Shape (3,).
        R_base_tip: Rotation of the tip, Shape (3, 3).
        offset: Tip's coordinate along the normal [m].
    """

    anchor: Array
    links: Array
    signs: Array
    R_base_tip: Array
    offset: float


def plane_axes(plane: str) -> tuple[int, int]:
    """Coordinate numbers of a plane's two axes: 'xz' is (0, 2)."""
    return "xyz".index(plane[0]), "xyz".index(plane[1])


def plane_normal(plane: str) -> Array:
    """First × second coordinate axis of a plane, Shape (3,): 'xz' has -y."""
    first, second = plane_axes(plane)
    unit = np.eye(3)
    return np.cross(unit[first], unit[second])


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


def planar_chain(plane: str, model: RobotModel) -> PlanarChain | None:
    """Geometry of a chain that `check_plane_kept` accepted; None unless it has three revolute joints."""
    if len(model.joints) != CLOSED_FORM_JOINTS or any(joint.kind != "revolute" for joint in model.joints):
        return None
    normal, axes = plane_normal(plane), list(plane_axes(plane))
    T = RigidTransform.identity()
    points, signs = [], []
    for joint in model.joints:
        T = T @ joint.placement
        points.append(T.p[axes])
        signs.append(float(np.sign((T.R @ joint.axis) @ normal)))
    T = T @ model.tip
    points.append(T.p[axes])
    return PlanarChain(points[0], np.diff(np.array(points), axis=0), np.array(signs), T.R, float(T.p @ np.abs(normal)))
