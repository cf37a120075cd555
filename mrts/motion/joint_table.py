# SPDX-License-Identifier: MIT
"""Motion of joints by name, as tables and bags give it: with velocities and accelerations, or differentiated."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Remark, is_number
from mrts.motion.object_courses import smoothing_remark
from mrts.motion.object_motion import check_derivatives, noise_allowed
from mrts.motion.rounded_samples import Spline, joined, smoothing_splines, splines_through
from mrts.motion.rows_at_rest import moving_rows

UNTIMED = "untimed"
"""Code of the remark on a path of joints without times."""

NO_SPEED = (
    "has no times, so there is no speed to scale: ask for a timing (--profile optimal or smooth, in Python "
    "mrts.retime), or give a column 't' in s."
)
"""What is said where such a path is asked for a constant factor."""

PER_WAYPOINT = 4
"""Samples on a path from waypoint to waypoint, at least: a cubic spline bends once in each."""

LEAST_SAMPLES = 101
"""Of a path through waypoints."""

FEWEST_SMOOTHED = 21
"""Rows: of fewer, noise cannot be told from motion."""

LARGEST_SMOOTHING = 0.1
"""[rad, m]; further from its rows it is another motion."""


@dataclass(frozen=True, repr=False, eq=False)
class JointCourse:
    """What a table makes of m joints between its rows.

    Attributes:
        position: Splines of their positions [rad or m].
        rate: Splines of velocities that were given.
    """

    position: Spline
    rate: Spline | None = None

    def __call__(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities and accelerations at some times, Shape (k,) [s], each Shape (k, m)."""
        rate, order = (self.position, 1) if self.rate is None else (self.rate, 0)
        values = self.position(time), rate(time, order), rate(time, order + 1)
        q, dq, ddq = (np.asarray(of, dtype=np.float64) for of in values)
        return q, dq, ddq


JointRows = tuple[Array, tuple[Array, Array, Array], JointCourse | None, tuple[Remark, ...]]
"""Times, positions, velocities and accelerations, their course, and remarks, as `JointTable.of` returns them."""


