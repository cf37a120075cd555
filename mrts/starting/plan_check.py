# SPDX-License-Identifier: MIT
"""The last look before a robot moves: a plan's own numbers against every limit of its cell, whoever made the plan."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import NoneType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.atomic_file import JsonOutput
from mrts.base.errors import InputError, Remark, as_path, check_type, printable
from mrts.base.words import aligned
from mrts.cell.cell import Cell
from mrts.control.plan_file import read_plan
from mrts.following.clearance import Clearance, clearance_remarks
from mrts.following.coordinate import ClosureBound, grasp_gaps, mean_object
from mrts.following.coordinated_motion import CoordinatedMotion, carried_by_each
from mrts.limits.rows import RowName, joint_rows, row_names
from mrts.motion.joint_table import joint_contradictions
from mrts.motion.rounded_samples import derivative
from mrts.motion.rows_at_rest import moving_rows, pushing_ends
from mrts.program.motion_rows import motion_rows, travel_directions
from mrts.program.reserve import reserved, without_unmoved
from mrts.program.sample_problem import SampleProblem
from mrts.program.torque_distribution import torque_weights, torques_by_blocks
from mrts.scaling.remarks import overload_remarks
from mrts.scaling.scaled_trajectory import LimitedQuantities, LimitUse, ScaledTrajectory, by_share, limits_table

PLACES = np.array([0.25, 0.5, 0.75])
"""Where between two rows limits are evaluated, as shares of the step."""

PASSED = 5e-3
"""Share by which a limit may be passed: twice what quintics between the rows of smooth plans do to torques (0.24 %)."""

AT_REST = 1e-2
"""Share of the fastest joint's speed that is rest: what a spline through positions alone leaves of it."""

NEEDED = {"ddq": "dq", "tau": "F", "F": "tau"}
"""What cannot be looked at without the other: arms that hold one object share its load by both."""

RESIDUAL = 1e-3
"""Share of a torque limit, and of the largest force, or moment, that dynamics may miss: rounding in tables."""


@dataclass(frozen=True, kw_only=True, repr=False)
class PlanCheck(JsonOutput):
    """What `mrts.check_plan` found.

    Attributes:
        plan: The file.
        cell: Name of the cell.
        time: Of its rows, Shape (N,) [s].
        given: What the file gives: "q", and some of "dq", "ddq", "tau" and "F".
        uses: How much of each limit is used, by falling share. Beside those of `mrts.scale`: joint positions, gaps of
            the grasps, velocities at both ends and, where torques are given, residuals of the dynamics.
        contradictions: Where velocities and accelerations do not lead from row to row.
        remarks: What else to know before a robot plays it, collisions among it.
        clearance: How near bodies come to each other; None where that is not known.
    """

    plan: Path
    cell: str
    time: Array
    given: tuple[str, ...]
    uses: tuple[LimitUse, ...]
    contradictions: tuple[str, ...] = ()
    remarks: tuple[Remark, ...] = ()
    clearance: Clearance | None = None

    @property
    def passed(self) -> tuple[LimitUse, ...]:
        """Limits that are passed, by falling share."""
        return tuple(use for use in self.uses if use.share > 1 + PASSED)

    @property
    def status(self) -> Literal["fine", "impossible"]:
        """Whether all is kept."""
        return "impossible" if self.passed or self.contradictions else "fine"

    @property
    def interpolation(self) -> str:
        """What is between the rows."""
        return "quintic splines" if "dq" in self.given else "C² cubic splines"

    def __repr__(self) -> str:
        return printable("\n".join(self.lines()), lines=True)

    def lines(self, *, every: bool = False) -> Iterator[str]:
        """The answer for people, the outcome first; of each kind the limit used most, and those passed, or all."""
        yield self.outcome()
        yield self.basis()
        yield from self.contradictions
        yield from map(str, self.remarks)
        yield ""
        most = {use.name.kind: use for use in reversed(self.uses)}
        shown = [use for use in self.uses if every or use in self.passed or use is most[use.name.kind]]
        table = limits_table(shown, place=lambda use: f"{use.time:.4g} s, row {self.place(use)}")
        yield from aligned([table.head, *table.rows])

    def outcome(self) -> str:
        """What came of it, in a line."""
        if self.status == "fine":
            nearest = self.uses[0]
            return f"{self.plan.name}: keeps every limit of {self.cell}; nearest is {nearest.name} at {nearest.percent}"
        passed = f"passes {len(self.passed)} of {len(self.uses)} limits of {self.cell}"
        worst = f": at worst {self.passed[0].name}, {self.passed[0].percent}" if self.passed else ""
        broken = "contradicts itself" if self.contradictions else ""
        return f"{self.plan.name}: {' and '.join(filter(None, [broken, passed * bool(self.passed)]))}{worst}"

    def basis(self) -> str:
        """What was evaluated, in a line."""
        torques = (
            "torques are not in the file: those that keep most of every limit free"
            if "tau" not in self.given
            else "torques and wrenches of the file"
        )
        return f"{len(self.time)} rows in {self.time[-1]:.4g} s, {self.interpolation} between them; {torques}"

    def place(self, use: LimitUse) -> str:
        """The row of a moment, or the two around it; the first row of numbers is 1."""
        before = int(np.searchsorted(self.time, use.time, side="right"))
        return f"{before}" if self.time[before - 1] == use.time else f"{before} to {before + 1}"

    def to_json(self) -> dict[str, Any]:
        """All of it as values of JSON."""
        return {
            "status": self.status,
            "plan": str(self.plan),
            "cell": self.cell,
            "given": list(self.given),
            "interpolation": self.interpolation,
            "limits": [use.to_json() | {"row": self.place(use)} for use in self.uses],
            "contradictions": list(self.contradictions),
            "clearance": self.clearance and self.clearance.to_json(),
            "remarks": [remark.to_json() for remark in self.remarks],
        }


