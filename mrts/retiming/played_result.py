# SPDX-License-Identifier: MIT
"""A retimed motion with its torques, as a result of its own at c² = 1."""

from collections.abc import Sequence

from mrts.base.arrays import Array
from mrts.retiming.retimed_motion import TimedPiece, retimed_motion
from mrts.samples.trajectory_programs import motion_ranges
from mrts.scaling.motion_remarks import lasting
from mrts.scaling.range import intersect
from mrts.scaling.result import ScalingResult
from mrts.scaling.with_torques import with_torques
from mrts.solvers import DEFAULT_SOLVER


def played_result(
    constant: ScalingResult, pieces: Sequence[TimedPiece], what: str, given: tuple[Array, Array] | None = None
) -> ScalingResult:
    """The retimed motion with the torques of the quadratic program (31) to (34), or with given ones.

    Args:
        constant: The given motion with its best constant factor.
        pieces: Its path with the timing.
        what: The timing is, for people.
        given: Torques and wrenches that were distributed already, Shape (N, m) and (N, n w).

    Raises:
        SolverError: If no solver answers, or the torques overstep a limit.
    """
    cell, motion, rule = constant.cell, retimed_motion(constant.motion, pieces), constant.rule
    found = intersect(motion_ranges(cell, motion, rule.formulation, rule.sharing, DEFAULT_SOLVER))
    whole, duration = constant.motion.object.time[-1], motion.object.time[-1]
    played = ScalingResult(
        cell=cell,
        motion=motion,
        range=found,
        trajectory=None,
        fallbacks=found.samples.fallbacks,
        load=None,
        rule=rule,
        origin=f"{what} of a path that was given {whole:.4g} s: {duration:.4g} s",
        warnings=lasting(constant.warnings),
    )
    return with_torques(played, 1.0, found.samples, DEFAULT_SOLVER, given)
