# SPDX-License-Identifier: MIT
"""Motion of joints by name, as tables and bags give it: with velocities and accelerations, or differentiated."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from mrts.base.argument_types import is_number
from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.remark import Remark
from mrts.motion.object_courses import smoothing_remark
from mrts.motion.object_motion import check_derivatives, noise_allowed
from mrts.motion.rounded_samples import Spline, smoothing_splines, splines_through
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

Source = Literal["positions", "velocities"]
"""What the derivatives of a joint that were not given were found from."""


@dataclass(frozen=True, repr=False, eq=False)
class JointSplines:
    """What a table makes of one joint at any time: the spline of its position [rad or m], and that of a given velocity.

    `moved` says by how much positions were smoothed by their rounding, at most [rad or m].
    """

    position: Spline
    rate: Spline | None = None
    moved: float = 0.0

    @property
    def source(self) -> Source:
        """What the derivatives that were not given were found from."""
        return "positions" if self.rate is None else "velocities"

    def __call__(self, time: Array) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration at some times, Shape (k,) [s]."""
        rate = (self.position, 1) if self.rate is None else (self.rate, 0)
        orders = ((self.position, 0), rate, (rate[0], rate[1] + 1))
        position, velocity, acceleration = (
            np.asarray(spline(time, order), dtype=np.float64) for spline, order in orders
        )
        return position, velocity, acceleration


@dataclass(frozen=True, repr=False)
class JointTable:
    """N samples of joint motion by column name; which joint a column is of, the cell tells.

    Attributes:
        path: The file, for messages.
        time: Shape (N,) [s], strictly increasing from 0.
        positions: Column "robot/joint" to positions, each Shape (N,) [rad or m]. A name that is no robot's may stand
            for it where one robot alone has such a joint.
        velocities: Likewise [rad/s or m/s].
        accelerations: Likewise [rad/s² or m/s²].
        remarks: What to know of how it was read.
        splines: The columns whose velocities, or accelerations only, were not given, between the rows as well.
        unusable: Columns that could not be read together with the others, and why; a cell that needs one says so.
    """

    path: Path
    time: Array
    positions: dict[str, Array]
    velocities: dict[str, Array]
    accelerations: dict[str, Array]
    remarks: tuple[Remark, ...] = ()
    splines: dict[str, JointSplines] = field(default_factory=dict)
    unusable: dict[str, InputError] = field(default_factory=dict)

    def __repr__(self) -> str:
        joints = ", ".join(self.positions)
        return f"<JointTable from {self.path.name}: {len(self.time)} samples in {self.time[-1]:.4g} s of {joints}>"

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
        names = list(self.positions)
        splines = smoothing_splines(self.time, np.column_stack([self.positions[name] for name in names]))
        found = {name: JointSplines(spline) for name, spline in zip(names, splines, strict=True)}
        q, dq, ddq = ({name: spline(self.time)[order] for name, spline in found.items()} for order in range(3))
        moved = {name: np.abs(q[name] - self.positions[name]) for name in names}
        worst = max(names, key=lambda name: float(np.max(moved[name])))
        largest, at = float(np.max(moved[worst])), self.time[np.argmax(moved[worst])]
        if largest > most:
            rule = f"a smooth spline is {largest:.2g} from the position of '{worst}' at t = {at:.4g} s: allow more."
            raise InputError("smooth", rule, value=most)
        text = (
            f"the joint positions were smoothed: '{worst}' by {largest:.2g} at t = {at:.4g} s, the largest deviation; "
            "their rates are those of splines."
        )
        told = (*self.remarks, Remark("smoothed", text))
        return replace(self, positions=q, velocities=dq, accelerations=ddq, splines=found, remarks=told)

    def of(self, joints: list[str]) -> "JointTable":
        """The part of a table that a cell needs, checked.

        Where some of the joints have less than others, all take their derivatives from that: exact accelerations of
        one arm and a spline's of another would not carry the same object.

        Args:
            joints: Columns of this table.

        Raises:
            InputError: If velocities or accelerations contradict the positions, or some of a robot's are missing.
        """
        self._check_complete(joints)
        given = (self.positions, self.velocities, self.accelerations)
        columns = (np.column_stack([part[name] for name in joints]) for part in given)
        for found in joint_contradictions(joints, self.time, *columns):
            raise InputError(self.path, found.rule, key=found.where)
        sources = {self.source(joint) for joint in joints}
        if len(sources) == 1:
            moved = max((self.splines[joint].moved for joint in joints if joint in self.splines), default=0.0)
            smoothing = (smoothing_remark("the joint positions", moved),) if moved > 0 else ()
            return replace(self, remarks=self.remarks + smoothing)
        positions, velocities = ({joint: part[joint] for joint in joints} for part in (self.positions, self.velocities))
        table = joint_motion(self.path, self.time, positions, {} if "positions" in sources else velocities, {}, None)
        before = {name: spline.moved for name, spline in self.splines.items()}
        again = {name: replace(one, moved=one.moved or before.get(name, 0.0)) for name, one in table.splines.items()}
        return replace(table, remarks=self.remarks, splines=again).of(joints)

    def source(self, column: str) -> Source | None:
        """What the derivatives of a column that were not given were found from; None if all were given."""
        return self.splines[column].source if column in self.splines else None

    def _check_complete(self, joints: list[str]) -> None:
        """Check that the joints of a robot are all given alike: a column that is missing is rather a mistake."""
        for part, without in (("dq", ("positions",)), ("ddq", ("positions", "velocities"))):
            lacking = {joint.rpartition("/")[0]: joint for joint in joints if self.source(joint) in without}
            for joint in joints:
                other = lacking.get(joint.rpartition("/")[0])
                if other is not None and self.source(joint) not in without:
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