def check_plan(cell: Cell, plan: Path | str, *, closure: ClosureBound | None = None) -> PlanCheck:
    """Evaluate a plan by itself: every limit of the cell at its rows and between them, and what a controller relies on.

    Nothing of how the plan was made is trusted. Between the rows joints are on the quintic spline through positions,
    velocities and accelerations, as ros2_control's joint_trajectory_controller plays them, or on the C² cubic spline
    through positions alone; wrenches change in proportion, moved by the least change that carries the object, and
    torques follow from them by inverse dynamics. At the rows torques and wrenches are those of the file, compared with
    (13) and (20). Without them, those are taken that keep most of every limit free: limits that are passed then are
    passed by any.

    Args:
        cell: The cell.
        plan: A CSV table with t, q.ROBOT/JOINT, and maybe dq., ddq., tau. and F., as of `mrts.write_trajectory_csv`, or
            a ROS 2 bag with joint trajectories, as of `mrts.write_ros_bag`.
        closure: How far hands may be off their grasps; None allows 2 mm and 5 mrad.

    Returns:
        What was found; a plan that passes limits is an outcome.

    Raises:
        InputError: If the file is malformed, does not fit the cell, or gives some joint less than others.
    """
    path = as_path("plan", plan)
    check_type("closure", closure, ClosureBound, NoneType)
    time, given = read_plan(cell, path)
    for part, others in NEEDED.items():
        if part in given and others not in given:
            raise InputError(path, f"gives '{part}.…' without '{others}.…': give both, or leave '{part}.…' out.")
    at, course, rows = _course(time, given)
    motion, gaps = _carried(cell, at, course, closure or ClosureBound())
    residuals: list[LimitUse] = []
    if "tau" in given:
        torque, wrench, residuals = _given_torques(cell, motion, rows, time, given["tau"], given["F"])
    else:
        torque, wrench = _best_torques(cell, motion)
    done = ScaledTrajectory(cell, motion, 1.0, torque, wrench)
    dq, ddq, at_rows = motion.dq[rows], motion.ddq[rows], motion.at(rows)
    kept = moving_rows(time, given["q"], dq, ddq)
    moving = time[kept], given["q"][kept], dq[kept], ddq[kept]
    near, said = clearance_remarks(cell, at_rows)
    uses = [
        *done.limit_uses,
        *_rates(cell, at_rows, torque[rows], wrench[rows], only_jerk="tau" not in given),
        *_positions(cell, at, motion.q),
        *gaps,
        *_ends(cell, time, dq),
        *residuals,
    ]
    return PlanCheck(
        plan=path,
        cell=cell.name,
        time=time,
        given=tuple(given),
        uses=tuple(by_share(uses)),
        contradictions=tuple(map(str, joint_contradictions(cell.joint_names, *moving))) if "dq" in given else (),
        remarks=(*_pushing(dq, ddq), *overload_remarks(done), *said),
        clearance=near,
    )


