# SPDX-License-Identifier: MIT
"""Many variants of one cell solved at once, in native calls: start poses, joints, ranges of c²."""

from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import MrtsError
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.base.rigid_transform import plane_normal, rotations_from_rpy
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion, leaves_plane
from mrts.following.variant_tracking import TrackedVariants, track_variants
from mrts.kernel.programs import INFEASIBLE, OPTIMAL
from mrts.kernel.sample_terms import SampleTerms
from mrts.kernel.tracking import PATH, REFUSED
from mrts.kernel.variants import variant_ranges
from mrts.limits.rows import ActiveRow
from mrts.motion.motion_file import MotionDescription, sample_motion
from mrts.motion.object_courses import geodesic_rates
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.velocity_profile import PROFILES
from mrts.program.range_status import RangeStatus
from mrts.program.sample_ranges import POINT_TOLERANCE
from mrts.scaling.range import RangeEnd, contradiction
from mrts.studies.study import Study
from mrts.studies.variant_limits import VariantLimits
from mrts.studies.variant_numbers import (
    NEAR_A_RULE,
    PATH_ENDS,
    Entry,
    VariantNumbers,
    base_numbers,
    varied_entries,
)
from mrts.studies.variant_rows import UNREACHABLE, Columns, Row, columns_of, ends_row, solved_row

BLOCK_BYTES = 8_000_000
"""Of the arrays of the variants that one native call solves: small enough to stay near the processor."""

STRIDE = 8
"""Samples between those that are looked at first, after those that set the range of the unvaried cell."""

KEPT = 4
"""Studies whose cells are kept ready."""


@lru_cache(maxsize=KEPT)
def batch_for(study: Study) -> "VariantBatch | None":
    """What solves the variants of a study at once; None where they take more than that.

    Covered are ranges of a constant factor at the samples, for a known load and a free distribution of it, on a path
    from pose to pose or one that does not vary, with varied poses, gravity, object, postures, duration, and limits of
    torques, wrenches and the object's velocity; of two arms or more whose motors are ideal.

    Args:
        study: The study.
    """
    question = study.question
    asked = (question.profile, question.torques, question.between) == ("constant", False, None)
    if not asked or study.limits:
        return None
    here = study.at_hand()
    try:
        cell = Cell.from_description(here.cell, folder=here.folder)
        motion = study.table if study.table is not None else sample_motion(MotionDescription(**study.motion))
    except MrtsError:  # of the study's own numbers, which it may vary
        return None
    known = question.load == "nominal" or (question.load == "auto" and cell.load_box is None)
    entries = varied_entries(study, cell)
    if not known or entries is None or len(cell.robots) == 1 or not _covers(cell, entries):
        return None
    return VariantBatch(here, cell, motion, entries) if isinstance(motion, ObjectMotion) else None


def _covers(cell: Cell, entries: Sequence[Entry]) -> bool:
    """Whether rows and terms of the cell are those of plain torques, wrenches, contacts and velocities."""
    names = {entry.name for entry in entries}
    motors = [robot.motors for robot in cell.robots]
    ideal = all(not each.has_effect and set(each.torque_speed) <= {None} for each in motors)
    in_tip = any(contact.frame == "tip" for robot in cell.robots for contact in robot.contacts)
    bounds = [(robot.wrench_lower, robot.wrench_upper) for robot in cell.robots]
    free = np.concatenate([np.isinf(lower) & np.isinf(upper) for lower, upper in bounds])
    limited = {entry.index[0] for entry in entries if entry.name.startswith("wrench")}
    has_rows = not np.any(free[list(limited)])  # a limit on what the cell leaves free is a row more than it has
    return ideal and has_rows and not (cell.plane is not None and in_tip and "grasp_rpy" in names)


