# SPDX-License-Identifier: MIT
"""Where gravity points, arms stand and hands hold, and links that held joints place: inputs of functions, or numbers.

The layout is that of `mrts.base.manifest.geometry_size`; the run time fills it (`mrts.cell.cell.Cell.geometry`).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
from mrts_codegen.cell_model import CellModel
from mrts_codegen.urdf.link_inertia import Inertia
from mrts_codegen.urdf.robot_model import RobotModel

from mrts.base.manifest import geometry_size
from mrts.base.rigid_transform import RigidTransform, multiply


@dataclass(frozen=True, kw_only=True)
class Geometry:
    """What the equations of a cell take of its geometry, symbols or numbers alike; n arms.

    Attributes:
        symbol: All of it as one input, Shape (3 + 24 n + h,); None where it is numbers.
        gravity: Downward, world axes, Shape (3,) [m/s²].
        down: The same in the base axes of each arm.
        bases: Base of each arm in the world.
        grasps: Tip of each arm in the object frame.
        models: The chains.
    """

    symbol: Any
    gravity: Any
    down: tuple[Any, ...]
    bases: tuple[RigidTransform, ...]
    grasps: tuple[RigidTransform, ...]
    models: tuple[RobotModel, ...]


def geometry_numbers(cell: CellModel) -> Geometry:
    """The geometry of a cell file folded into the functions."""
    gravity, robots = cell.record.gravity, cell.record.robots
    return Geometry(
        symbol=None,
        gravity=gravity,
        down=tuple(multiply(robot.T_world_base.R.T, gravity) for robot in robots),
        bases=tuple(robot.T_world_base for robot in robots),
        grasps=tuple(robot.T_object_tip for robot in robots),
        models=cell.models,
    )


def geometry_symbols(cell: CellModel) -> Geometry:
    """The geometry as an input.

    In a planar cell bases turn about the plane's normal only, and gravity along it moves no joint.
    """
    size = geometry_size(len(cell.models), sum(model.held_numbers().size for model in cell.models))
    symbol = ca.SX.sym("geometry", size)
    entries = iter(ca.vertsplit(symbol))
    plane = cell.record.plane
    gravity = _take(entries, 3)
    bases, grasps = [], []
    for _ in cell.models:
        base, grasp = _pose(entries), _pose(entries)
        bases.append(base if plane is None else RigidTransform(_turned_in_plane(base.R, plane), base.p))
        grasps.append(grasp)
    if plane is not None:
        gravity = ca.vertcat(*(gravity[axis] if "xyz"[axis] in plane else ca.SX(0) for axis in range(3)))
    models = tuple(_with_symbols(model, entries) for model in cell.models)
    down = tuple(base.R.T @ gravity for base in bases)
    return Geometry(symbol=symbol, gravity=gravity, down=down, bases=tuple(bases), grasps=tuple(grasps), models=models)


def _take(entries: Iterator[Any], count: int) -> Any:
    return ca.vertcat(*(next(entries) for _ in range(count)))


def _matrix(entries: Iterator[Any]) -> Any:
    return ca.reshape(_take(entries, 9), 3, 3).T


def _pose(entries: Iterator[Any]) -> RigidTransform:
    return RigidTransform(_matrix(entries), _take(entries, 3))


def _turned_in_plane(R: Any, plane: str) -> Any:
    """The rotation with exact zeros and ones where a turn about the plane's normal has them."""
    for row in range(3):
        for column in range(3):
            if not ("xyz"[row] in plane and "xyz"[column] in plane):
                R[row, column] = ca.SX(1 if row == column else 0)
    return R


def _with_symbols(model: RobotModel, entries: Iterator[Any]) -> RobotModel:
    """A chain with symbols where `RobotModel.held_numbers` has numbers, in the same order."""
    joints = []
    for joint in model.joints:
        placement, body = joint.placement, joint.body
        if joint.placed_by_held:
            placement = _pose(entries)
        if joint.laden_by_held:
            com = _take(entries, 3)
            body = Inertia(body.mass, com, _matrix(entries))
        joints.append(replace(joint, placement=placement, body=body))
    return replace(model, joints=tuple(joints), tip=_pose(entries) if model.tip_by_held else model.tip)