@dataclass(frozen=True, repr=False)
class JointTable:
    """N rows of joint motion by column name, as given; which joint a column is of, the cell tells.

    Attributes:
        path: The file, for messages.
        time: Shape (N,) [s], strictly increasing from 0.
        positions: Column "robot/joint" to positions, each Shape (N,) [rad or m]. A name that is no robot's may stand
            for it where one robot alone has such a joint.
        velocities: Likewise [rad/s or m/s]; what is missing is that of the C² spline of `splines_through`.
        accelerations: Likewise [rad/s² or m/s²]; without them those of the cubic spline through the velocities.
        remarks: What to know of how it was read.
        samples: How many even times the motion is taken at; None takes those of the rows.
        smooth: Splines of the positions that stand for these.
        unusable: Columns that could not be read together with the others, and why; a cell that needs one says so.

    Raises:
        InputError: If accelerations come with a number of samples.
    """

    path: Path
    time: Array
    positions: dict[str, Array]
    velocities: dict[str, Array] = field(default_factory=dict)
    accelerations: dict[str, Array] = field(default_factory=dict)
    remarks: tuple[Remark, ...] = ()
    samples: int | None = None
    smooth: dict[str, Spline] = field(default_factory=dict)
    unusable: dict[str, InputError] = field(default_factory=dict)
    _found: dict[tuple[str, ...], JointRows] = field(default_factory=dict, init=False, compare=False)

    def __post_init__(self) -> None:
        if self.samples is not None and self.accelerations:
            rule = "a table with accelerations keeps its own times: leave 'samples' out."
            raise InputError(self.path, rule, key="samples")

    def __repr__(self) -> str:
        joints = ", ".join(self.positions)
        return f"<JointTable from {self.path.name}: {len(self.time)} rows in {self.time[-1]:.4g} s of {joints}>"

    @property
    def untimed(self) -> bool:
        """Whether it is a path through waypoints, whose time is its length."""
        return any(remark.code == UNTIMED for remark in self.remarks)

    def smoothed(self, most: float) -> "JointTable":
        """The same times on splines that smooth the noise of the positions; given derivatives are left out.

        Args:
            most: How far a spline may be from any position [rad or m].

        Raises:
            InputError: If it is no number above 0, the table has few rows, or its noise is larger.
        """
        if not is_number(most, 0, LARGEST_SMOOTHING) or most == 0:
            raise InputError("smooth", f"must be > 0 and at most {LARGEST_SMOOTHING:g} (rad or m).", value=most)
        if len(self.time) < FEWEST_SMOOTHED:
            raise InputError("smooth", f"needs {FEWEST_SMOOTHED} rows, and {self.path.name} has {len(self.time)}.")
        names, q = list(self.positions), np.column_stack([*self.positions.values()])
        splines = smoothing_splines(self.time, q)
        moved = np.abs(np.column_stack([spline(self.time) for spline in splines]) - q)
        row, worst = np.unravel_index(int(np.argmax(moved)), moved.shape)
        deviation = f"{moved[row, worst]:.2g}"
        if moved[row, worst] > most:
            rule = f"a smooth spline is {deviation} from '{names[worst]}' at t = {self.time[row]:.4g} s: allow more."
            raise InputError("smooth", rule, value=most)
        text = (
            f"the joint positions were smoothed: '{names[worst]}' by {deviation} at t = {self.time[row]:.4g} s, the "
            "largest deviation; their rates are those of splines."
        )
        told = (*self.remarks, Remark("smoothed", text))
        smooth = dict(zip(names, splines, strict=True))
        return replace(self, velocities={}, accelerations={}, smooth=smooth, remarks=told)

    def of(self, joints: list[str]) -> JointRows:
        """The motion of m joints, checked, without the rows that hold still before and after it.

        Where some of the joints have less than others, all take their derivatives from that: exact accelerations of
        one arm and a spline's of another would not carry the same object.

        Args:
            joints: Columns of this table.

        Returns:
            Times, Shape (k,) [s] from 0; positions, velocities and accelerations then, each Shape (k, m); what they are
            between the rows, None where all is given; and what to know of how they were read.

        Raises:
            InputError: If velocities or accelerations contradict the positions, or some of a robot's are missing.
        """
        if tuple(joints) not in self._found:  # a sweep asks for each variant; splines of 12 columns take 1 to 10 ms
            self._found[tuple(joints)] = self._rows(joints)
        return self._found[tuple(joints)]

    def _rows(self, joints: list[str]) -> JointRows:
        from scipy.interpolate import CubicHermiteSpline, CubicSpline  # noqa: PLC0415 (slow to import, not always used)

        self._check_complete(joints)
        parts = (self.positions, self.velocities, self.accelerations)
        most, none = min(sum(name in part for part in parts) for name in joints), np.zeros((len(self.time), 0))
        q, dq, ddq = (
            np.column_stack([part[name] for name in joints]) if place < most else none
            for place, part in enumerate(parts)
        )
        kept = slice(None) if self.smooth else moving_rows(self.time, q, dq, ddq)
        time, q, dq, ddq = (of[kept] for of in (self.time - self.time[kept][0], q, dq, ddq))
        at = time if self.samples is None else np.linspace(0.0, time[-1], self.samples)
        course, remarks = None, self.remarks
        if self.smooth:
            course = JointCourse(joined([self.smooth[name] for name in joints]))
        elif not dq.size:
            spline, moved = splines_through(time, q)
            course = JointCourse(spline)
            remarks += (smoothing_remark("the joint positions", moved),) if moved > 0 else ()
        elif not ddq.size:
            course = JointCourse(CubicHermiteSpline(time, q, dq), CubicSpline(time, dq))
        motion = (q, dq, ddq) if course is None else course(at)
        for found in joint_contradictions(joints, at, *motion):
            raise InputError(self.path, found.rule, key=found.where)
        return at, motion, course, remarks

    def _check_complete(self, joints: list[str]) -> None:
        """Check that the joints of a robot are all given alike: a column that is missing is rather a mistake."""
        for part, columns in (("dq", self.velocities), ("ddq", self.accelerations)):
            lacking = {joint.rpartition("/")[0]: joint for joint in joints if joint not in columns}
            for joint in joints:
                other = lacking.get(joint.rpartition("/")[0])
                if joint in columns and other is not None:
                    raise InputError(
                        self.path,
                        f"gives {part} of '{joint}', but not of '{other}'; of a robot's joints, give all or none.",
                    )


def joint_contradictions(joints: Sequence[str], time: Array, q: Array, dq: Array, ddq: Array) -> Iterator[InputError]:
    """Where velocities and accelerations of joints, each Shape (N, m), do not lead from row to row."""
    noise = noise_allowed(q, dq)
    for column, joint in enumerate(joints):
        own = np.s_[:, column, None]
        try:
            check_derivatives(joint, time, q[own], dq[own], ddq[own], noise)
        except InputError as error:
            yield error


def joint_waypoints(path: Path, positions: dict[str, Array], samples: int | None) -> JointTable:
    """A path of joints through waypoints, by joint Shape (M,) [rad or m]: its time is the distance in joint space.

    It is as if this went at 1 rad/s or m/s, in some number of samples, or enough.

    Raises:
        InputError: If two waypoints that follow each other are the same.
    """
    steps = np.linalg.norm(np.diff(np.column_stack(list(positions.values())), axis=0), axis=1)
    if np.min(steps) == 0:
        row = int(np.argmin(steps)) + 1
        rule = "is the row before again: of waypoints without times (a column 't') leave one out."
        raise InputError(path, rule, key=f"row {row + 1}")
    way = np.concatenate([[0.0], np.cumsum(steps)])
    many = max(LEAST_SAMPLES, PER_WAYPOINT * len(steps) + 1) if samples is None else samples
    told = (
        f"the table has no times, so its {len(way)} rows are waypoints: the path is the C² spline through them by "
        f"distance in joint space, {way[-1]:.4g} (rad, m of prismatic joints), and only its timing is asked for."
    )
    return JointTable(path, way, positions, remarks=(Remark(UNTIMED, told),), samples=many)
