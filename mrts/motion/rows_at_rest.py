# SPDX-License-Identifier: MIT
"""Rows of a table that hold the cell still before and after the motion: where they are needed, and which they are."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array

HOLDING_STEP = 1e-3
"""A row that holds still lies this far from the motion [s], or as far as its two nearest samples where that is less."""

REST = 1e-9
"""Joint speeds below this share of the largest of the motion are rest, accelerations below it none: rounding."""

JOINT_STANDS = 1e-6
"""A joint that is never faster than this share of the fastest one stands: rounded numbers of a URDF move it by as much,
and its friction has no direction."""

ROUNDED = 0.01
"""Share by which the time of a row may be off: tables may carry few digits."""

LEAST = 2
"""Rows of a motion: both ends."""


def holding_step(time: Array) -> float:
    """How far from a motion of some times, Shape (N,), a row lies that holds still [s]."""
    return min(HOLDING_STEP, float(np.min(np.diff(time))))


def pushing_ends(dq: Array, ddq: Array) -> tuple[bool, bool]:
    """Whether a motion is at rest at its start, and at its end, but its joints, Shape (N, m), accelerate there.

    A controller that waits there, or stays there, would push with the torques of that acceleration.
    """
    (speed, fastest), (change, most) = ((of[[0, -1]].max(axis=1), of.max()) for of in (np.abs(dq), np.abs(ddq)))
    pushes = (speed <= REST * fastest) & (change > REST * most)
    return bool(pushes[0]), bool(pushes[1])


def moving_joints(dq: Array) -> NDArray[np.bool_]:
    """Which joints move at each sample, none that stands along the whole motion, as their velocities, Shape (N, m)."""
    speed = np.abs(dq)
    fastest = speed.max(axis=0)
    return np.asarray((speed > REST * fastest.max()) & (fastest > JOINT_STANDS * fastest.max()))


def moving_rows(time: Array, q: Array, dq: Array, ddq: Array) -> slice:
    """The rows of a table without those that hold still before and after the motion; parts not given are Shape (N, 0).

    Such a row is the first or the last, with no velocity and no acceleration, in exactly the position of the row next
    to it, from which the motion starts, or at which it ends, with an acceleration; where no accelerations are given, at
    rest and as far away as such a row is written.
    """
    first, last = 0, len(q)
    before, after = (
        not np.any(dq[row]) and not np.any(ddq[row]) and np.array_equal(q[row], q[beside])
        for row, beside in ((0, 1), (-1, -2))
    )
    if before and last - first > LEAST and _leads(time[::-1], dq[::-1], ddq[::-1]):
        first += 1
    if after and last - first > LEAST and _leads(time, dq, ddq):
        last -= 1
    return slice(first, last)


def _leads(time: Array, dq: Array, ddq: Array) -> bool:
    if ddq.shape[1]:
        return pushing_ends(dq[:-1], ddq[:-1])[1]
    steps = np.abs(np.diff(time))
    near = steps[-1] <= (1 + ROUNDED) * min(HOLDING_STEP, float(np.min(steps[1:-1], initial=np.inf)))
    return bool(near and np.max(np.abs(dq[-2]), initial=0.0) <= REST * np.max(np.abs(dq), initial=0.0))
