# SPDX-License-Identifier: MIT
"""Which joint positions a redundant arm takes of all that hold its grasp.

Those nearest to a reference, near a limit measured in stretched joint positions: the minimiser of a distance H(q) on
the set that holds the grasp, so a function of the object's pose alone, whatever the samples and the speed (the extended
Jacobian method: Baillieul 1985; the gradient of H away from limits: Liégeois 1977). With the grasp's multipliers F

    h(q) - h(reference) = JᵀF,    h_j(q) = q_j + LIMIT_PUSH (x⁺⁵ - x⁻⁵),

where x⁺ and x⁻ grow from 0 to 1 over the zone beside the upper and the lower limit. Both equations, differentiated
along the path, give q' and q''.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot

LIMIT_ZONE = 0.5
"""Width of the zone beside each position limit, as a share of the joint's range: a narrow one brakes hard in it."""

WIDEST_ZONE = 3.0
"""Its largest width [rad or m], also that of a joint with a limit on one side only."""

NARROWEST_ZONE = 1e-3
"""Its smallest width [rad or m]: a joint whose limits coincide divides by it."""

LIMIT_PUSH = 20.0
"""What h adds at a limit [rad or m]: many times any distance to a reference, so that limits win over nearness."""

FOLD = 1e-3
"""Curvature of H on the set that holds the grasp (1 far from limits on a flat set) below which its minimum ends."""


SINGULAR = 1e-12
"""Share of the largest singular value of a Jacobian below which a direction counts as lost."""


@dataclass(frozen=True)
class Stretched:
    """Stretched joint positions and their derivatives by q, each Shape (T, n_i)."""

    h: Array
    slope: Array
    bend: Array


def limit_zone(robot: Robot) -> Array:
    """Width of the zone beside each joint's position limits, Shape (n_i,) [rad or m]."""
    zone: Array = np.clip(LIMIT_ZONE * (robot.position_upper - robot.position_lower), NARROWEST_ZONE, WIDEST_ZONE)
    return zone


def stretched(robot: Robot, q: Array) -> Stretched:
    """h(q), h'(q) and h''(q), Shape (T, n_i) each.

    Args:
        robot: The arm.
        q: Its joint positions, Shape (T, n_i) [rad or m].
    """
    zone = limit_zone(robot)
    over = np.maximum((q - robot.position_upper) / zone + 1, 0)
    under = np.maximum((robot.position_lower - q) / zone + 1, 0)
    return Stretched(
        q + LIMIT_PUSH * (over**5 - under**5),
        1 + LIMIT_PUSH * 5 / zone * (over**4 + under**4),
        LIMIT_PUSH * 20 / zone**2 * (over**3 - under**3),
    )


@dataclass(frozen=True, kw_only=True)
class NullSpace:
    """H on the sets that hold the grasp of one redundant arm, at T joint positions.

    Attributes:
        inverse: J⁺, Shape (T, n, w).
        basis: Orthonormal basis of the null space of J, Shape (T, n, n - w).
        gradient: h(q) - h(reference), Shape (T, n).
        multiplier: F of least squares of gradient = JᵀF, Shape (T, w).
        hessian: h' - ∂(JᵀF)/∂q, Shape (T, n, n).
        bend: h'', Shape (T, n).
        curvature: Smallest eigenvalue of the Hessian on the basis, Shape (T,); H has a minimum where it is positive.
    """

    inverse: NDArray[np.floating[Any]]
    basis: Array
    gradient: Array
    multiplier: Array
    hessian: Array
    bend: Array
    curvature: Array

    def solve(self, along: Array, change: Array) -> tuple[Array, Array]:
        """Joint rates x = along + basis y with hessian x = change + Jᵀ(anything).

        Args:
            along: What the grasp wants of the joints, Shape (T, n).
            change: Shape (T, n).

        Returns:
            x, Shape (T, n), and the size of y, Shape (T,).
        """
        rest = change - apply(self.hessian, along)
        transposed = self.basis.transpose(0, 2, 1)
        reduced = transposed @ self.hessian @ self.basis
        y: Array = np.asarray(np.linalg.solve(reduced, apply(transposed, rest)[:, :, None])[:, :, 0], dtype=np.float64)
        size: Array = np.sqrt(np.sum(y**2, axis=1))
        return along + apply(self.basis, y), size