def _course(time: Array, given: dict[str, Array]) -> tuple[Array, tuple[Array, Array, Array], NDArray[np.intp]]:
    """Times of rows and places between them, joints there, and which places are rows.

    Between a row that holds still and the row next to it nothing moves, and no place is looked at.
    """
    from scipy.interpolate import BPoly, CubicSpline  # noqa: PLC0415 (slow to import)

    none = np.zeros((len(time), 0))
    q, dq, ddq = given["q"], given.get("dq", none), given.get("ddq", none)
    kept = moving_rows(time, q, dq, ddq)
    inside = (time[kept][:-1, None] + np.diff(time[kept])[:, None] * PLACES).ravel()
    at = np.union1d(time, inside)
    rows = np.searchsorted(at, time)
    if "dq" not in given:
        spline = CubicSpline(time, q)
        return at, (spline(at), spline(at, 1), spline(at, 2)), rows
    ddq = given["ddq"] if "ddq" in given else derivative(time, dq)
    quintic = BPoly.from_derivatives(time, np.stack([q, dq, ddq], axis=1))
    course = (quintic(at), quintic(at, 1), quintic(at, 2))
    for values, exact in zip(course, (q, dq, ddq), strict=True):
        values[rows] = exact
    return at, course, rows


def _carried(
    cell: Cell, at: Array, course: tuple[Array, Array, Array], bound: ClosureBound
) -> tuple[CoordinatedMotion, list[LimitUse]]:
    """The object as the hands carry it on the mean, and how far each is off its grasp."""
    by_each = carried_by_each(cell, at, *course)
    carried = mean_object(by_each)
    gaps = grasp_gaps(cell, carried, course[0])
    names = [
        RowName(kind, robot.name, unit=unit)
        for kind, unit in (("grasp distance", "m"), ("grasp angle", "rad"))
        for robot in cell.robots
    ]
    values = gaps.reshape(len(names), -1).T
    limit = np.repeat([bound.position, bound.angle], len(cell.robots))
    return CoordinatedMotion(carried, *course), _uses(names, at, values, limit)


def _best_torques(cell: Cell, motion: CoordinatedMotion) -> tuple[Array, Array]:
    """Torques and wrenches whose largest share of a limit is the least at each place, within limits or not."""

    def within(problem: SampleProblem) -> SampleProblem:
        return reserved(without_unmoved(problem), 1.0)

    rows, weights = motion_rows(cell.with_reserve(0.0), motion), torque_weights(None, cell)
    return torques_by_blocks(rows, 1.0, weights, within=within)


