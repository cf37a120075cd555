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
from mrts.layout.redundant_equations import preference, preference_along, redundant_joints


@dataclass(frozen=True)
class SharedSymbols:
    """What all samples share.

    Attributes:
        layout: Shape (P,).
        log_c2: ln c².
        reference: Joint positions at the start of the motion of all redundant arms, Shape (R,) [rad or m].
        multiplier: Multipliers of their grasps there, stacked.
    """

    layout: Any
    log_c2: Any
    reference: Any
    multiplier: Any

    @classmethod
    def fresh(cls, numbers: int, redundant: int, arms: int) -> "SharedSymbols":
        """Symbols.

        Args:
            numbers: P.
            redundant: R.
            arms: Size of the multipliers.
        """
        sizes = {"layout": numbers, "log_c2": 1, "reference": redundant, "multiplier": arms}
        return cls(*(ca.SX.sym(name, size) for name, size in sizes.items()))

    @property
    def stacked(self) -> Any:
        """All of it as one column."""
        return ca.vertcat(self.layout, self.log_c2, self.reference, self.multiplier)


@dataclass(frozen=True)
class SampleEquations:
    """Equations and rows of a sample.

    Attributes:
        function: Of the sample's unknowns [q, q', q'', free wrenches, multipliers of redundant arms and their two
            derivatives], of the shared ones and of what is given of it: first the equations, which are zero, then the
            rows of all limits in their units.
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
    shared: SharedSymbols,
    limits: LimitEquations,
    loads: tuple[Array, ...],
) -> SampleEquations:
    """Put them together.

    Args:
        cell: The cell that the search starts from.
        functions: CasADi's functions of the cell.
        geometry: Of the cell, in terms of the layout, Shape (g,).
        shared: What all samples share.
        limits: The rows.
        loads: Load vectors, all of which must be carried, Shape (10,) each.
    """
    symbols = _SampleSymbols.fresh(cell, shared, limits, len(loads))
    held = list(grasp_equations(cell, functions, symbols.position, symbols.carried, geometry))
    if redundant_joints(cell):
        nearest = preference(cell, functions, symbols.position[0], symbols.multiplier[0], shared.reference, geometry)
        held.append(preference_along(nearest, symbols.position, symbols.multiplier))
    values = _limit_values(cell, functions, geometry, limits, symbols, loads)
    equations = ca.vertcat(*held)
    function = ca.Function(
        "sample",
        [symbols.unknowns, shared.stacked, symbols.given],
        ca.cse([ca.densify(ca.vertcat(equations, *values))]),
    )
    return SampleEquations(function, symbols.unknowns.numel(), equations.numel())


@dataclass(frozen=True, kw_only=True)
class _SampleSymbols:
    """Unknowns of a sample, and what is given of it.

    Attributes:
        position: q, q' and q'' of all arms, Shape (m,) each.
        wrenches: Free wrenches for each load, Shape (w (n - 1),) each.
        multiplier: Multipliers of redundant arms and their two derivatives.
        carried: The object.
        speed: Columns s of the limits, Shape (r,).
        square: Columns e, Shape (r,).
        dry: Dry friction, Shape (m,) [N m or N].
        log_c2: ln c².
    """

    position: tuple[Any, Any, Any]
    wrenches: tuple[Any, ...]
    multiplier: tuple[Any, Any, Any]
    carried: ObjectSymbols
    speed: Any
    square: Any
    dry: Any
    log_c2: Any

    @classmethod
    def fresh(cls, cell: Cell, shared: SharedSymbols, limits: LimitEquations, loads: int) -> "_SampleSymbols":
        rows, joints = limits.by_velocity.shape
        free = len(cell.wrench_components) * (len(cell.robots) - 1)
        forces = shared.multiplier.numel()
        return cls(
            position=(ca.SX.sym("q", joints), ca.SX.sym("dq", joints), ca.SX.sym("ddq", joints)),
            wrenches=tuple(ca.SX.sym(f"F{index}", free) for index in range(loads)),
            multiplier=(ca.SX.sym("f", forces), ca.SX.sym("df", forces), ca.SX.sym("ddf", forces)),
            carried=ObjectSymbols.fresh(),
            speed=ca.SX.sym("s", rows),
            square=ca.SX.sym("e", rows),
            dry=ca.SX.sym("dry", joints),
            log_c2=shared.log_c2,
        )

    @property
    def unknowns(self) -> Any:
        return ca.vertcat(*self.position, *self.wrenches, *self.multiplier)

    @property
    def given(self) -> Any:
        return ca.vertcat(self.carried.stacked, self.speed, self.square, self.dry)


def _limit_values(
    cell: Cell,
    functions: dict[str, Any],
    geometry: Any,
    limits: LimitEquations,
    symbols: _SampleSymbols,
    loads: tuple[Array, ...],
) -> list[Any]:
    """The rows of all limits in their units for each load; those of the speed alone once."""
    q, dq, ddq = symbols.position
    c2, c = ca.exp(symbols.log_c2), ca.exp(symbols.log_c2 / 2)
    carried, arms = symbols.carried, arm_poses(geometry, len(cell.robots))
    of_speed = (ca.DM(limits.by_velocity) @ dq + symbols.speed) * c + symbols.square * c2
    of_motors = _motor_torque(cell, dq, ddq, c) + symbols.dry
    values: list[Any] = []
    for load, wrench in zip(loads, symbols.wrenches, strict=True):
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
        value = limits.values(torque, F, turned_wrenches(cell, F, carried.rotation, arms), of_speed)
        values.append(value[np.flatnonzero(limits.rows.of_forces).tolist()] if values else value)
    return values


def _motor_torque(cell: Cell, dq: Any, ddq: Any, c: Any) -> Any:
    """Rotor inertia and viscous friction, Shape (m,) [N m or N]."""
    motors = [robot.motors for robot in cell.robots]
    armature, viscous = (np.concatenate([getattr(motor, name) for motor in motors]) for name in ("armature", "viscous"))
    return ca.DM(armature) * ddq * c**2 + ca.DM(viscous) * dq * c
