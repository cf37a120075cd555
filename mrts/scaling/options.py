# SPDX-License-Identifier: MIT
"""What is asked of a motion: the arguments that scaling, timing, rankings, sweeps and what-if share."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import Self

from mrts.base.arrays import Array, EqualByNumbers
from mrts.base.errors import InputError, as_array, check_type
from mrts.base.load_box import LoadBox
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits import Limit
from mrts.program.between_samples import BETWEEN, checked_tolerance
from mrts.program.formulation import DISTRIBUTIONS, DistributionName, FormulationName
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.rate_limits import RateLimits
from mrts.program.solvers import DEFAULT_SOLVER, check_solver
from mrts.program.torque_distribution import torque_weights


@dataclass(frozen=True, kw_only=True, eq=False)
class Options(EqualByNumbers):
    """What was asked of a motion, as `mrts.scale` documents its arguments.

    A saved result keeps neither `select`, as it has the c², nor `solver` and `between`.

    Attributes:
        select: Which c² is chosen; None takes the largest.
        sharing: A fixed distribution of the load; None leaves it to the quadratic program.
        formulation: Unknowns of the programs.
        weights: W of the quadratic program, as in `mrts.scale`.
        solver: Name in the registry.
        load: "nominal", "guaranteed", "possible" or "grid:N"; "auto" until it is checked.
        distribute: "least-torque" is the quadratic program alone, "reserve" keeps most of every limit free before it.
        between: Share of a limit by which it may be overstepped between the samples; None for the bare samples.
        rates: Limits of rates that are kept; None where torques may change as fast as they like.
    """

    select: float | None = None
    sharing: LoadSharing | None = None
    formulation: FormulationName = "wrench"
    weights: Array | float | None = None
    solver: str = DEFAULT_SOLVER
    load: str = "auto"
    distribute: DistributionName = "least-torque"
    between: float | None = BETWEEN
    rates: RateLimits | None = None

    def rows(self, cell: Cell, motion: CoordinatedMotion) -> MotionRows:
        """The limits of a cell along a motion, as the programs that are asked for take them."""
        return motion_rows(cell, motion, self.sharing, self.formulation, self.solver)

    def checked(self, cell: Cell) -> Self:
        """The same with what "auto" asks of the load of a cell.

        Raises:
            InputError: If one breaks a rule, or they do not go together.
        """
        check_type("select", self.select, float, int, NoneType)
        check_type("sharing", self.sharing, LoadSharing, NoneType)
        check_type("distribute", self.distribute, str)
        if self.distribute not in DISTRIBUTIONS:
            rule = f"must be {' or '.join(map(repr, DISTRIBUTIONS))}."
            raise InputError("distribute", rule, value=self.distribute)
        if self.distribute != "least-torque" and self.sharing is not None:
            rule = "a fixed distribution of the load leaves no torques to choose; leave one out."
            raise InputError("distribute", rule, value=self.distribute)
        check_type("formulation", self.formulation, str)
        check_solver(self.solver)
        load = self.load
        check_type("load", load, str)
        if load == "auto":
            load = "nominal" if cell.load_box is None else "guaranteed"
        elif load != "nominal":
            load_box(cell, load)
        if load == "possible" and self.select is not None:
            rule = (
                "what is possible leaves open which load it is, so no c² and no torques are chosen. Ask for the "
                "guaranteed range, or give the cell a known load."
            )
            raise InputError("select", rule, value=self.select)
        weights = self.weights
        if weights is not None:
            torque_weights(weights, cell)
            weights = as_array("weights", weights)  # torques may be distributed later, by what the weights are now
            weights.setflags(write=False)
        if self.rates is not None:
            if self.formulation != "wrench":
                rule = "with rates it must be 'wrench': torques are chosen for the whole motion."
                raise InputError("formulation", rule, value=self.formulation)
            if load == "possible":
                raise InputError("load", "what is possible leaves no torques whose rates could be kept.", value=load)
        return replace(self, load=load, weights=weights, between=checked_tolerance(self.between))


def limited_cell(cell: Cell, reserve: float | None, limits: Sequence[Limit] | None) -> Cell:
    """The cell with the reserve and the further limits that were asked for; None leaves its own.

    Raises:
        InputError: If the reserve is no share, or a limit no function.
    """
    cell = cell if reserve is None else cell.with_reserve(reserve)
    return cell if limits is None else replace(cell, limits=limits)  # type: ignore[arg-type]  # the cell makes a tuple of them


def load_box(cell: Cell, question: str) -> LoadBox:
    """What the load is known within; an InputError if the cell's load does not vary."""
    if cell.load_box is None:
        raise InputError(
            "load",
            "must be nominal: the cell says nothing of how its load varies. For another question add 'variation' under "
            "'object' in the cell file, such as 'variation: {mass: [0.5, 2.0]}'.",
            value=question,
        )
    return cell.load_box
