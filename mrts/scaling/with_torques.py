# SPDX-License-Identifier: MIT
"""The last steps of every answer, whatever c² was chosen for: torques, what holds at both ends, warnings, checks."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.remark import Remark
from mrts.motion.rows_at_rest import pushing_ends
from mrts.program.rate_limits import RateLimits
from mrts.program.reserve import TORQUES
from mrts.program.sample_ranges import SampleRanges
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.program.torque_distribution import torque_weights
from mrts.scaling.holding_torques import holding_at_ends
from mrts.scaling.limit_use import rate_uses
from mrts.scaling.result import DistributionRule, ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory

OVERRATED = "above-rated"
"""Code of the remark on torques that a motor does not bear for ever."""

HASTY = "rate-passed"
"""Code of the remark on rates that pass their limit, which nothing keeps."""

STEPS = "step-at-ends"
"""Code of the remark on torques that must jump where a motion starts or ends, whatever its speed."""

OF_TORQUES = (OVERRATED, HASTY, STEPS)
"""Codes of remarks that are found again with other torques."""

RATE_TOLERANCE = 1e-6
"""Share by which a rate may pass its limit before it is told: rounding, of differences of neighbouring samples."""

NAMED = 3
"""Further joints that it names."""


@dataclass(frozen=True)
class ChosenFactor:
    """A c² chosen in a range, whose torques are distributed when they are asked for.

    Attributes:
        bare: The result without a trajectory.
        c2: Chosen c²; None where no c² moves the object.
        solver: Name in the registry.
    """

    bare: ScalingResult
    c2: float | None
    solver: str = DEFAULT_SOLVER

    @property
    def duration(self) -> float | None:
        """Of the motion at this c² [s]; None without one."""
        return None if self.c2 is None else float(self.bare.motion.object.time[-1] / np.sqrt(self.c2))

    @cached_property
    def whole(self) -> ScalingResult:
        """The result with its torques, and with what is to be said of them.

        Raises:
            SolverError: If no solver answers, or the torques overstep a limit.
        """
        return self.bare if self.c2 is None else with_torques(self.bare, self.c2, self.bare.range.samples, self.solver)


def check_rates(rule: DistributionRule, question: str) -> None:
    """Check that a rule goes together with its limits of rates, if it has any.

    Args:
        rule: The rule.
        question: That is asked of the load.

    Raises:
        InputError: If it does not.
    """
    if rule.rates is None:
        return
    for name, value, only in (
        ("distribute", rule.distribute, "least-torque"),
        ("formulation", rule.formulation, "wrench"),
    ):
        if value != only:
            raise InputError(name, f"with rates it must be '{only}': torques are chosen for the whole motion.",
                             value=value)  # fmt: skip
    if question == "possible":
        raise InputError("load", "what is possible leaves no torques whose rates could be kept.", value=question)


def with_torques(
    result: ScalingResult,
    c2: float,
    samples: SampleRanges | None,
    solver: str,
    given: tuple[Array, Array] | None = None,
) -> ScalingResult:
    """A result with the torques of its rule at a chosen c², and with what is to be said of them.

    Args:
        result: A result; its cell has the load that is carried.
        c2: Chosen c².
        samples: The ranges of that load, which say whether it can be held still; None where they are not known.
        solver: Name in the registry.
        given: Torques and wrenches that were distributed already, Shape (N, m) and (N, n w).

    Raises:
        SolverError: If no solver answers, or the torques overstep a limit.
    """
    cell, motion, rule = result.cell, result.motion, result.rule
    W = torque_weights(rule.weights, cell)
    if given is not None:
        torque, wrench, fallbacks = *given, 0
    elif rule.rates is None:
        distribute = TORQUES[rule.distribute]
        torque, wrench, fallbacks = distribute(cell, motion, rule.formulation, rule.sharing, solver, c2, W)
    else:
        from mrts.program.constant_rates import torques_within_rates  # noqa: PLC0415 (scipy is not needed otherwise)

        torque, wrench, fallbacks = *torques_within_rates(cell, motion, rule.sharing, rule.rates, c2, W), 0
    holding, unheld = holding_at_ends(cell, motion, samples, rule.sharing, rule.formulation, W, solver, rule.distribute)
    done = ScaledTrajectory(cell, motion, c2, torque, wrench, holding)
    before = tuple(warning for warning in result.warnings if warning.code not in OF_TORQUES)
    return replace(
        result,
        trajectory=done,
        fallbacks=result.fallbacks + fallbacks,
        warnings=tuple(dict.fromkeys(before + unheld + _overrated(done) + _hasty(done, rule.rates))),
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


def _hasty(done: ScaledTrajectory, kept: RateLimits | None) -> tuple[Remark, ...]:
    """What to say of rates that are above their limits, at the samples or where the motion starts and ends."""
    if kept is not None:
        return _steps_at_ends(done)
    passed = [use for use in rate_uses(done, None) if use.share > 1 + RATE_TOLERANCE]
    if not passed:
        return ()
    worst, *others = passed
    also = f"; {len(others)} more pass theirs" if others else ""
    text = (
        f"{worst.name} reaches {worst.largest:.4g} {worst.name.unit} at t = {worst.time:.4g} s, "
        f"{100 * worst.share:.0f} % of its limit{also}. Rates are reported only; --rates keeps them, at a speed that "
        "varies --profile smooth (in Python rates=True)."
    )
    return (Remark(HASTY, text),)


def _steps_at_ends(done: ScaledTrajectory) -> tuple[Remark, ...]:
    """That a motion accelerates from standstill on, or until it stands."""
    first, last = pushing_ends(done.motion.dq, done.motion.ddq)
    if not (first or last):
        return ()
    where = " and ".join(word for word, pushes in (("starts", first), ("ends", last)) if pushes)
    text = (
        f"the motion {where} at rest but accelerates there, so torques jump from or to those that hold still, at every "
        "speed. The rates are kept in between; a profile that starts and ends without acceleration (quintic, or "
        "--profile smooth) has no such jump."
    )
    return (Remark(STEPS, text),)
