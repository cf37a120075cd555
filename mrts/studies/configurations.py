# SPDX-License-Identifier: MIT
"""All inverse-kinematics branches of every arm, followed along the motion and ranked by c²⁺ (section VI, 6.3)."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.atomic_file import JsonOutput
from mrts.base.errors import Progress, check_callable, check_type
from mrts.base.words import aligned
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion, check_motion
from mrts.following.tracking import OUT_OF_REACH, TrackedVariants, TrackingFailure, branches_at_start, follow_from
from mrts.limits.rows import row_labels
from mrts.motion.object_motion import ObjectMotion
from mrts.program.between_samples import BETWEEN
from mrts.program.load_sharing import LoadSharing
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.scaling.options import Options
from mrts.scaling.range import ScalingRange
from mrts.scaling.scale import admissible_range

TIED = ".8e"
"""Digits to which c²⁺ of two configurations are one: a wrist turned by 2π gives the same but for rounding."""


@dataclass(frozen=True)
class Branch:
    """One way in which an arm can hold its grasp at t = 0, followed along the motion.

    Attributes:
        robot: Name of the arm.
        number: Counted from 1 in the order found.
        start: Joint positions at t = 0, Shape (n_i,) [rad or m].
        failure: Why it ends before the motion does; None if it does not.
    """

    robot: str
    number: int
    start: Array
    failure: TrackingFailure | None


@dataclass(frozen=True)
class Configuration:
    """One branch for each arm.

    Attributes:
        branches: In the order of the cell's robots.
        range: The admissible range of c².
        joint_margin: Least distance of a joint from its position limits along the motion [rad or m].
    """

    branches: tuple[Branch, ...]
    range: ScalingRange
    joint_margin: float

    @property
    def c2_upper(self) -> float:
        """c²⁺; infinity if nothing limits it, minus infinity if no c² is admissible."""
        return self.range.c2_upper

    def postures(self) -> dict[str, list[float]]:
        """For `Cell.with_postures` or the cell file, by robot [rad or m]."""
        return {branch.robot: branch.start.tolist() for branch in self.branches}


@dataclass(frozen=True, repr=False)
class ConfigurationStudy(JsonOutput):
    """What `rank_configurations` found.

    Attributes:
        branches: All branches by robot, those that fail included.
        ranked: Configurations by falling c²⁺, those of one c²⁺ by falling joint margin, infeasible ones last.
    """

    branches: dict[str, list[Branch]]
    ranked: tuple[Configuration, ...]

    def __repr__(self) -> str:
        return f"<ConfigurationStudy: {len(self.ranked)} configurations reach the end>"

    def lines(self, rows: int) -> Iterator[str]:
        """The best configurations, so many at most, and the branches that they are made of, for people."""
        kinds = Counter(b.failure.kind for every in self.branches.values() for b in every if b.failure is not None)
        lost = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
        left_out = f"; branches left out: {lost}" if lost else ""
        yield f"{len(self.ranked)} configurations reach the end, by falling c²⁺{left_out}:"
        table = [("rank", *self.branches, "c²⁺", "limited at")]
        for rank, one in enumerate(self.ranked[:rows], start=1):
            c2 = f"{one.c2_upper:#.4g}" if np.isfinite(one.c2_upper) else "-"
            numbers = [str(branch.number) for branch in one.branches]
            table.append((str(rank), *numbers, c2, outcome(one)))
        yield from aligned(table)
        yield ""
        yield "branches of these at t = 0 (rad, m; a line is a `posture` for the cell file):"
        used = [branch for one in self.ranked[:rows] for branch in one.branches]
        for name, branches in self.branches.items():
            good = [branch for branch in branches if branch.failure is None]
            for branch in (branch for branch in good if branch in used):
                yield f"{name:>8} {branch.number:>3}  [{', '.join(f'{value:.4f}' for value in branch.start)}]"
            if not good and branches[0].failure is not None:
                yield f"{name:>8}   -  none; the first: {branches[0].failure.message}"

    def to_json(self) -> dict[str, Any]:
        """The whole study as JSON values."""
        ranked = [
            {
                "branches": {branch.robot: branch.number for branch in one.branches},
                "postures": one.postures(),
                **one.range.to_json(),
                "joint_margin": one.joint_margin if np.isfinite(one.joint_margin) else None,
                "outcome": outcome(one),
            }
            for one in self.ranked
        ]
        branches = {
            name: [
                {"number": b.number, "start": b.start.tolist(), "failure": b.failure and b.failure.message}
                for b in of_robot
            ]
            for name, of_robot in self.branches.items()
        }
        return {"combinations": len(self.ranked), "ranked": ranked, "branches": branches}


def rank_configurations(
    cell: Cell,
    motion: ObjectMotion,
    *,
    sharing: LoadSharing | None = None,
    solver: str = DEFAULT_SOLVER,
    between: float | None = BETWEEN,
    progress: Progress = lambda _done, _total: None,
) -> ConfigurationStudy:
    """Evaluate every combination of inverse-kinematics branches.

    Branches come from seeded random starts; for a redundant arm these settle where they come locally
    nearest to its posture. Positions outside the joint limits do not count. Ranges of an uncertain load are the
    guaranteed ones.

    Args:
        cell: The cell.
        motion: Motion of the object.
        sharing: A fixed distribution of the load; None leaves it free.
        solver: Name in the registry.
        between: As in `mrts.scale`.
        progress: Told how many of how many evaluations are done.

    Raises:
        InputError: If an arm has too few joints.
        MotionError: If the object leaves the plane of a planar cell.
    """
    check_type("cell", cell, Cell)
    check_type("motion", motion, ObjectMotion)
    check_callable("progress", progress)
    options = Options(sharing=sharing, solver=solver, between=between).checked(cell)
    check_motion(cell, motion)
    starts = [branches_at_start(cell, index, motion) for index in range(len(cell.robots))]
    tracks, branches = _follow(cell, motion, starts)
    good = [[branch for branch in branches[robot.name] if branch.failure is None] for robot in cell.robots]
    choices, ranked = [*product(*good)], []
    for number, choice in enumerate(choices):
        progress(number, len(choices))
        ranked.append(_evaluate(cell, motion, tracks, choice, options))
    progress(len(choices), len(choices))
    ranked.sort(key=lambda one: (-float(f"{one.c2_upper:{TIED}}"), -one.joint_margin))
    return ConfigurationStudy(branches, tuple(ranked))


def _follow(cell: Cell, motion: ObjectMotion, starts: list[Array]) -> tuple[TrackedVariants, dict[str, list[Branch]]]:
    """Follow all branches of all arms at once: track t carries branch t of every arm that has one."""
    posture = cell.posture
    start = np.tile(posture, (max(1, *(len(of_robot) for of_robot in starts)), 1))
    for joints, of_robot in zip(cell.joint_slices.values(), starts, strict=True):
        start[: len(of_robot), joints] = of_robot
        if len(of_robot):  # an arm with fewer branches repeats its first in the other tracks
            start[len(of_robot) :, joints] = of_robot[0]
    tracks = follow_from(cell, motion, start)
    branches: dict[str, list[Branch]] = {}
    for index, (robot, of_robot) in enumerate(zip(cell.robots, starts, strict=True)):
        branches[robot.name] = []
        for number, held in enumerate(of_robot):
            failure = tracks.of_arm(number, index)
            own = tracks.q[number, 0, cell.joint_slices[robot.name]] if failure is None else held
            branches[robot.name].append(Branch(robot.name, number + 1, own, failure))
        if not len(of_robot):
            message = f"robot '{robot.name}' cannot reach its grasp at t = 0. Move the path, the base or the grasp."
            failure = TrackingFailure(OUT_OF_REACH, message)
            branches[robot.name] = [Branch(robot.name, 1, robot.posture, failure)]
    return tracks, branches


def _evaluate(
    cell: Cell, motion: ObjectMotion, tracks: TrackedVariants, choice: tuple[Branch, ...], options: Options
) -> Configuration:
    places = [(branch.number - 1, joints) for branch, joints in zip(choice, cell.joint_slices.values(), strict=True)]
    q, dq, ddq = (
        np.concatenate([values[track][:, joints] for track, joints in places], axis=1)
        for values in (tracks.q, tracks.dq, tracks.ddq)
    )
    whole = CoordinatedMotion(motion, q, dq, ddq)
    margin = np.minimum(q - cell.stacked("position_lower"), cell.stacked("position_upper") - q)
    return Configuration(choice, admissible_range(cell, whole, options)[0].range, float(np.min(margin)))


def outcome(configuration: Configuration) -> str:
    """When and by what a configuration is limited, or why it is not feasible, in a phrase."""
    found = configuration.range
    if not found.status.admits_motion:
        return f"{found.status.value}: {found.reason()}"
    if found.upper.time is None:
        return str(found.status.value)
    return f"t = {found.upper.time:.3g} s: {row_labels(found.upper.rows)}"
