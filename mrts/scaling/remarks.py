# SPDX-License-Identifier: MIT
"""What a user should know of a given motion before trusting its range, and of a plan's torques before playing it."""

from itertools import compress

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import Remark
from mrts.base.words import first_names
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import moved_remarks
from mrts.limits.rows import RATES
from mrts.motion.object_courses import ProfiledPath
from mrts.motion.rows_at_rest import pushing_ends
from mrts.scaling.scaled_trajectory import LimitUse, ScaledTrajectory, by_share

ENDS_AT_REST = 0.05
"""Share of a motion's largest speed up to which its ends count as at rest: splines through tables leave that much."""

JUMP = 5.0
"""Times by which a step of velocity must exceed all of its neighbours: no smooth motion of enough samples does so."""

NEIGHBOURS = 4
"""Samples on either side that a step is compared with; those next to it may share in it."""

LEAST_STEP = 0.05
"""Share of the largest speed from which a step of velocity is one."""

NOISY = 0.15
"""Share of a joint's largest acceleration that is noise, from which it may change c²: by 1 % and more, soon by half."""

STILL = 1e-9
"""A joint that moves by less stands still [rad or m]: what is left of its velocity is rounding."""

FEWEST_SAMPLES = 21
"""With fewer, noise and jumps cannot be told from corners of the velocity."""

SIGNIFICANT = 0.05
"""Share of the largest acceleration of all joints from which that of a joint counts: of one at rest all is rounding."""

NORMAL_DIFFERENCE = 0.3186 * 70**0.5
"""Lower quartile of the sizes of fourth differences of normal variables of deviation 1: 70 = 1² + 4² + 6² + 4² + 1²."""

REMARKED = 1e-3
"""Share by which c²⁺ must be less between given samples than at them to be told: it shows in the digits printed."""

RATE_TOLERANCE = 1e-6
"""Share by which a rate may pass its limit before it is told: rounding, of differences of neighbouring samples."""

NAMED = 3
"""Further joints that it names."""

ENDS = ("starts", "ends")


def motion_remarks(
    cell: Cell,
    motion: CoordinatedMotion,
    played: CoordinatedMotion,
    also: tuple[Remark, ...] = (),
    *,
    constant: bool = False,
) -> tuple[Remark, ...]:
    """All remarks of a cell and its motion as they are given, but for what is taken for granted.

    Args:
        played: The same motion with the samples that were added; remarks name its samples.
        also: What else is to be said.
        constant: Whether it is played by one factor, and not at a speed that varies from rest to rest.
    """
    remarks = [remark for remark in (*cell.all_remarks, *motion.remarks) if remark.severity != "assumption"]
    if constant:
        remarks += _not_at_rest(cell, motion)
    remarks += _rough(cell, motion)
    if remarks and played is not motion:
        time = motion.object.time
        remarks = [*moved_remarks(tuple(remarks), time, np.setdiff1d(played.object.time, time))]
    return *remarks, *also


def _not_at_rest(cell: Cell, motion: CoordinatedMotion) -> list[Remark]:
    fastest, units = float(np.max(np.abs(motion.dq), initial=0.0)), _position_units(cell)
    remarks = []
    for what, sample in (("start", 0), ("end", motion.samples - 1)):
        joint = int(np.argmax(np.abs(motion.dq[sample])))
        speed = abs(float(motion.dq[sample, joint]))
        if speed > ENDS_AT_REST * fastest:
            text = (
                f"the motion does not {what} at rest: {cell.joint_names[joint]} moves at {speed:.3g} "
                f"{units[joint]}/s at t = {motion.object.time[sample]:.4g} s. From or to standstill the velocity would "
                "jump there, at every factor of speed. Give a motion that is at rest at both ends (a table of few "
                "rows: with its velocities), or make sure that the robots move already."
            )
            remarks.append(Remark("not-at-rest", text, sample))
    return remarks


def _rough(cell: Cell, motion: CoordinatedMotion) -> list[Remark]:
    if motion.samples < FEWEST_SAMPLES or np.max(np.ptp(motion.q, axis=0)) < STILL:
        return []
    names, units = cell.joint_names, _position_units(cell)
    jumps, noise = _velocity_jumps(motion), noise_share(motion.ddq)
    largest = np.max(np.abs(motion.ddq), axis=0)
    noise[largest < SIGNIFICANT * np.max(largest)] = 0.0
    joint = int(np.argmax(noise))
    if noise[joint] >= NOISY:
        text = (
            f"the acceleration of {names[joint]} goes up and down from sample to sample, and torques with it, as "
            "that of rounded or measured positions does when they are differentiated twice. Give more digits, smooth "
            "the table, or give fewer rows."
        )
        return [Remark("noise", text)]
    if not np.any(jumps > 0):
        return []
    place, joint = (int(index) for index in np.unravel_index(int(np.argmax(jumps)), jumps.shape))
    text = (
        f"the motion jumps at t = {motion.object.time[place + 1]:.4g} s (sample {place + 1}): the velocity of "
        f"{names[joint]} changes there by {jumps[place, joint]:.3g} {units[joint]}/s from one "
        f"sample to the next, more than {JUMP:g} times what it does around it. Check that row of the table."
    )
    return [Remark("jump", text, place + 1)]


