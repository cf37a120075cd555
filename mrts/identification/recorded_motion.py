# SPDX-License-Identifier: MIT
"""What was recorded of one arm, smoothed without delay, and where the signs of its joints' speeds are known.

Positions and efforts go through one filter, a Butterworth low pass of second order run forwards and backwards: it is
flat far below its cutoff, where arms move, delays nothing, and forgets within a period of its cutoff. Effort must not
keep what positions have lost: filtered alike, both sides of an equation that is linear in them stay equal. Velocities
and accelerations are those of the quintic spline through the smoothed positions.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply, freeze
from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.motion.joint_recording import RecordedJoint

DEFAULT_CUTOFF = 20.0
"""Of the filter [Hz]: ten times what large arms move at, far below where counted positions have their noise."""

SLOW_SAMPLING = 10.0
"""Samples in a period of the default cutoff: it is lower than `DEFAULT_CUTOFF` where there would be fewer."""

FEWEST_SAMPLES = 5.0
"""Samples in a period of a cutoff that is asked for: with fewer the filter takes away next to nothing."""

ORDER = 2
"""Of the filter, run twice: with more it would ring."""

FORGOTTEN = 1.0
"""Periods of the cutoff after which the filter has forgotten a sample but for 1 %."""

ENDS = 4.0
"""Periods of the cutoff at both ends of a recording, where the filter has to guess what was before and after."""

FEWEST_BLOCKS = 20
"""Blocks of a recording: with fewer, nothing can be said of four numbers and how sure they are."""

SLOWEST = 0.01
"""Speeds below this are not known to be a motion [rad/s or m/s]: elastic arms creep where friction holds them."""

SLOW_SHARE = 0.05
"""Share of a joint's fastest speed below which its friction is not the one modelled: it sticks, and grows when slow."""

NOISE_MULTIPLE = 4.0
"""Speeds below this many times the noise of the speed may have either sign."""

UNEVEN = 1e-3
"""Share of a step by which times of even samples may be off: stamps are rounded."""

GAP = 1.5
"""Times the median step from which on samples are missing between two."""

LONGEST_GAP = 0.25
"""Periods of the cutoff between two samples that are still bridged: what happens in longer ones is not known."""

DEGREE = 5
"""Of the spline through smoothed positions."""

CHUNK = 4096
"""Samples whose mass matrices are held at once."""


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """What was recorded of one arm, smoothed: means of B blocks.

    A block is a period of the cutoff, beyond which the filter does not tie samples to each other.

    Attributes:
        cutoff: Of the filter [Hz].
        time: Shape (B,) [s] from 0.
        used: Which blocks count, as the sign of the velocity is known, as far back and ahead as the filter reaches,
            Shape (B, n).
        velocity: Shape (B, n) [rad/s or m/s].
        acceleration: Shape (B, n) [rad/s² or m/s²].
        sign: Sign of the velocity, filtered like the effort, Shape (B, n).
        effort: Shape (B, n) [N m or N].
        left_over: Effort without the torque of the rigid bodies, Shape (B, n) [N m or N].
        speed_noise: Standard deviation of what noise of the positions leaves in velocities, Shape (n,) [rad/s or m/s].
    """

    cutoff: float
    time: Array
    used: NDArray[np.bool_]
    velocity: Array
    acceleration: Array
    sign: Array
    effort: Array
    left_over: Array
    speed_noise: Array

    def __post_init__(self) -> None:
        freeze(self)


