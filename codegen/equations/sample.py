# SPDX-License-Identifier: MIT
"""One sample of a moving cell: the inputs of its functions, and all terms of the closed chain."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate
from typing import Any

import casadi as ca
from mrts_codegen.cell_model import CellModel
from mrts_codegen.equations.dynamics import contact_offset, frame_jacobian, joint_steps, object_terms, scaled_arm_terms
from mrts_codegen.urdf.robot_model import Inertia, RobotModel

from mrts.base.manifest import GEOMETRY, LOAD_ENTRIES
from mrts.base.rigid_transform import RigidTransform

MOVING = ("q", "dq", "ddq", "object_rotation", "object_twist", "object_acceleration", "load")
"""Inputs of a moving sample: joint positions, q' and q'' of all arms in order, each Shape (m,); of the object its
rotation, Shape (3, 3), [p'; φ'] and [p''; φ''] in world axes, each Shape (6,); the load vector, `LOAD_ENTRIES`."""


@dataclass(frozen=True, kw_only=True)
class Sample:
    """Symbols of one sample of a cell, and its terms; m joints in all, n arms, w wrench components.

    Attributes:
        cell: The cell.
        inputs: By name: `MOVING`; "shares" of the arms, Shape (n,); "wrench" and "internal_wrench" in base axes and
            "object_wrench" in object axes, Shape (n w,) each; "geometry", laid out as
            `mrts.cell.record.CellRecord.geometry`, or its numbers.
        gravity: Downward, world axes, Shape (3,) [m/s²].
        bases: Base of each arm in the world.
        grasps: Tip of each arm in the object frame.
        models: The chains.
    """

    cell: CellModel
    inputs: dict[str, Any]
    gravity: Any
    bases: tuple[RigidTransform, ...]
    grasps: tuple[RigidTransform, ...]
    models: tuple[RobotModel, ...]

    def arms(self, name: str) -> list[Any]:
        """An input over all joints, Shape (m,), one piece an arm."""
        ends = accumulate((len(model.joints) for model in self.models), initial=0)
        return list(ca.vertsplit(self.inputs[name], list(ends)))

    @cached_property
    def down(self) -> list[Any]:
        """Downward gravity in the base axes of each arm, each Shape (3,) [m/s²]."""
        return [base.R.T @ self.gravity for base in self.bases]

    @cached_property
    def steps(self) -> list[Any]:
        """`joint_steps` of each arm; once, because they are a third of what generation takes."""
        return [joint_steps(model, q) for model, q in zip(self.models, self.arms("q"), strict=True)]

    @cached_property
    def J(self) -> list[Any]:  # noqa: N802 (as in the paper)
        """Jacobian of each arm in its base axes, each Shape (w, n_i)."""
        rows, arms = self.cell.record.wrench_rows, zip(self.models, self.steps, strict=True)
        return [ca.densify(frame_jacobian(*arm)[rows, :]) for arm in arms]

    @cached_property
    def terms_of_arms(self) -> tuple[Any, Any, Any]:
        """Inertial torques E [N m], A per time-warp acceleration [N m s²], gravity torques G [N m], each Shape (m,)."""
        arms = zip(self.models, self.steps, *map(self.arms, ("dq", "ddq")), self.down, strict=True)
        each = [scaled_arm_terms(*arm) for arm in arms]
        E, A, G = (ca.densify(ca.vertcat(*parts)) for parts in zip(*each, strict=True))
        return E, A, G

    @cached_property
    def offsets(self) -> list[Any]:
        """Contact point minus com of each arm in world axes, each Shape (3,) [m]."""
        return [contact_offset(self.inputs["object_rotation"], grasp.p) for grasp in self.grasps]

    @cached_property
    def terms_of_object(self) -> tuple[Any, Any, Any]:
        """Inertial wrench of the object P, S per time-warp acceleration, Q that carries its weight, each Shape (w,)."""
        R, twist, acceleration, load = (self.inputs[name] for name in MOVING[3:])
        return object_terms(load, R, twist, acceleration, self.gravity, self.cell.record.wrench_rows)


def sample_of(cell: CellModel, *, bake: bool = False) -> Sample:
    """The symbols of a cell; its geometry is an input, or folded in (`bake`).

    In a planar cell bases turn about the plane's normal only, and gravity along it moves no joint.
    """
    m, n, plane = sum(len(model.joints) for model in cell.models), len(cell.models), cell.record.plane
    shapes = {"q": (m,), "dq": (m,), "ddq": (m,), "object_rotation": (3, 3), "object_twist": (6,)}
    shapes |= {"object_acceleration": (6,), "load": (len(LOAD_ENTRIES),), "shares": (n,)}
    wrenches = dict.fromkeys(("wrench", "internal_wrench", "object_wrench"), (n * len(cell.record.wrench_rows),))
    inputs = {name: ca.SX.sym(name, *shape) for name, shape in (shapes | wrenches).items()}
    numbers = cell.record.geometry
    inputs[GEOMETRY] = ca.SX(numbers) if bake else ca.SX.sym(GEOMETRY, numbers.size)
    entries = iter(ca.vertsplit(inputs[GEOMETRY]))
    gravity = _take(entries, 3)
    placed = [(_pose(entries), _pose(entries)) for _ in cell.models]
    if plane is not None:
        gravity = ca.vertcat(*(gravity[axis] if "xyz"[axis] in plane else ca.SX(0) for axis in range(3)))
        placed = [(RigidTransform(_turned_in_plane(base.R, plane), base.p), grasp) for base, grasp in placed]
    bases, grasps = zip(*placed, strict=True)
    models = tuple(_placed_by_held(model, entries) for model in cell.models)
    return Sample(cell=cell, inputs=inputs, gravity=gravity, bases=bases, grasps=grasps, models=models)


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


def _placed_by_held(model: RobotModel, entries: Iterator[Any]) -> RobotModel:
    """A chain with entries where `RobotModel.held_numbers` has numbers, in the same order."""
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
