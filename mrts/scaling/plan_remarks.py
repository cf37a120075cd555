# SPDX-License-Identifier: MIT
"""What a user should know of a plan's torques: what motors do not bear, and limits that are reported only."""

from typing import TYPE_CHECKING

import numpy as np

from mrts.base.remark import Remark
from mrts.base.words import first_names
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.motion.rows_at_rest import pushing_ends
from mrts.scaling.limit_use import LimitUse, by_share, power_uses, rate_uses
from mrts.scaling.scaled_trajectory import ScaledTrajectory

if TYPE_CHECKING:
    from mrts.scaling.result import ScalingResult

EXCEEDS_RATED_TORQUE = "above-rated"
"""Code of the remark on torques that a motor does not bear for ever."""

EXCEEDS_POWER = "above-power"
"""Code of the remark on power above that of the motors, or of their supply: reported only."""

EXCEEDS_RATE_LIMIT = "rate-passed"
"""Code of the remark on rates that pass their limit, which nothing keeps."""

EXCEEDS_VELOCITY = "velocity-passed"
"""Code of the remark on velocities above limits that are not enforced."""

STEPS = "step-at-ends"
"""Code of the remark on torques that must jump where a motion starts or ends, whatever its speed."""

RATE_TOLERANCE = 1e-6
"""Share by which a rate may pass its limit before it is told: rounding, of differences of neighbouring samples."""

NAMED = 3
"""Further joints that it names."""


def plan_remarks(result: "ScalingResult") -> tuple[Remark, ...]:
    """All of the trajectory of a result; none without one."""
    done = result.trajectory
    if done is None:
        return ()
    return _unheld(done) + overload_remarks(done) + _fast_rates(result) + _fast_joints(result)


def _unheld(done: ScaledTrajectory) -> tuple[Remark, ...]:
    """Where a controller needs torques that hold the object still and there are none."""
    if done.holding is None:
        return ()
    motion = done.motion
    ends = zip(
        ("starts", "ends"), ("begin", "end"), pushing_ends(motion.dq, motion.ddq), done.holding.ends, strict=True
    )
    return tuple(
        Remark(
            "no-row-at-rest",
            f"the limits do not let the cell hold still where the motion {does}, so tables and bags {do} with the "
            "torques of the motion: a controller must not stay there.",
            0 if does == "starts" else motion.samples - 1,
        )
        for does, do, needed, held in ends
        if needed and not held
    )


def overload_remarks(done: ScaledTrajectory) -> tuple[Remark, ...]:
    """What motors do not bear for ever, and power above theirs."""
    return _overrated(done) + _above_power(done)


def _overrated(done: ScaledTrajectory) -> tuple[Remark, ...]:
    if not any(np.any(np.isfinite(robot.motors.rated)) for robot in done.cell.robots):
        return ()
    used = np.concatenate([duty.rated_share for duty in done.duty.values()]).tolist()
    shares = {joint: share for joint, share in zip(done.cell.joint_names, used, strict=True) if share > 1}
    if not shares:
        return ()
    worst, *others = sorted(shares, key=lambda joint: -shares[joint])
    also = f"; above theirs too: {first_names(others, NAMED)}" if others else ""
    text = (
        f"{worst}: its root mean square torque over the motion is {100 * shares[worst]:.0f} % of what its motor bears "
        f"for ever ('rated'{also}): repeated without a pause it overheats. Pause without the load, or carry "
        "less; to play the motion slower saves only what its accelerations take."
    )
    return (Remark(EXCEEDS_RATED_TORQUE, text),)


def _above_power(done: ScaledTrajectory) -> tuple[Remark, ...]:
    """Power is a product of torque and speed, so no linear row: the limits are reported against, and not kept."""
    passed = [use for use in by_share(power_uses(done)) if use.share > 1]
    if not passed:
        return ()
    worst, names = passed[0], ["/".join(filter(None, (use.name.robot, use.name.element))) for use in passed]
    also = f"; above theirs too: {first_names(names[1:], NAMED)}" if names[1:] else ""
    text = (
        f"{names[0]}: power reaches {worst.size:.4g} W at t = {worst.time:.4g} s, {100 * worst.share:.0f} % of its "
        f"limit of {worst.upper:.4g} W{also}. Power is reported only: a slower motion takes less."
    )
    return (Remark(EXCEEDS_POWER, text),)


def _fast_rates(result: "ScalingResult") -> tuple[Remark, ...]:
    if result.options.rates is not None:
        return _steps_at_ends(result.motion)
    advice = "--rates cell keeps them, at a speed that varies --profile smooth (in Python rates=True)."
    return _passing(rate_uses(result), EXCEEDS_RATE_LIMIT, f"Rates are reported only; {advice}")


def _fast_joints(result: "ScalingResult") -> tuple[Remark, ...]:
    if result.cell.enforces_velocity_limits:
        return ()
    uses = by_share(use for use in result.limit_uses if use.name.kind == "velocity")
    return _passing(uses, EXCEEDS_VELOCITY, "Velocity limits are not kept, as was asked.")


def _passing(uses: list[LimitUse], code: str, advice: str) -> tuple[Remark, ...]:
    """What is told of limits, by falling share, that are reported only."""
    passed = [use for use in uses if use.share > 1 + RATE_TOLERANCE]
    if not passed:
        return ()
    worst, *others = passed
    also = f"; {len(others)} more pass theirs" if others else ""
    text = (
        f"{worst.name} reaches {worst.size:.4g} {worst.name.unit} at t = {worst.time:.4g} s, "
        f"{100 * worst.share:.0f} % of its limit{also}. {advice}"
    )
    return (Remark(code, text),)


def _steps_at_ends(motion: CoordinatedMotion) -> tuple[Remark, ...]:
    first, last = pushing_ends(motion.dq, motion.ddq)
    if not (first or last):
        return ()
    where = " and ".join(word for word, pushes in (("starts", first), ("ends", last)) if pushes)
    text = (
        f"the motion {where} at rest but accelerates there, so torques jump from or to those that hold still, at every "
        "speed. The rates are kept in between; a profile that starts and ends without acceleration (quintic, or "
        "--profile smooth) has no such jump."
    )
    return (Remark(STEPS, text),)
