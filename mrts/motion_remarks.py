# SPDX-License-Identifier: MIT
"""What a user should know of a given motion before trusting the range that it has."""

import numpy as np

from mrts.cell import Cell
from mrts.coordinated_motion import CoordinatedMotion
from mrts.remark import Remark
from mrts.rigid_transform import Array
from mrts.scaling_range import RangeEnd, ScalingRange

REST = 0.02
"""Share of a motion's largest speed up to which its ends count as at rest: splines through tables leave that much."""

JUMP = 5.0
"""Times by which a step of velocity must exceed all of its neighbours: no smooth motion of enough samples does so."""

NEIGHBOURS = 4
"""Samples on either side that a step is compared with; those next to it may share in it."""

LEAST_STEP = 0.05
"""Share of the largest speed from which a step of velocity is one."""

NOISE = 0.1
"""Share of a joint's largest acceleration that is noise, from which noise and not the motion sets the range."""

SAMPLES_OF_NOISE = 21
"""Fewest samples in which noise can be told from corners of the velocity."""

SIGNIFICANT = 0.05
"""Share of the torque limits, of the largest such share, that the accelerations of a joint must take to count."""

FAST = 10.0
"""Factor of speed above which something is probably missing."""

OF_CONSTANT_FACTOR = ("not-at-rest", "factor-above-10")
"""Codes of remarks that tell nothing where the speed varies along the path."""


def motion_remarks(cell: Cell, motion: CoordinatedMotion, found: ScalingRange) -> tuple[Remark, ...]:
    """All remarks of a cell, its motion and the range that was found, in this order.

    Args:
        cell: The cell.
        motion: Its motion, as given.
        found: The range of c².
    """
    remarks = [*cell.remarks, *motion.remarks, *_not_at_rest(cell, motion), *_jump(cell, motion)]
    if found.status.admits_motion and found.upper is not None and found.upper.time is not None:
        if not any(remark.code == "jump" for remark in remarks):
            remarks += _noise(cell, motion, found.upper)
        remarks += _fast(found.upper)
    return tuple(remarks)


def _not_at_rest(cell: Cell, motion: CoordinatedMotion) -> list[Remark]:
    """Ends at which some joint moves."""
    largest = np.max(np.abs(motion.dq), axis=0)
    moving = np.flatnonzero(largest > 0)
    names = _joint_names(cell)
    remarks = []
    for what, sample, why in (
        ("start", 0, "from standstill the velocity would jump there"),
        ("end", motion.samples - 1, "the velocity would jump to zero there"),
    ):
        share = np.abs(motion.dq[sample, moving]) / np.max(largest, initial=0.0) if moving.size else np.zeros(1)
        joint = int(np.argmax(share))
        if share[joint] > REST:
            speed = abs(float(motion.dq[sample, moving[joint]]))
            text = (
                f"the motion does not {what} at rest: {names[moving[joint]]} moves at {speed:.3g} "
                f"{_unit(cell, moving[joint])}/s at t = {motion.object.time[sample]:.4g} s, and at every factor of speed "
                f"{why}. Give a motion that is at rest at both ends, or make sure that the robots move already."
            )
            remarks.append(Remark("not-at-rest", text, sample))
    return remarks


def _jump(cell: Cell, motion: CoordinatedMotion) -> list[Remark]:
    """The largest step of velocity between two rows that is no part of a smooth motion."""
    time = motion.object.time
    velocity = np.diff(motion.q, axis=0) / np.diff(time)[:, None]
    step = np.abs(np.diff(velocity, axis=0))
    if len(step) < 2 * NEIGHBOURS + 1:
        return []
    around = np.zeros_like(step)
    for distance in range(2, NEIGHBOURS + 1):
        around[distance:] = np.maximum(around[distance:], step[:-distance])
        around[:-distance] = np.maximum(around[:-distance], step[distance:])
    size = step / np.max(np.abs(motion.dq), initial=np.finfo(float).tiny)
    sudden = np.where((step > JUMP * around) & (size > LEAST_STEP), size, 0.0)
    sample, joint = (int(place) for place in np.unravel_index(int(np.argmax(sudden)), step.shape))
    if sudden[sample, joint] == 0:
        return []
    text = (
        f"the motion jumps at t = {time[sample + 1]:.4g} s (sample {sample + 1}): the velocity of "
        f"{_joint_names(cell)[joint]} changes there by {step[sample, joint]:.3g} {_unit(cell, joint)}/s from one sample "
        f"to the next, more than {JUMP:g} times what it does around it. Check that row of the table and its neighbours."
    )
    return [Remark("jump", text, sample + 1)]


def _noise(cell: Cell, motion: CoordinatedMotion, end: RangeEnd) -> list[Remark]:
    """Accelerations that change from sample to sample like noise, where they set the upper end."""
    if motion.samples < SAMPLES_OF_NOISE or all(row.name.kind == "velocity" for row in end.rows):
        return []
    share = noise_share(motion.ddq)
    largest = np.max(np.abs(motion.ddq), axis=0)
    joint = int(np.argmax(np.where(largest >= SIGNIFICANT * np.max(largest), share, 0.0)))
    if share[joint] < NOISE:
        return []
    text = (
        f"noise sets the range of c²: about {100 * min(share[joint], 1.0):.2g} % of the acceleration of "
        f"{_joint_names(cell)[joint]} changes its sign from sample to sample, as rounded or measured positions do when "
        "they are differentiated twice. Give more digits, smooth the table, or give fewer rows and 'samples'."
    )
    return [Remark("noise", text, end.sample)]


def noise_share(values: Array) -> Array:
    """Standard deviation of what is noise in evenly taken samples, as a share of the largest value, Shape (k,).

    Fourth differences leave nothing of a smooth motion, and the lower quartile of their sizes nothing of few corners.

    Args:
        values: Shape (N, k).
    """
    differences = np.abs(np.diff(values, 4, axis=0)) / np.sqrt(70)  # 1² + 4² + 6² + 4² + 1²
    deviation = np.quantile(differences, 0.25, axis=0) / 0.3186  # that quantile of a standard normal's size
    largest = np.max(np.abs(values), axis=0)
    return np.asarray(deviation / np.where(largest > 0, largest, 1.0))


def _fast(end: RangeEnd) -> list[Remark]:
    factor = float(np.sqrt(max(end.c2, 0.0)))
    if factor <= FAST:
        return []
    text = (
        f"the motion may be played {factor:.3g} times as fast as given, more than {FAST:g} times: probably its "
        "duration or a unit is wrong, or limits are missing (velocity limits, contact wrenches)."
    )
    return [Remark("factor-above-10", text)]


def _joint_names(cell: Cell) -> list[str]:
    return [f"{robot.name}/{joint}" for robot in cell.robots for joint in robot.joints]


def _unit(cell: Cell, joint: int) -> str:
    kinds = [kind for robot in cell.robots for kind in robot.joint_types]
    return "m" if kinds[joint] == "prismatic" else "rad"