def _velocity_jumps(motion: CoordinatedMotion) -> Array:
    """Steps of joint velocities at inner samples that no smooth motion takes, zero elsewhere, Shape (N - 2, m)."""
    step = np.abs(np.diff(np.diff(motion.q, axis=0) / np.diff(motion.object.time)[:, None], axis=0))
    least = LEAST_STEP * np.max(np.abs(motion.dq), initial=0.0)
    padded = np.pad(step, ((NEIGHBOURS, NEIGHBOURS), (0, 0)))
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBOURS + 1, axis=0)
    around = np.max(np.delete(windows, [NEIGHBOURS - 1, NEIGHBOURS, NEIGHBOURS + 1], axis=2), axis=2)
    return np.where((step > JUMP * around) & (step > least), step, 0.0)


def noise_share(values: Array) -> Array:
    """Standard deviation of what is noise, as a share of the largest value, Shape (k,).

    Fourth differences leave nothing of a smooth motion, and the lower quartile of their sizes nothing of few corners;
    those of every second sample, every fourth and so on count too, as there may be many between the rows of a table.

    Args:
        values: Shape (N, k), N at least `FEWEST_SAMPLES`.
    """
    size, stride = np.zeros(values.shape[1]), 1
    while len(values) >= FEWEST_SAMPLES * stride:
        differences = np.abs(np.diff(values[::stride], 4, axis=0))
        place = len(differences) // 4
        size = np.maximum(size, np.partition(differences, place, axis=0)[place])
        stride *= 2
    largest = np.max(np.abs(values), axis=0)
    return np.asarray(size / NORMAL_DIFFERENCE / np.where(largest > 0, largest, 1.0))


def interpolated(motion: CoordinatedMotion, lost: float, effect: str) -> tuple[Remark, ...]:
    """That an answer is set by what mrts itself makes of a table between its rows.

    Args:
        lost: Share of the answer at the given samples that limits take which are kept between them too.
        effect: What they make of it, such as "c²⁺ {} less".
    """
    if isinstance(motion.object.course, ProfiledPath) or lost <= REMARKED:
        return ()
    text = (
        "between the given samples the motion is the spline that mrts lays through them, known only as well as they "
        f"are: limits kept there too make {effect.format(f'{100 * lost:.2g} %')}. Where it matters, give more of them."
    )
    return (Remark("between-samples", text),)


def _position_units(cell: Cell) -> list[str]:
    return [unit for robot in cell.robots for unit in robot.position_units]


def plan_remarks(done: ScaledTrajectory, uses: list[LimitUse], *, rated: bool) -> tuple[Remark, ...]:
    """All of a trajectory, by how much of its limits it uses; whether rates are kept counts."""
    remarks = _pushing(done, rated=rated) + overload_remarks(done)
    if not rated:
        advice = "--rates cell keeps them, at a speed that varies --profile smooth (in Python rates=True)."
        rates = [use for use in uses if use.name.kind in RATES]
        remarks += _passing(rates, "rate-passed", f"Rates are reported only; {advice}")
    if not done.cell.enforces_velocity_limits:
        velocities = [use for use in uses if use.name.kind == "velocity"]
        remarks += _passing(velocities, "velocity-passed", "Velocity limits are not kept, as was asked.")
    return remarks


def _pushing(done: ScaledTrajectory, *, rated: bool) -> tuple[Remark, ...]:
    """What a controller must know of ends at which the motion rests but accelerates; whether rates are kept counts."""
    needed, remarks = pushing_ends(done.motion.dq, done.motion.ddq), tuple[Remark, ...]()
    held = needed if done.holding is None else done.holding.ends
    lost = [pushes and not holds for pushes, holds in zip(needed, held, strict=True)]
    if any(lost):
        text = (
            f"the limits do not let the cell hold still where the motion {' and '.join(compress(ENDS, lost))}, so "
            "tables and bags have the torques of the motion there: a controller must not stay there."
        )
        remarks += (Remark("no-row-at-rest", text, 0 if lost[0] else done.motion.samples - 1),)
    if rated and any(needed):
        text = (
            f"the motion {' and '.join(compress(ENDS, needed))} at rest but accelerates there, so torques jump from "
            "or to those that hold still, at every speed. The rates are kept in between; a profile that starts and "
            "ends without acceleration (quintic, or --profile smooth) has no such jump."
        )
        remarks += (Remark("step-at-ends", text),)
    return remarks


def overload_remarks(done: ScaledTrajectory) -> tuple[Remark, ...]:
    """What motors do not bear for ever, and power above theirs: no linear row, as a product of torque and speed."""
    advice = "Power is reported only: a slower motion takes less."
    return _overrated(done) + _passing(by_share(done.power_uses), "above-power", advice)


def _overrated(done: ScaledTrajectory) -> tuple[Remark, ...]:
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
    return (Remark("above-rated", text),)


def _passing(uses: list[LimitUse], code: str, advice: str) -> tuple[Remark, ...]:
    """What is told of limits, by falling share, that are reported only."""
    passed = [use for use in uses if use.share > 1 + RATE_TOLERANCE]
    if not passed:
        return ()
    worst, *others = passed
    also = f"; {len(others)} more pass theirs" if others else ""
    text = (
        f"{worst.name} reaches {max(-worst.least, worst.largest):.4g} {worst.name.unit} at t = {worst.time:.4g} s, "
        f"{100 * worst.share:.0f} % of its limit{also}. {advice}"
    )
    return (Remark(code, text),)
