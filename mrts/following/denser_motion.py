# SPDX-License-Identifier: MIT
"""A motion of the whole cell between its samples: one way to ask any motion for more of them.

The object is where its motion says, if that is known at all times: a geodesic, a path through waypoints, the splines of
a table of poses. The joints are on the splines of their table, or on polynomials through their samples: in time, along
the path where a profile's acceleration jumps. Where these miss the grasps, the joints are moved onto them, which is
the inverse kinematics of the same branch. An object that is known at its samples only is where the hands carry it, and
accelerations that were given are not exceeded between two.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, changed
from mrts.base.errors import MotionError, Remark
from mrts.cell.cell import Cell
from mrts.following.coordinate import TIGHT, holds, mean_object
from mrts.following.coordinated_motion import CoordinatedMotion, carried_by_each
from mrts.following.tracking import joints_on_grasps
from mrts.kernel.tracking import PATH
from mrts.motion.object_courses import CORNER_TOLERANCE, CORNERS, ProfiledPath
from mrts.motion.object_motion import ObjectMotion

HERMITE = np.array([[1, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]])
"""Cubic polynomials on [0, 1] by value and slope at both ends; coefficients by rising power."""

POLYNOMIALS = np.zeros((5, 3, 4))
"""Coefficients, by rising power, of their integrals from 0, of themselves and of their slopes."""

for power, coefficients in enumerate(HERMITE.T):
    POLYNOMIALS[power + 1, 0], POLYNOMIALS[power, 1] = coefficients / (power + 1), coefficients
    POLYNOMIALS[power - 1, 2] += power * coefficients

SAME_COURSE = 1e-9
"""How far a course may be from the samples [m and per s, of the largest]: further, it is that of another motion."""


def between_samples(cell: Cell, motion: CoordinatedMotion, time: Array, *, of_path: bool = False) -> CoordinatedMotion:
    """The motion at some times between its samples, and at both of its ends.

    Args:
        time: Shape (k,) [s], strictly increasing, inside the motion.
        of_path: Whether the accelerations are those of the velocities in between, so that a segment that is divided
            stays the same curve; else those of a motion whose object is known at its samples only lie between those
            of the samples, as they may jump.

    Returns:
        k + 2 samples, of which the first and the last are those of the motion.

    Raises:
        MotionError: If the arms cannot hold the object there.
    """
    given, ours = motion.object, (motion.q, motion.dq, motion.ddq)
    at = np.concatenate([given.time[:1], time, given.time[-1:]])
    known = _on_course(given, at)
    inside = velocity_polynomials(given.time, ours, time) if motion.course is None else motion.course(time)
    if motion.course is None and known is None and not of_path:
        # accelerations that were given may jump, and lie between those of the samples
        inside = (*inside[:2], np.column_stack([np.interp(time, given.time, column) for column in motion.ddq.T]))
    elif motion.course is None and isinstance(given.course, ProfiledPath) and given.course.profile in CORNERS:
        _across_corners(given.course, given.time, ours, time, inside)
    q, dq, ddq = (np.concatenate([of[:1], there, of[-1:]]) for of, there in zip(ours, inside, strict=True))
    travel = _travel(motion, dq, [0, -1])
    carried = [] if known else carried_by_each(cell, at, q, dq, ddq)
    target = known or carried[0]
    rough = CoordinatedMotion(target, q, dq, ddq, travel=travel, closed=motion.closed, checked=False)
    if not motion.closed or len(carried) == 1 or all(holds(cell, rough, TIGHT)):
        return rough  # one hand carries the object wherever it is; near singularities, rounding would be made large
    target = known or mean_object(carried)
    try:
        q, dq, ddq = joints_on_grasps(cell, target, q, dq, ddq)
    except MotionError as error:
        raise MotionError(f"between the samples, {error} Or look at the samples alone (--between off).") from None
    return CoordinatedMotion(target, q, dq, ddq, travel=travel, checked=False)


def denser(motion: CoordinatedMotion, more: CoordinatedMotion, chosen: NDArray[np.intp]) -> CoordinatedMotion:
    """A motion with some further samples, by indices of Shape (k,); its own stay exactly as they are."""
    ours, theirs = motion.object, more.object
    order = np.argsort(np.concatenate([ours.time, theirs.time[chosen]]), kind="stable")

    def merged(given: Array, added: Array) -> Array:
        return np.concatenate([given, added[chosen]]).take(order, axis=0)

    parts: dict[str, Any] = {name: merged(getattr(ours, name), getattr(theirs, name)) for name in PATH}
    told, remarks = (moved_remarks(of.remarks, ours.time, theirs.time[chosen]) for of in (ours, motion))
    carried = replace(ours, **parts, remarks=told, checked=False)
    q, dq, ddq = (merged(getattr(motion, name), getattr(more, name)) for name in ("q", "dq", "ddq"))
    travel = _travel(motion, dq, (order < motion.samples).nonzero()[0])
    return changed(motion, object=carried, q=q, dq=dq, ddq=ddq, remarks=remarks, travel=travel)


def _travel(motion: CoordinatedMotion, dq: Array, own: Any) -> Array | None:
    if motion.travel is None:
        return None
    signs = np.stack([np.sign(dq), np.sign(dq)])
    signs[:, own] = motion.travel if len(own) == motion.samples else motion.travel[:, own]
    return signs


def moved_remarks(remarks: tuple[Remark, ...], time: Array, added: Array) -> tuple[Remark, ...]:
    """Remarks that name the same samples as before some were added, by their times and those of these [s]."""

    def place(sample: int) -> int:
        return sample + int(np.count_nonzero(added < time[sample]))

    return tuple(one if one.sample is None else replace(one, sample=place(one.sample)) for one in remarks)


def velocity_polynomials(known: Array, joints: tuple[Array, Array, Array], at: Array) -> tuple[Array, Array, Array]:
    """Joint motion between N samples: velocities on cubic polynomials through those and the accelerations there.

    Positions are their integrals; by what these miss the next sample, rounding in tables, they are moved in proportion.
    Positions, velocities and accelerations are Shape (N, m), and (k, m) at k times between the first and the last.
    """
    q, dq, ddq = joints
    start = (known.searchsorted(at, side="right") - 1).clip(0, len(known) - 2)
    end = start + 1
    step = (known[end] - known[start])[:, None]
    u = (at - known[start]) / step[:, 0]
    ends = np.stack([dq[start], step * ddq[start], dq[end], step * ddq[end]], axis=1)
    way, rate, change = (polynomial_weights(u) @ ends).swapaxes(0, 1)
    missed = q[end] - q[start] - step * (WHOLE_WAY @ ends)
    return q[start] + step * way + u[:, None] * missed, rate, change / step


def polynomial_weights(u: Array) -> Array:
    """What [q'_0, h q''_0, q'_1, h q''_1] of a segment of length h weigh at places u in it, Shape (k,), in [0, 1].

    Of its way / h, q' and h q'': Shape (k, 3, 4).
    """
    weights: Array = np.tensordot(np.vander(u, len(POLYNOMIALS), increasing=True), POLYNOMIALS, 1)
    return weights


WHOLE_WAY = polynomial_weights(np.ones(1))[0, 0]
"""What they weigh in the way over a whole segment."""


def _across_corners(
    course: ProfiledPath,
    known: Array,
    joints: tuple[Array, Array, Array],
    at: Array,
    inside: tuple[Array, Array, Array],
) -> None:
    """Put joints in gaps at a corner of the profile on polynomials in the share of the path, smooth where s'' jumps."""
    u, end = known / course.duration, np.searchsorted(known, at, side="right")
    corners = np.array(CORNERS[course.profile])
    moving = (end > 1) & (end < len(known) - 1)
    end = np.minimum(end, len(known) - 1)
    reached = (u[end - 1, None] <= corners + CORNER_TOLERANCE) & (corners - CORNER_TOLERANCE <= u[end, None])
    near = (moving & reached.any(axis=1)).nonzero()[0]
    if not len(near):
        return
    q, dq, ddq = (of[1:-1] for of in joints)
    s, ds, dds = (of[1:-1, None] for of in course.shares(known))
    along = dq / ds, (ddq - dq / ds * dds) / ds**2
    there, rate, change = course.shares(at[near])
    way, slope, bend = velocity_polynomials(s[:, 0], (q, *along), there)
    rate, change = rate[:, None], change[:, None]
    for of, exact in zip(inside, (way, slope * rate, bend * rate**2 + slope * change), strict=True):
        of[near] = exact


def _on_course(given: ObjectMotion, time: Array) -> ObjectMotion | None:
    if given.course is None:
        return None
    middle = len(given.time) // 2
    own = np.array([0, middle, -1])
    found, parts = given.course(np.concatenate([given.time[own], time])), list[Array]()
    for there, known in zip(found, (given.position, given.rotation, given.twist, given.acceleration), strict=True):
        if np.abs(there[:3] - known[own]).max() > SAME_COURSE * max(1.0, float(np.abs(known).max())):
            return None
        parts.append(there[3:])
    return ObjectMotion(time, *parts, checked=False)