def is_redundant(cell: Cell, robot: Robot) -> bool:
    """Whether an arm has more joints than its wrench has components."""
    return len(robot.joints) > len(cell.wrench_components)


def null_spaces(cell: Cell, q: Array, J_all: Array, reference: Array) -> dict[str, NullSpace]:
    """The null space of every redundant arm by name.

    Where H has no minimum, h' alone stands for its Hessian: still a way downhill.

    Args:
        cell: The cell.
        q: Joint positions of all arms, Shape (T, m) [rad or m].
        J_all: Jacobians of all arms side by side, Shape (T, w, m).
        reference: Joint positions to stay near, Shape (T, m) [rad or m].
    """
    if "geometric_stiffness" not in cell.functions:
        return {}
    redundant = [robot for robot in cell.robots if is_redundant(cell, robot)]
    at, gradients, inverses, multipliers = {}, {}, {}, {}
    for robot in redundant:
        joints = cell.joint_slices[robot.name]
        at[robot.name] = stretched(robot, q[:, joints])
        gradients[robot.name] = at[robot.name].h - stretched(robot, reference[:, joints]).h
        inverses[robot.name] = np.linalg.pinv(J_all[:, :, joints], rcond=SINGULAR)
        multipliers[robot.name] = apply(inverses[robot.name].transpose(0, 2, 1), gradients[robot.name])
    stiffness = geometric_stiffness(cell, q, multipliers)
    spaces = {}
    for name, stretch in at.items():
        joints = cell.joint_slices[name]
        J = J_all[:, :, joints]
        basis = np.linalg.svd(J)[2][:, J.shape[1] :].transpose(0, 2, 1)
        slope = stretch.slope[:, :, None] * np.eye(J.shape[2])
        hessian = slope - stiffness[:, joints, joints]
        reduced = basis.transpose(0, 2, 1) @ hessian @ basis
        curvature = np.linalg.eigvalsh((reduced + reduced.transpose(0, 2, 1)) / 2)[:, 0]
        hessian = np.where((curvature > FOLD)[:, None, None], hessian, slope)
        spaces[name] = NullSpace(
            inverse=inverses[name],
            basis=basis,
            gradient=gradients[name],
            multiplier=multipliers[name],
            hessian=hessian,
            bend=stretch.bend,
            curvature=curvature,
        )
    return spaces


def change_along(cell: Cell, q: Array, dq: Array, spaces: dict[str, NullSpace]) -> dict[str, Array]:
    """What hessian q'' - JᵀF'' is, of every redundant arm, from the second derivative of h(q) - h(reference) = JᵀF.

    Args:
        cell: The cell.
        q: Joint positions of all arms, Shape (T, m) [rad or m].
        dq: Their velocities, Shape (T, m).
        spaces: From `null_spaces`.

    Returns:
        By name, each Shape (T, n).
    """
    if not spaces:
        return {}
    rates = {}
    for name, space in spaces.items():
        torque = apply(space.hessian, dq[:, cell.joint_slices[name]])
        rates[name] = apply(space.inverse.transpose(0, 2, 1), torque)
    F = {name: space.multiplier for name, space in spaces.items()}
    stiffness = geometric_stiffness(cell, q, rates)
    inputs = {"q": q, "dq": dq, "wrench": _stacked(cell, len(q), F)}
    rate = cell.functions("geometric_stiffness_rate", len(q), inputs)["geometric_stiffness_rate"]
    changes = {}
    for name, space in spaces.items():
        joints = cell.joint_slices[name]
        speed = dq[:, joints]
        changes[name] = rate[:, joints] + 2 * apply(stiffness[:, joints, joints], speed) - space.bend * speed**2
    return changes


def geometric_stiffness(cell: Cell, q: Array, wrenches: dict[str, Array]) -> Array:
    """∂(JᵀF)/∂q of all arms on the diagonal, Shape (T, m, m); arms that are not named have no wrench."""
    inputs = {"q": q, "wrench": _stacked(cell, len(q), wrenches)}
    return cell.functions("geometric_stiffness", len(q), inputs)["geometric_stiffness"]


def _stacked(cell: Cell, count: int, wrenches: dict[str, Array]) -> Array:
    nothing = np.zeros((count, len(cell.wrench_components)))
    return np.concatenate([wrenches.get(robot.name, nothing) for robot in cell.robots], axis=1)