def smoothed_motion(
    cell: Cell, robot: Robot, path: Path, joints: list[RecordedJoint], cutoff: float | None
) -> RecordedMotion:
    """The recorded motion of one arm.

    Args:
        cell: The cell.
        robot: The arm.
        path: Of the recording, for messages.
        joints: What was recorded of its joints, base to tip.
        cutoff: Of the filter [Hz]; None takes `DEFAULT_CUTOFF`, or less where samples are too few.

    Raises:
        InputError: If the recording is too short, or the cutoff too high for it.
    """
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415 (slow to import)
    from scipy.ndimage import minimum_filter1d  # noqa: PLC0415 (likewise)
    from scipy.signal import butter, sosfiltfilt  # noqa: PLC0415 (likewise)

    start, end = max(joint.time[0] for joint in joints), min(joint.time[-1] for joint in joints)
    step = max(_step(joint.time) for joint in joints)
    rate = 1 / step
    if cutoff is None:
        cutoff = min(DEFAULT_CUTOFF, rate / SLOW_SAMPLING)
    elif cutoff > rate / FEWEST_SAMPLES:
        rule = f"must be at most {rate / FEWEST_SAMPLES:.4g} Hz: the recording has {rate:.4g} samples a second."
        raise InputError("cutoff", rule, value=cutoff)
    count = int(np.floor((end - start) / step * (1 + UNEVEN))) + 1
    if count < (FEWEST_BLOCKS + 2 * ENDS) * round(rate / cutoff):
        least = (FEWEST_BLOCKS + 2 * ENDS) / cutoff
        raise InputError(
            path,
            f"holds all joints of robot '{robot.name}' for {max(end - start, 0.0):.3g} s; the filter of {cutoff:.4g} Hz"
            f" needs at least {least:.3g} s, a good identification 20 s or more.",
        )
    time = start + step * np.arange(count)
    joints = [
        replace(joint, position=np.unwrap(joint.position)) if unit == "rad" else joint  # encoders leap from π to -π
        for joint, unit in zip(joints, robot.position_units, strict=True)
    ]
    position, effort = np.empty((2, count, len(joints)))
    for place, joint in enumerate(joints):
        within = np.clip(time, joint.time[0], joint.time[-1])
        position[:, place] = make_interp_spline(joint.time, joint.position, k=3)(within)
        effort[:, place] = np.interp(within, joint.time, joint.effort)
    low_pass = butter(ORDER, cutoff, fs=rate, output="sos")
    q = sosfiltfilt(low_pass, position, axis=0)
    spline = make_interp_spline(time - start, q, k=DEGREE)
    dq, ddq = (np.asarray(spline(time - start, order), dtype=np.float64) for order in (1, 2))
    # 2π f_c √(2 f_c / 3 f_s) times white noise of the positions
    speed_noise = 2 * np.pi * cutoff * np.sqrt(2 * cutoff / (3 * rate)) * np.std(position - q, axis=0)
    fastest = np.max(np.abs(dq), axis=0)
    sure = np.abs(dq) > np.maximum(np.maximum(SLOW_SHARE * fastest, NOISE_MULTIPLE * speed_noise), SLOWEST)
    for place, recorded in enumerate(joint.time for joint in joints):
        after = np.clip(np.searchsorted(recorded, time), 1, len(recorded) - 1)
        sure[:, place] &= recorded[after] - recorded[after - 1] <= LONGEST_GAP / cutoff
    ends, reach = (int(np.ceil(periods * rate / cutoff)) for periods in (ENDS, FORGOTTEN))
    sure[:ends], sure[-ends:] = False, False
    known = minimum_filter1d(sure.astype(np.float64), 2 * reach + 1, axis=0, mode="nearest")
    sign, effort = (sosfiltfilt(low_pass, part, axis=0) for part in (np.sign(dq), effort))
    left_over = effort - _rigid_torque(cell, robot, q, dq, ddq)
    block = round(rate / cutoff)
    whole = count // block * block
    at, surely, velocity, acceleration, sign, effort, left_over = (
        part[:whole].reshape(-1, block, *part.shape[1:]).mean(axis=1)
        for part in (time - start, known, dq, ddq, sign, effort, left_over)
    )
    return RecordedMotion(cutoff, at, surely == 1, velocity, acceleration, sign, effort, left_over, speed_noise)


def _rigid_torque(cell: Cell, robot: Robot, q: Array, dq: Array, ddq: Array) -> Array:
    """Torque of the links alone along a motion, the other arms at rest, Shape (N, n) [N m or N]."""
    part, parts = cell.joint_slices[robot.name], []
    for start in range(0, len(q), CHUNK):
        some = slice(start, start + CHUNK)
        count = len(q[some])
        every, moving = np.tile(cell.posture, (count, 1)), np.zeros((count, len(cell.posture)))
        every[:, part], moving[:, part] = q[some], dq[some]
        of = cell.functions("dynamics", count, {"q": every, "dq": moving})
        torque = apply(of["mass_matrix"][:, part, part], ddq[some])
        parts.append(torque + of["coriolis_torque"][:, part] + of["gravity_torque"][:, part])
    return np.concatenate(parts)


def _step(time: Array) -> float:
    steps = np.diff(time)
    return float(np.mean(steps[steps <= GAP * np.median(steps)]))
