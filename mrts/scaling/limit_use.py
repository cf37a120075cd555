# SPDX-License-Identifier: MIT
"""How much of each limit a trajectory uses."""

from dataclasses import dataclass, replace

import numpy as np

from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits import cell_rows
from mrts.limits.rows import RowName
from mrts.limits.velocity_limits import velocity_limits
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory


@dataclass(frozen=True)
class LimitUse:
    """How much of its limits one row uses along a trajectory.

    Attributes:
        name: What the row limits.
        lower: Its lower limit, minus infinity where unbounded.
        upper: Its upper limit, infinity where unbounded.
        least: Its least value.
        largest: Its largest value.
        share: The largest share of a limit that is used; 1 is at the limit. Of a limit of zero, what 100 % is says
            `LimitRows.units`.
        time: When that is [s].
    """

    name: RowName
    lower: float
    upper: float
    least: float
    largest: float
    share: float
    time: float


def limit_uses(result: ScalingResult) -> list[LimitUse]:
    """All rows and velocities of a cell by falling share of the limit; empty if there is no trajectory.

    Args:
        result: The result.
    """
    done = result.trajectory
    if done is None:
        return []
    rows = cell_rows(result.cell)
    value = done.torque @ rows.torque_matrix.T + done.wrench @ rows.wrench_matrix.T
    used = []
    for limit, distance in ((rows.lower, value - rows.lower), (rows.upper, rows.upper - value)):
        size = np.where(limit == 0, rows.units(), np.abs(limit))
        bounded = np.isfinite(limit)
        share = np.full_like(value, -np.inf)
        share[:, bounded] = 1 - distance[:, bounded] / size[bounded]
        used.append(share)
    share = np.maximum(*used)
    at = np.argmax(share, axis=0)
    uses = [
        LimitUse(
            name,
            float(rows.lower[row]),
            float(rows.upper[row]),
            float(np.min(value[:, row])),
            float(np.max(value[:, row])),
            max(0.0, float(share[at[row], row])),
            float(done.time[at[row]]),
        )
        for row, name in enumerate(rows.names)
    ]
    uses += _velocity_uses(result.cell, result.motion, done)
    return sorted(uses, key=lambda use: -use.share)


def _velocity_uses(cell: Cell, motion: CoordinatedMotion, done: ScaledTrajectory) -> list[LimitUse]:
    """Sizes of velocities, enforced or not."""
    limits = velocity_limits(replace(cell, enforces_velocity_limits=True), motion)
    share = done.c * limits.share
    at = np.argmax(share, axis=0)
    uses = []
    for row, (name, limit) in enumerate(zip(limits.names, limits.limit.tolist(), strict=True)):
        least, largest = float(np.min(share[:, row])), float(share[at[row], row])
        uses.append(LimitUse(name, 0.0, limit, least * limit, largest * limit, largest, float(done.time[at[row]])))
    return uses