class VariantAnswers:
    """The rows of the table of some variants, as far as they are settled.

    Args:
        limits: Of their cell.
        given: What the native calls took, by name, with V or 1 first.
        tracked: What they gave.
        found: Ranges, of `mrts.kernel.variants.range_record`.

    Attributes:
        found: Likewise.
    """

    def __init__(
        self,
        limits: VariantLimits,
        given: Mapping[str, Array],
        tracked: TrackedVariants,
        found: NDArray[np.void],
    ) -> None:
        self._limits, self._given, self._tracked, self.found = limits, given, tracked, found

    def row(self, variant: int) -> Row | None:
        """The row of one variant, without its number and its parameters; None where it is not settled.

        Args:
            variant: Place in the arrays.
        """
        failure = self._tracked.failure(variant)
        if failure is not None:
            return {"status": UNREACHABLE, "reason": failure.message}
        if self._tracked.joints.outcome[variant, 0]["code"] == REFUSED:
            return None
        status = int(self.found[variant]["status"])
        if status == INFEASIBLE:
            return self._infeasible(variant)
        return self._range(variant) if status == OPTIMAL else None

    def _of(self, name: str, variant: int) -> Array:
        values = self._given[name]
        one: Array = values[variant if len(values) > 1 else 0]
        return one

    def _infeasible(self, variant: int) -> Row:
        found, status = self.found[variant], RangeStatus.INFEASIBLE
        rows = self._named(variant, 0)
        sample = int(found["sample"][0])
        reason = (
            f"at t = {self._of('time', variant)[sample]:.4g} s (sample {sample}) no torques carry the object at any "
            f"speed: these limits conflict: {'; '.join(map(str, rows))}. {status.advice}"
        )
        return {"status": status.value, "reason": reason}

    def _range(self, variant: int) -> Row:
        low, high = self.found[variant]["c2"].tolist()
        if high < low <= high * (1 + POINT_TOLERANCE):
            low = high
        lower = self._end(variant, 0, low) if low > 0 else RangeEnd(low, None, None)
        upper = self._end(variant, 1, high) if np.isfinite(high) else RangeEnd(high, None, None)
        if low > high:
            reason = f"{contradiction(lower, upper)} {RangeStatus.EMPTY.advice}"
            return {"status": RangeStatus.EMPTY.value, "reason": reason}
        row = ends_row(lower, upper, float(self._of("time", variant)[-1]))
        if np.isinf(high):
            return row | {"status": RangeStatus.UNBOUNDED.value, "reason": RangeStatus.UNBOUNDED.advice}
        return row | {"status": RangeStatus.FEASIBLE.value}

    def _end(self, variant: int, end: int, c2: float) -> RangeEnd:
        sample = int(self.found[variant]["sample"][end])
        return RangeEnd(c2, sample, float(self._of("time", variant)[sample]), self._rows(variant, end))

    def _rows(self, variant: int, end: int) -> tuple[ActiveRow, ...]:
        rows = self._named(variant, end)
        if end and self.found[variant]["capped"]:
            rows += self._velocities[variant]
        return tuple(rows)

    @cached_property
    def _velocities(self) -> dict[int, list[ActiveRow]]:
        """By variant that velocities bound: those that do the most."""
        settled = self._tracked.joints.followed & (self.found["status"] == OPTIMAL)
        capped = np.flatnonzero(settled & (self.found["capped"] != 0))
        sample = self.found["sample"][capped, 1]
        twist, limit = (np.broadcast_to(each, (len(self.found), *each.shape[1:])) for each in
                        (self._given["twist"], self._given["velocity"]))  # fmt: skip
        rows = self._limits.velocities_at(self._tracked.joints.dq[capped, sample], twist[capped, sample], limit[capped])
        return dict(zip(capped.tolist(), rows, strict=True))

    def _named(self, variant: int, end: int) -> list[ActiveRow]:
        found = self.found[variant]
        sides = self._of("lower", variant), self._of("upper", variant)
        return self._limits.named(found["rows"][end, : found["count"][end]], *sides)


