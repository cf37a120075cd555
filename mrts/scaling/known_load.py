# SPDX-License-Identifier: MIT
"""Torques for a load that has become known, at the c² that was chosen for the whole box."""

from dataclasses import replace
from functools import partial

from mrts.base.argument_types import check_type
from mrts.base.arrays import Array
from mrts.base.errors import InputError, SolverError
from mrts.program.solvers import DEFAULT_SOLVER, check_solver
from mrts.program.trajectory_programs import motion_ranges
from mrts.scaling.chosen_c2 import conflict_at
from mrts.scaling.range import common_range
from mrts.scaling.result import END_TOLERANCE, ScalingResult
from mrts.scaling.scale import SelectionError
from mrts.scaling.with_torques import with_torques


def torques_for_load(result: ScalingResult, load: Array, *, solver: str = DEFAULT_SOLVER) -> ScalingResult:
    """Eqs. (47), (48), (49): the quadratic program with a known load k, at the c² of a result.

    At a c² of the guaranteed range every load of the box has such torques; motion and duration stay as they are. Limits
    of rates that the result keeps are kept.

    Args:
        result: A result with a trajectory.
        load: Load vector, Shape (10,), as from `LoadBox.load_at` or of `LoadBox.draw`.
        solver: As in `scale`; the distribution follows the result's own rule.

    Returns:
        The same result with the torques of this load.

    Raises:
        InputError: If the result has no trajectory or an argument breaks a rule.
        SelectionError: If this load cannot be carried at that c²; its `result` holds the range that it admits.
        SolverError: If no solver answers.
    """
    check_type("result", result, ScalingResult)
    check_solver(solver)
    if result.trajectory is None:
        raise InputError("result", "has no trajectory: no c² was chosen.", value=result.status.value)
    cell, motion, c2 = result.cell.with_load(load), result.motion, result.trajectory.c2
    rule = result.rule
    own = common_range(partial(motion_ranges, cell, motion, rule.formulation, rule.sharing, solver, None))
    refused = replace(result, cell=cell, found=own, trajectory=None, load=None)
    if own.admitted(c2, END_TOLERANCE) is None and not (
        own.samples.several and conflict_at(cell, motion, rule, c2, (None,), solver) is None
    ):
        raise _refusal(refused, f"c² = {c2:g} does not suit this load: {refused.sentence()}")
    # what is overstepped between the samples is convex in the load: of a box the corners tell it
    excess = result.excess if result.load is not None and result.load.question == "guaranteed" else None
    carrying = replace(result, cell=cell, fallbacks=result.fallbacks + own.samples.fallbacks, excess=excess)
    try:
        return with_torques(carrying, c2, own.samples, solver)
    except SolverError as error:
        if result.rule.rates is None:
            raise
        text = f"c² = {c2:g} does not suit this load where rates are kept: {error}"
        raise _refusal(refused, text) from None


def _refusal(refused: ScalingResult, text: str) -> SelectionError:
    error = SelectionError(text)
    error.result = refused
    return error