def joint_motion(
    path: Path,
    time: Array,
    positions: dict[str, Array],
    velocities: dict[str, Array],
    accelerations: dict[str, Array],
    samples: int | None,
) -> JointTable:
    """Joint motion as given, by joint Shape (M,); what is missing of a joint is that of a spline through what there is.

    Without velocities that is the C² spline of `splines_through` through its positions; without accelerations the
    cubic spline through its velocities. It has the given times, Shape (M,) [s], or some number of even ones.

    Raises:
        InputError: If accelerations come with a number of samples.
    """
    if samples is not None and accelerations:
        raise InputError(path, "a table with accelerations keeps its own times: leave 'samples' out.", key="samples")
    given = (positions, velocities, accelerations)
    kept = moving_rows(time, *(_columns(part, given, len(time)) for part in given))
    time = time[kept] - time[kept][0]
    positions, velocities, accelerations = ({name: part[name][kept] for name in part} for part in given)
    at = time if samples is None else np.linspace(0.0, time[-1], samples)
    q, dq, ddq = dict(positions), dict(velocities), dict(accelerations)
    through = {joint: _through_rates(time, q[joint], rates) for joint, rates in velocities.items() if joint not in ddq}
    still = [joint for joint in q if joint not in dq]
    if still:
        splines, moved = splines_through(time, np.column_stack([q[joint] for joint in still]))
        for joint, spline, change in zip(still, splines, moved.tolist(), strict=True):
            through[joint] = JointSplines(spline, moved=change)
    for joint, splines_of in through.items():
        q[joint], dq[joint], ddq[joint] = splines_of(at)
    return JointTable(path, at, q, dq, ddq, splines=through)


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
    return replace(joint_motion(path, way, positions, {}, {}, many), remarks=(Remark(UNTIMED, told),))


def _columns(part: dict[str, Array], given: tuple[dict[str, Array], ...], rows: int) -> Array:
    """What is given of the joints of which most is, Shape (N, k), with no columns where it is not given of them."""
    best = next(part for part in reversed(given) if part)
    return np.column_stack([np.zeros((rows, 0)), *(part[name] for name in best if name in part)])


def _through_rates(time: Array, q: Array, dq: Array) -> JointSplines:
    from scipy.interpolate import CubicHermiteSpline, CubicSpline  # noqa: PLC0415 (slow to import, and rarely needed)

    return JointSplines(CubicHermiteSpline(time, q, dq), CubicSpline(time, dq))