class VariantBatch:
    """Variants of one cell, solved at once.

    Args:
        study: Whose variants they are, as from `Study.at_hand`.
        cell: Its cell, unvaried.
        motion: Its motion, unvaried.
        entries: What is varied.
    """

    def __init__(self, study: Study, cell: Cell, motion: ObjectMotion, entries: Sequence[Entry]) -> None:
        self._study, self._cell, self._motion, self._entries = study, cell, motion, entries
        reserve = cell.reserve if study.question.reserve is None else study.question.reserve
        still = np.zeros((len(motion.time), len(cell.joint_names)))
        self._limits = VariantLimits(cell, CoordinatedMotion(motion, still, still, still), reserve)
        self._base = base_numbers(study, cell)
        varied = {entry.name for entry in entries}
        m = still.shape[1]
        each = len(motion.time) * (3 * m + (0 if varied.isdisjoint(PATH_ENDS) else 25)) * 8
        self.block = max(1, BLOCK_BYTES // each)
        self._order = self._first_looked_at(np.arange(len(motion.time)))
        ends = self._answers(VariantNumbers(self._base, (), np.zeros((1, 0)))).found[0]["sample"]
        self._order = self._first_looked_at(ends[::-1])

    def solve(self, points: Array, first: int) -> Columns:
        """The rows of variants, as `mrts.studies.variant_rows.solve_variants` gives them.

        Args:
            points: Values of the parameters, Shape (V, P).
            first: Number of the first variant.
        """
        rows: list[Row] = []
        for start in range(0, len(points), self.block):
            part = points[start : start + self.block]
            with np.errstate(all="ignore"):  # of numbers that break a rule, which are left to `solved_row`
                answers = self._answers(VariantNumbers(self._base, self._entries, part))
            found = (answers.row(variant) for variant in range(len(part)))
            rows += [
                solved_row(self._study, point) if row is None else row for point, row in zip(part, found, strict=True)
            ]
        return columns_of(self._study, points, first, rows)

    def _answers(self, numbers: VariantNumbers) -> VariantAnswers:
        refused = numbers.doubtful()
        geometry, path = numbers.geometry(self._cell), self._path(numbers, refused)
        if self._cell.plane is not None:
            refused |= leaves_plane(self._cell, path["twist"]) | _tilted(self._cell, geometry)
        tracked = track_variants(self._cell, path, geometry, numbers["posture"], refused)
        given = {**path, "geometry": geometry, "load": numbers.loads(), **self._limits.of(numbers, geometry)}
        found = variant_ranges(
            self._cell.library, tracked.joints, self._limits.sparse, SampleTerms(), self._order, given
        )
        return VariantAnswers(self._limits, given, tracked, found)

    def _path(self, numbers: VariantNumbers, refused: NDArray[np.bool_]) -> dict[str, Array]:
        """The motion of the object, as `mrts.kernel.tracking.PATH` with V or 1 first; refused ones last a second."""
        if not numbers.any_of(PATH_ENDS):
            return {name: getattr(self._motion, name)[None] for name in PATH}
        u = np.linspace(0.0, 1.0, len(self._motion.time))
        start, end, turned, turning, duration = (
            np.broadcast_to(numbers[name], (numbers.count, *numbers[name].shape[1:]))
            for name in ("start_xyz", "end_xyz", "start_rpy", "end_rpy", "duration")
        )
        duration = np.where(refused, 1.0, duration)
        positions, rotations = np.stack([start, end], axis=1), rotations_from_rpy(np.stack([turned, turning], axis=1))
        profile = PROFILES[self._study.motion["profile"]]
        rates = geodesic_rates(positions, rotations, duration, profile(u))
        return dict(zip(PATH, (duration[:, None] * u, *rates), strict=True))

    def _first_looked_at(self, ends: NDArray[Any]) -> NDArray[np.intp]:
        """The samples in the order in which they are looked at, Shape (N,): given ones, some of all, the rest."""
        samples = len(self._motion.time)
        order = [*(end for end in ends.tolist() if end >= 0), *range(0, samples, STRIDE), *range(samples)]
        return np.array(list(dict.fromkeys(order)))


def _tilted(cell: Cell, geometry: Array) -> NDArray[np.bool_]:
    """Variants of a planar cell of which a base or a hand may be tilted out of the plane, Shape (V or 1,)."""
    normal = plane_normal(cell.plane or "xy")
    tilted = np.zeros(len(geometry), dtype=bool)
    for index, robot in enumerate(cell.robots):
        first = GRAVITY_SIZE + ROBOT_SIZE * index
        for start, turned in ((first, np.eye(3)), (first + ROBOT_SIZE // 2, robot.T_base_tip.R)):
            rotation = geometry[:, start : start + 9].reshape(-1, 3, 3)
            along = normal @ rotation @ turned.T
            tilted |= np.max(np.abs(along - normal), axis=1) > NEAR_A_RULE
    return tilted
