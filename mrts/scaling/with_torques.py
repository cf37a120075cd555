# SPDX-License-Identifier: MIT
"""The last steps of every answer, whatever c² was chosen for: torques, what holds at both ends, warnings, checks."""

from dataclasses import replace

from mrts.samples.reserve import TORQUES
from mrts.samples.sample_ranges import SampleRanges
from mrts.samples.torque_distribution import torque_weights
from mrts.scaling.holding_torques import holding_at_ends
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory


def with_torques(result: ScalingResult, c2: float, samples: SampleRanges, solver: str) -> ScalingResult:
    """A result with the torques of its rule at a chosen c², and with what is to be said of them.

    Args:
        result: A result; its cell has the load that is carried.
        c2: Chosen c².
        samples: The ranges of that load: they say whether it can be held still.
        solver: Name in the registry.

    Raises:
        SolverError: If no solver answers, or the torques overstep a limit.
    """
    cell, motion, rule = result.cell, result.motion, result.rule
    W = torque_weights(rule.weights, motion.q.shape[1])
    distribute = TORQUES[rule.distribute]
    torque, wrench, fallbacks = distribute(cell, motion, rule.formulation, rule.sharing, solver, c2, W)
    holding, unheld = holding_at_ends(cell, motion, samples, rule.sharing, rule.formulation, W, solver, rule.distribute)
    return replace(
        result,
        trajectory=ScaledTrajectory(cell, motion, c2, torque, wrench, holding),
        fallbacks=result.fallbacks + fallbacks,
        warnings=tuple(dict.fromkeys(result.warnings + unheld)),
    ).checked()
