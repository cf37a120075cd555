# SPDX-License-Identifier: MIT
"""The last steps of every answer, whatever c² was chosen for: torques, what holds at both ends, warnings, checks."""

from dataclasses import replace

import numpy as np

from mrts.base.arrays import Array
from mrts.base.remark import Remark
from mrts.samples.reserve import TORQUES
from mrts.samples.sample_ranges import SampleRanges
from mrts.samples.torque_distribution import torque_weights
from mrts.scaling.holding_torques import holding_at_ends
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory

OVERRATED = "above-rated"
"""Code of the remark on torques that a motor does not bear for ever."""

NAMED = 3
"""Further joints that it names."""


def with_torques(
    result: ScalingResult,
    c2: float,
    samples: SampleRanges,
    solver: str,
    given: tuple[Array, Array] | None = None,
) -> ScalingResult:
    """A result with the torques of its rule at a chosen c², and with what is to be said of them.

    Args:
        result: A result; its cell has the load that is carried.
        c2: Chosen c².
        samples: The ranges of that load: they say whether it can be held still.
        solver: Name in the registry.
        given: Torques and wrenches that were distributed already, Shape (N, m) and (N, n w).

    Raises:
        SolverError: If no solver answers, or the torques overstep a limit.
    """
    cell, motion, rule = result.cell, result.motion, result.rule
    W = torque_weights(rule.weights, motion.q.shape[1])
    distribute = TORQUES[rule.distribute]
    if given is None:
        torque, wrench, fallbacks = distribute(cell, motion, rule.formulation, rule.sharing, solver, c2, W)
    else:
        torque, wrench, fallbacks = *given, 0
    holding, unheld = holding_at_ends(cell, motion, samples, rule.sharing, rule.formulation, W, solver, rule.distribute)
    done = ScaledTrajectory(cell, motion, c2, torque, wrench, holding)
    before = tuple(warning for warning in result.warnings if warning.code != OVERRATED)
    return replace(
        result,
        trajectory=done,
        fallbacks=result.fallbacks + fallbacks,
        warnings=tuple(dict.fromkeys(before + unheld + _overrated(done))),
    ).checked()


def _overrated(done: ScaledTrajectory) -> tuple[Remark, ...]:
    """What to say of joints whose motors bear their torque for a while only."""
    if not any(np.any(np.isfinite(robot.motors.rated)) for robot in done.cell.robots):
        return ()
    shares = {
        f"{robot.name}/{joint}": float(share)
        for robot, duty in zip(done.cell.robots, done.duty.values(), strict=True)
        for joint, share in zip(robot.joints, duty.rated_share, strict=True)
        if share > 1
    }
    if not shares:
        return ()
    worst, *others = sorted(shares, key=lambda joint: -shares[joint])
    more = f" and {len(others) - NAMED} more" if len(others) > NAMED else ""
    also = f"; above theirs too: {', '.join(others[:NAMED])}{more}" if others else ""
    text = (
        f"{worst}: its root mean square torque over the motion is {100 * shares[worst]:.0f} % of what its motor bears "
        f"for ever ('rated'{also}): repeated without a pause it overheats. Pause without the load, or carry "
        "less; to play the motion slower saves only what its accelerations take."
    )
    return (Remark(OVERRATED, text),)
