# SPDX-License-Identifier: MIT
"""The rows of all limits at one sample, for CasADi."""

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.cell.hands.contact import triple_axes
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.layout.grasp_equations import ArmPose
from mrts.limits import limit_rows
from mrts.limits.rows import LimitRows
from mrts.program.motor_terms import MotorTerms, motor_terms

SAME_ROW = 1e-9
"""Share of the largest entry by which a row may differ from what is linear in the joint velocities: rounding."""


@dataclass(frozen=True)
class LimitEquations:
    """Rows lower <= M_τ τ + M_F F + M_H H + (S q' + s) c + e c² <= upper at N samples, each divided by its unit.

    Attributes:
        rows: The rows as the cell keeps them, along the motion that the program starts from.
        by_velocity: S, Shape (r, m).
        speed: s, Shape (N, r).
        square: e, Shape (N, r).
        motors: What motors add to the torques along that motion; None where they are ideal.
        of_tip: Rows of contacts that turn with the tip, Shape (r,).
    """

    rows: LimitRows
    by_velocity: Array
    speed: Array
    square: Array
    motors: MotorTerms | None
    of_tip: NDArray[np.bool_]

    @classmethod
    def of(cls, cell: Cell, motion: CoordinatedMotion) -> "LimitEquations":
        """The rows of a cell; how they depend on the joints' velocities is read off at unit velocities.

        Args:
            cell: The cell.
            motion: Its motion.

        Raises:
            InputError: If a limit is not linear in them, or depends on something else that a layout changes.
        """
        rows = limit_rows(cell, motion)
        still, units = np.zeros_like(motion.dq), np.eye(motion.dq.shape[1])

        def columns(dq: Array, ddq: Array) -> tuple[Array, Array]:
            at = limit_rows(cell, replace(motion, dq=dq, ddq=ddq))
            nothing = np.zeros((len(dq), len(at.names)))
            return nothing if at.speed is None else at.speed, nothing if at.square is None else at.square

        speed, square = columns(still, still)
        by_velocity = np.stack([(columns(still + unit, still)[0] - speed)[0] for unit in units], axis=1)
        given = columns(motion.dq, motion.ddq)
        for name, is_, linear in (("ṙ", given[0], motion.dq @ by_velocity.T + speed), ("ṙ²", given[1], square)):
            wrong = np.max(np.abs(is_ - linear), axis=0) > SAME_ROW * np.max(np.abs(is_), initial=1.0)
            if np.any(wrong):
                raise InputError(
                    "limits",
                    f"its column of {name} is not linear in the joints' velocities, so the best layout cannot be "
                    "searched with it: mrts sweep can, which solves each layout by itself.",
                    key=str(rows.names[int(np.argmax(wrong))]),
                )
        tips = {f"{robot.name}/{of.name}" for robot in cell.robots for of in robot.contacts if of.frame == "tip"}
        of_tip = np.array([name.contact in tips for name in rows.names], dtype=bool)
        return cls(rows, by_velocity, speed, square, motor_terms(cell, motion), of_tip)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper limits in units, less what dry friction may take at turning points, Shape (N, r) each."""
        rows, motors = self.rows, self.motors
        margin = np.zeros((1, len(rows.names)))
        if motors is not None and motors.turning is not None:
            margin = motors.turning @ np.abs(rows.torque_matrix).T
        lower, upper = ((limit + side * margin) / rows.units() for side, limit in ((1, rows.lower), (-1, rows.upper)))
        return np.broadcast_to(lower, self.speed.shape), np.broadcast_to(upper, self.speed.shape)

    @property
    def columns(self) -> Array:
        """What the equations are given of each sample: s, e and dry friction, Shape (2 r + m, N)."""
        dry = np.zeros((len(self.speed), self.by_velocity.shape[1])) if self.motors is None else self.motors.dry
        return np.concatenate([self.speed, self.square, dry], axis=1).T

    def values(self, torque: Any, wrench: Any, turned: tuple[Any, Any], speed: Any) -> Any:
        """What the rows are, in units, Shape (r,).

        Args:
            torque: τ, Shape (m,).
            wrench: F in base axes, Shape (n w,).
            turned: F in object axes and in axes of the tips, as from `turned_wrenches`.
            speed: (S q' + s) c + e c², Shape (r,).
        """
        rows = self.rows
        value = ca.DM(rows.torque_matrix) @ torque + ca.DM(rows.wrench_matrix) @ wrench + speed
        if rows.object_matrix is not None:
            for wrenches, there in zip(turned, (~self.of_tip, self.of_tip), strict=True):
                value += ca.sparsify(ca.DM(rows.object_matrix * there[:, None])) @ wrenches
        return value / rows.units()


def turned_wrenches(cell: Cell, wrench: Any, R_object: Any, arms: list[ArmPose]) -> tuple[Any, Any]:
    """All wrenches in object axes, and in axes that turn with the tips and are the object's at the cell's grasps.

    Args:
        cell: The cell.
        wrench: In base axes, Shape (n w,).
        R_object: Rotation of the object, Shape (3, 3).
        arms: Poses of the arms.
    """
    axes = triple_axes(cell.wrench_components)
    in_object, in_tip = [], []
    for robot, arm, part in zip(cell.robots, arms, cell.wrench_slices.values(), strict=True):
        turn = (R_object.T @ arm.R_base)[axes, axes]
        back = (ca.DM(robot.T_object_tip.R) @ arm.R_tip.T)[axes, axes]
        triples = [turn @ triple for triple in ca.vertsplit(wrench[part], 3)]
        in_object += triples
        in_tip += [back @ triple for triple in triples]
    return ca.vertcat(*in_object), ca.vertcat(*in_tip)
