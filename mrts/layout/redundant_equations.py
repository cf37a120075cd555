# SPDX-License-Identifier: MIT
"""Which joint positions a redundant arm takes, for CasADi: those that `mrts.following.null_space` chooses."""

from typing import Any

import casadi as ca
import numpy as np

from mrts.base.arrays import Array, apply
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.following.null_space import LIMIT_PUSH, is_redundant, limit_zone, stretched


def redundant_joints(cell: Cell) -> list[int]:
    """Places of the joints of all redundant arms, R of them, among those of the cell."""
    return [
        joint
        for robot, part in zip(cell.robots, cell.joint_slices.values(), strict=True)
        if is_redundant(cell, robot)
        for joint in range(part.start, part.stop)
    ]


def preference(cell: Cell, functions: dict[str, Any], q: Any, F: Any, reference: Any, geometry: Any) -> Any:
    """h(q) - h(reference) - JᵀF of all redundant arms: zero at the positions nearest to the reference, Shape (R,).

    Args:
        cell: The cell.
        functions: CasADi's functions of the cell.
        q: Joint positions of all arms, Shape (m,).
        F: Multipliers of the grasps of redundant arms, Shape (w,) each, stacked.
        reference: Joint positions of redundant arms to stay near, Shape (R,).
        geometry: Shape (g,).
    """
    J = functions["kinematics"](q=q, geometry=geometry)["jacobian"]
    rows: list[Any] = []
    w, start = len(cell.wrench_components), 0
    for robot, part in zip(cell.robots, cell.joint_slices.values(), strict=True):
        if is_redundant(cell, robot):
            there = reference[start : start + len(robot.joints)]
            multiplier = F[w * len(rows) : w * (len(rows) + 1)]
            rows.append(_stretched(robot, q[part]) - _stretched(robot, there) - J[:, part].T @ multiplier)
            start += len(robot.joints)
    return ca.vertcat(*rows)


def preference_along(value: Any, position: tuple[Any, Any, Any], multiplier: tuple[Any, Any, Any]) -> Any:
    """The preference and its two derivatives along the path, Shape (3 R,).

    Args:
        value: From `preference`.
        position: q, q' and q'' of all arms, Shape (m,) each.
        multiplier: F, F' and F'' likewise.
    """
    at, rate, change = (ca.vertcat(*pair) for pair in zip(position, multiplier, strict=True))
    first = ca.jtimes(value, at, rate)
    second = ca.jtimes(first, ca.vertcat(at, rate), ca.vertcat(rate, change))
    return ca.vertcat(value, first, second)


def multipliers(cell: Cell, q: Array, reference: Array) -> Array:
    """F of least squares at given positions of all arms, Shape (N, w a) for a redundant arms.

    Args:
        cell: The cell.
        q: Shape (N, m) [rad or m].
        reference: Positions of all arms to stay near, Shape (m,) [rad or m].
    """
    J = cell.functions("kinematics", len(q), {"q": q})["jacobian"]
    found = [np.zeros((len(q), 0))]
    for robot, part in zip(cell.robots, cell.joint_slices.values(), strict=True):
        if is_redundant(cell, robot):
            gradient = stretched(robot, q[:, part]) - stretched(robot, reference[None, part])
            found.append(apply(np.linalg.pinv(J[:, :, part]).transpose(0, 2, 1), gradient))
    return np.concatenate(found, axis=1)


def _stretched(robot: Robot, q: Any) -> Any:
    """h(q) of `mrts.following.null_space.stretched` in symbols, Shape (n_i,)."""
    zone = limit_zone(robot)
    values = []
    for joint, (low, high) in enumerate(zip(robot.position_lower, robot.position_upper, strict=True)):
        over = ca.fmax((q[joint] - high) / zone[joint] + 1, 0) if np.isfinite(high) else 0
        under = ca.fmax((low - q[joint]) / zone[joint] + 1, 0) if np.isfinite(low) else 0
        values.append(q[joint] + LIMIT_PUSH * (over**5 - under**5))
    return ca.vertcat(*values)
