# SPDX-License-Identifier: MIT
"""All equations of one sample as one CasADi function of its unknowns and of what all samples share."""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.layout.grasp_equations import ObjectSymbols, arm_poses, grasp_equations
from mrts.layout.limit_equations import LimitEquations, turned_wrenches


@dataclass(frozen=True)
class SampleEquations:
    """Equations and rows of a sample.

    Attributes:
        function: Of the sample's unknowns [q, q', q'', free wrenches], of the shared ones [layout, ln c²] and of what
            is given of it: first the equations, which are zero, then the rows of all limits in their units.
        unknowns: Number of the sample's unknowns.
        equations: Number of equations.
    """

    function: Any
    unknowns: int
    equations: int


def sample_equations(
    cell: Cell,
    functions: dict[str, Any],
    geometry: Any,
    layout: Any,
    limits: LimitEquations,
    loads: list[Array],
) -> SampleEquations:
    """Put them together.

    Args:
        cell: The cell that the search starts from.
        functions: Its functions for CasADi's virtual machine.
        geometry: Of the cell, in terms of the layout, Shape (g,).
        layout: Its symbols, Shape (P,).
        limits: The rows.
        loads: Load vectors, all of which must be carried, Shape (10,) each.
    """
    joints, rows = limits.by_velocity.shape[1], len(limits.rows.names)
    free = len(cell.wrench_components) * (len(cell.robots) - 1)
    q, dq, ddq = (ca.SX.sym(name, joints) for name in ("q", "dq", "ddq"))
    wrenches = [ca.SX.sym(f"F{index}", free) for index in range(len(loads))]
    log_c2, carried = ca.SX.sym("log_c2"), ObjectSymbols.fresh()
    speed, square, dry = (ca.SX.sym(name, size) for name, size in (("s", rows), ("e", rows), ("dry", joints)))
    c2, c = ca.exp(log_c2), ca.exp(log_c2 / 2)
    arms = arm_poses(geometry, len(cell.robots))
    equations = grasp_equations(cell, functions, (q, dq, ddq), carried, geometry)
    of_speed = (ca.DM(limits.by_velocity) @ dq + speed) * c + square * c2
    of_motors = _motor_torque(cell, dq, ddq, c) + dry
    values = []
    for number, (load, wrench) in enumerate(zip(loads, wrenches, strict=True)):
        form = functions["wrench_form"](
            q=q,
            dq=dq,
            ddq=ddq,
            object_rotation=carried.rotation,
            object_twist=carried.twist,
            object_acceleration=carried.acceleration,
            load=load,
            geometry=geometry,
        )
        x = ca.vertcat(wrench, c2)
        F = form["wrench_map"] @ x + form["wrench_offset"]
        torque = form["torque_map"] @ x + form["torque_offset"] + of_motors
        value = limits.values(torque, F, *turned_wrenches(cell, F, carried.rotation, arms), of_speed)
        moved = limits.rows.of_forces if number else np.ones(rows, dtype=bool)
        values.append(value[np.flatnonzero(moved).tolist()])
    unknowns = ca.vertcat(q, dq, ddq, *wrenches)
    held = ca.vertcat(*equations)
    function = ca.Function(
        "sample",
        [unknowns, ca.vertcat(layout, log_c2), ca.vertcat(carried.stacked, speed, square, dry)],
        ca.cse([ca.densify(ca.vertcat(held, *values))]),
    )
    return SampleEquations(function, unknowns.numel(), held.numel())


def _motor_torque(cell: Cell, dq: Any, ddq: Any, c: Any) -> Any:
    """Rotor inertia and viscous friction, Shape (m,) [N m or N]."""
    motors = [robot.motors for robot in cell.robots]
    armature, viscous = (np.concatenate([getattr(motor, name) for motor in motors]) for name in ("armature", "viscous"))
    return ca.DM(armature) * ddq * c**2 + ca.DM(viscous) * dq * c
