# SPDX-License-Identifier: MIT
"""A retimed motion with its torques, as a result of its own at c² = 1."""

from collections.abc import Sequence
from dataclasses import replace

from mrts.base.arrays import Array
from mrts.base.remark import Remark
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.scaling.options import Options
from mrts.scaling.result import ScalingResult
from mrts.scaling.torques import with_torques
from mrts.timing.retimed_motion import TimedPiece, retimed_motion


def played_result(
    cell: Cell,
    given: CoordinatedMotion,
    options: Options,
    pieces: Sequence[TimedPiece],
    what: str,
    *,
    warnings: tuple[Remark, ...],
    torques: tuple[Array, Array] | None = None,
) -> ScalingResult:
    """The retimed motion with the torques of the quadratic program (31) to (34), or with given ones.

    Its range of c², which only says what faster or slower would be, is found when it is read.

    Args:
        cell: The cell.
        given: The given motion.
        options: What was asked.
        pieces: Its path with the timing.
        what: The timing is, for people.
        warnings: What to know of cell and motion.
        torques: Torques and wrenches that were distributed already, Shape (N, m) and (N, n w).

    Raises:
        SolverError: If no solver answers, or the torques overstep a limit.
    """
    motion = retimed_motion(given, pieces)
    whole, duration = given.object.time[-1], motion.object.time[-1]
    played = ScalingResult(
        cell=cell,
        motion=motion,
        found=None,
        c2=1.0,
        trajectory=None,
        fallbacks=0,
        options=replace(options, load="nominal"),
        origin=f"{what} of a path that was given {whole:.4g} s: {duration:.4g} s",
        warnings=warnings,
    )
    return with_torques(played, torques)