def _given_torques(
    cell: Cell, motion: CoordinatedMotion, rows: NDArray[np.intp], time: Array, tau: Array, F: Array
) -> tuple[Array, Array, list[LimitUse]]:
    """Torques and wrenches of the file at its rows, and those needed between them; residuals at the rows."""
    wrench = np.column_stack([np.interp(motion.object.time, time, column) for column in F.T])
    played = ScaledTrajectory(cell, motion, 1.0, np.zeros_like(motion.q), wrench)
    terms, short, asked = played.terms, played.unbalanced, played.inverse_dynamics[rows]
    residual = np.abs(tau - asked)
    before, after = travel_directions(motion)[:, rows]
    coulomb = cell.stacked("motors.coulomb")
    residual = np.maximum(residual - coulomb * (1 - np.abs(before + after) / 2), 0.0)  # a joint at rest may take it
    wrench = wrench + played.least_wrenches(short)
    torque = replace(played, wrench=wrench).inverse_dynamics
    torque[rows], wrench[rows] = tau, F
    names = joint_rows(cell, "torque residual", "torque_units")
    limit = np.maximum(-cell.stacked("torque_lower"), cell.stacked("torque_upper"))
    limit = RESIDUAL * np.where(np.isfinite(limit), limit, np.max(np.abs([tau, asked]), axis=(0, 1)))
    of_object = row_names("balance residual", "object", cell.wrench_components, cell.wrench_units)
    carried = (terms["P"] + terms["Q"])[rows]
    parts = [*np.split(F, len(cell.robots), axis=1), carried, carried - short[rows]]
    sizes = np.max(np.abs(parts), axis=(0, 1))
    forces = np.array(cell.wrench_units) == "N"
    largest = np.max(sizes[forces])
    arm = max(float(np.linalg.norm(robot.T_object_tip.p)) for robot in cell.robots)
    moment = max(arm * largest, float(np.max(sizes[~forces])))
    group = RESIDUAL * np.where(forces, largest, moment)
    return torque, wrench, [*_uses(names, time, residual, limit), *_uses(of_object, time, np.abs(short[rows]), group)]


def _rates(cell: Cell, at_rows: CoordinatedMotion, torque: Array, wrench: Array, *, only_jerk: bool) -> list[LimitUse]:
    """Rates from row to row, where the cell limits them; those of torques that are not the file's say nothing."""
    before, after = travel_directions(at_rows)
    start = np.where(after[0] == 0, after[1], after[0])  # that of a smooth plan its next row alone tells
    end = np.where(before[-1] == 0, before[-2], before[-1])
    travel = np.stack([[start, *before[1:-1], end], [start, *after[1:-1], end]])
    at_rows = replace(at_rows, travel=travel)
    done = ScaledTrajectory(cell, at_rows, 1.0, torque, wrench)
    return [use for use in done.limited_rates().uses(done.time) if use.name.kind == "jerk" or not only_jerk]


def _positions(cell: Cell, at: Array, q: Array) -> list[LimitUse]:
    """How far joints are from the middle of their ranges, as shares of half of these."""
    names = joint_rows(cell, "position", "position_units")
    lower, upper = cell.stacked("position_lower"), cell.stacked("position_upper")
    own = np.flatnonzero(np.isfinite(lower) & np.isfinite(upper))
    lower, upper = lower[own], upper[own]
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    share = np.abs(q[:, own] - middle) / half
    wide = (len(at), len(own))
    found = LimitedQuantities(
        tuple(names[place] for place in own.tolist()), q[:, own],
        np.broadcast_to(lower, wide), np.broadcast_to(upper, wide), share, half,
    )  # fmt: skip
    return list(found.uses(at))


def _ends(cell: Cell, time: Array, dq: Array) -> list[LimitUse]:
    """Velocities at both ends, which must be none."""
    names = joint_rows(cell, "end velocity", "position_units", "/s")
    units = np.array([name.unit for name in names])
    most = np.max(np.abs(dq), axis=0)
    limit = AT_REST * np.array([np.max(most[units == unit]) for unit in units])
    return _uses(names, time[[0, -1]], np.abs(dq[[0, -1]]), limit)


def _uses(names: Sequence[RowName], time: Array, values: Array, limit: Array) -> list[LimitUse]:
    """Of sizes with a largest value each, 0 where nothing is to compare with: then 1 is 100 %."""
    unit, wide = np.where(limit > 0, limit, 1.0), np.broadcast_to(limit, values.shape)
    return list(LimitedQuantities(tuple(names), values, np.zeros_like(wide), wide, values / unit, unit).uses(time))


def _pushing(dq: Array, ddq: Array) -> tuple[Remark, ...]:
    ends = [word for word, pushes in zip(("starts", "ends"), pushing_ends(dq, ddq), strict=True) if pushes]
    if not ends:
        return ()
    text = (
        f"the plan {' and '.join(ends)} at rest but accelerates there: a controller that stays there pushes. Add a row "
        "that holds still."
    )
    return (Remark("pushes-at-ends", text),)
