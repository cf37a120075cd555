# SPDX-License-Identifier: MIT
"""The fastest admissible r(t): a speed that varies along the path, where `mrts.scale` keeps its factor constant."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType

import numpy as np

from mrts.base.argument_types import Progress, check_callable, check_type, is_number
from mrts.base.arrays import Array
from mrts.base.errors import InputError, SolverError
from mrts.base.input_file import LARGEST_NUMBER
from mrts.base.load_box import LoadPoint
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.coordination.grasp_closure import ClosureBound
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.reachability.fastest_profile import Obstacle, SpeedProfile, fastest_profile
from mrts.reachability.speed_conflict import sample_conflict, segment_conflict
from mrts.reachability.speed_regions import SpeedRegions, intersect_regions, speed_regions
from mrts.reachability.successive_profiles import successive_profiles
from mrts.refinement.excess import BETWEEN, checked_tolerance
from mrts.retiming.between_samples import refined_timing
from mrts.retiming.path_pieces import NoPath, PathPiece, closed_piece, path_pieces
from mrts.retiming.result import RetimingResult, RetimingStatus
from mrts.retiming.retimed_motion import TimedPiece, retimed_motion
from mrts.samples import DistributionName
from mrts.samples.infeasibility import Conflict
from mrts.samples.load_sharing import LoadSharing
from mrts.samples.sample_problem import SampleProblem, build_sample_problem
from mrts.samples.trajectory_programs import motion_ranges
from mrts.scaling.guaranteed_range import effective_parameters
from mrts.scaling.motion_remarks import lasting
from mrts.scaling.range import intersect
from mrts.scaling.result import DistributionRule, ScalingResult
from mrts.scaling.scale import SelectionError, load_question, scale
from mrts.scaling.with_torques import with_torques
from mrts.solvers import DEFAULT_SOLVER

UNBOUNDED_SHARE = 0.5
"""Speeds squared above this share of the bound of the regions are those that nothing limits."""

STUCK = 1e6
"""A segment that takes this many times as long as most others takes no finite time, but for rounding."""


def retime(
    cell: Cell,
    motion: ObjectMotion | JointTable | CoordinatedMotion,
    *,
    sharing: LoadSharing | None = None,
    weights: Array | None = None,
    load: str = "auto",
    distribute: DistributionName = "least-torque",
    reserve: float | None = None,
    closure: ClosureBound | None = None,
    start_speed: float = 0.0,
    end_speed: float = 0.0,
    between: float | None = BETWEEN,
    progress: Progress = lambda _done, _total: None,
) -> RetimingResult:
    """Find the fastest r(t) within all limits, and distribute its torques.

    The time of the given motion is the path parameter r; how fast it is given only spaces the samples. Limits hold at
    both ends of every segment between samples (the interpolation scheme of Pham and Pham, IEEE T-RO 34(3), 2018); the
    polygons of admissible (r̈, ṙ²) are projections over all contact wrenches (for redundant actuation see Pham and
    Stasse, IEEE/ASME T-MECH 20(6), 2015). Where the load is uncertain, they are intersected over the corners of its
    box; docs/optimal_profile.md has the proof.

    Args:
        cell: The cell.
        motion: Motion of the object, a table of joint motion, or motion of the whole cell.
        sharing: A fixed distribution of the load; None leaves it free.
        weights: W of the quadratic program, as in `mrts.scale`.
        load: "guaranteed" (for every load of the box) or "nominal"; "auto" is "guaranteed" if the cell has a load box.
        distribute: As in `mrts.scale`.
        reserve: Likewise.
        closure: Likewise.
        start_speed: ṙ at the start, where the given motion does not start from rest [1].
        end_speed: ṙ at the end, likewise [1].
        between: As in `mrts.scale`; what is left above it is told in the first sentence.
        progress: Told how many of how many loads are done.

    Returns:
        The outcome; where no timing is admissible, its `explanation` says why.

    Raises:
        InputError: If an argument breaks a rule.
        MotionError: If the arms cannot follow the object.
        SolverError: If no solver answers.
    """
    question = _checked_question(cell, sharing, load, start_speed, end_speed, progress)
    rule, tolerance = DistributionRule(sharing, "wrench", weights, distribute), checked_tolerance(between)
    constant = _best_constant(cell, motion, rule, question, reserve, closure, between)

    def timed(path: CoordinatedMotion) -> RetimingResult:
        return _fastest(replace(constant, motion=path), question, (start_speed, end_speed), progress)

    found, adds = replace(timed(constant.motion), constant=constant), tolerance is not None
    return refined_timing(found, timed, BETWEEN if tolerance is None else tolerance, adds=adds)


def _fastest(
    constant: ScalingResult, question: str, end_speeds: tuple[float, float], progress: Progress
) -> RetimingResult:
    """The fastest timing with limits kept at the samples of a motion.

    Args:
        constant: The best constant factor of the motion.
        question: That is asked of the load.
        end_speeds: ṙ at the start and at the end.
        progress: Told how many of how many loads are done.
    """
    cell, motion, (start_speed, end_speed) = constant.cell, constant.motion, end_speeds
    points: tuple[LoadPoint | None, ...] = (None,)
    if question == "guaranteed" and cell.load_box is not None:
        points = cell.load_box.corners(effective_parameters(cell, motion, cell.load_box, ("P", "Q", "S")))
    loads = tuple(cell.load if point is None else point.load for point in points)
    pieces = path_pieces(motion)
    if isinstance(pieces, NoPath):
        status, why = _no_path(pieces, motion.object.time)
        return RetimingResult(cell, motion, status, why, constant, loads)
    given = (("start_speed", start_speed, pieces[0].rests[0]), ("end_speed", end_speed, pieces[-1].rests[1]))
    for name, speed, rests in given:
        if speed > 0 and rests:
            raise InputError(name, "the given motion is at rest there, so no other speed is possible.", value=speed)
    timed: list[TimedPiece] = []
    for number, piece in enumerate(closed_piece(cell, part) for part in pieces):
        ends = tuple(
            0.0 if rests else (speed * float(piece.speed[place])) ** 2
            for rests, speed, place in zip(piece.rests, (start_speed, end_speed), (0, -1), strict=True)
        )
        search = _Search(constant, piece, points, (ends[0], ends[1]))
        progress(number, len(pieces))
        found = search.run(progress if len(pieces) == 1 else lambda _done, _total: None)
        if isinstance(found, _Failure):
            return RetimingResult(cell, motion, *found.reason, constant, loads, conflict=found.conflict)
        timed.append(found)
    whole = RetimingResult(
        cell=cell,
        motion=motion,
        status=RetimingStatus.OPTIMAL,
        explanation="",
        constant=constant,
        loads=loads,
        pieces=tuple(timed),
    )
    return replace(whole, retimed=_with_torques(constant, whole.pieces))


def _checked_question(
    cell: Cell, sharing: LoadSharing | None, load: str, start_speed: float, end_speed: float, progress: Progress
) -> str:
    """The question asked of the load, if all arguments keep their rules."""
    check_type("cell", cell, Cell)
    check_type("sharing", sharing, LoadSharing, NoneType)
    check_callable("progress", progress)
    for name, speed in (("start_speed", start_speed), ("end_speed", end_speed)):
        if not is_number(speed, 0, LARGEST_NUMBER):
            rule = f"must be a number from 0 to {LARGEST_NUMBER:.0e}, a multiple of the given motion's speed."
            raise InputError(name, rule, value=speed)
    if sharing is not None and sharing.internal_wrench is not None and np.ndim(sharing.internal_wrench) > 1:
        raise InputError("sharing", "its internal wrench must be one for all samples where the speed varies.")
    question = load_question(cell, load, "auto")
    if question not in {"guaranteed", "nominal"}:
        raise InputError("load", "must be guaranteed or nominal where the speed varies.", value=load)
    return question


def _best_constant(
    cell: Cell,
    motion: ObjectMotion | JointTable | CoordinatedMotion,
    rule: DistributionRule,
    question: str,
    reserve: float | None,
    closure: ClosureBound | None,
    between: float | None,
) -> ScalingResult:
    """The best constant factor; without a trajectory where none moves the object, which a varying speed may."""
    try:
        return scale(
            cell,
            motion,
            sharing=rule.sharing,
            weights=rule.weights,
            load=question,
            distribute=rule.distribute,
            reserve=reserve,
            closure=closure,
            between=between,
        )
    except SelectionError as error:
        if error.result is None:
            raise
        return error.result


def _no_path(found: NoPath, time: Array) -> tuple[RetimingStatus, str]:
    """Outcome and explanation."""
    if found.kind == "zero length":
        return RetimingStatus.ZERO_LENGTH, "neither the object nor a joint moves: the path has no length."
    where = f"from t = {time[found.sample]:.6g} to {time[found.sample + 1]:.6g} s"
    if found.kind == "wait":
        return RetimingStatus.STATIONARY, (
            f"the motion stands still {where}: a wait is no part of a path. Cut it out, or retime what is before and "
            "after it by themselves."
        )
    return RetimingStatus.STATIONARY, (
        f"the motion turns back on itself {where}, so it stops between two samples. Give a sample at the turning "
        "point, or retime what is before and after it by themselves."
    )


def _with_torques(constant: ScalingResult, pieces: Sequence[TimedPiece]) -> ScalingResult:
    """The retimed motion with the torques of the quadratic program (31) to (34), as a result at c² = 1."""
    cell, motion, rule = constant.cell, retimed_motion(constant.motion, pieces), constant.rule
    found = intersect(motion_ranges(cell, motion, rule.formulation, rule.sharing, DEFAULT_SOLVER))
    given, duration = constant.motion.object.time[-1], motion.object.time[-1]
    origin = f"fastest timing of a path that was given {given:.4g} s: {duration:.4g} s"
    warnings = lasting(constant.warnings)
    played = ScalingResult(
        cell=cell,
        motion=motion,
        range=found,
        trajectory=None,
        fallbacks=found.samples.fallbacks,
        load=None,
        rule=rule,
        origin=origin,
        warnings=warnings,
    )
    return with_torques(played, 1.0, found.samples, DEFAULT_SOLVER)


@dataclass(frozen=True)
class _Failure:
    """Why a piece of a path has no profile: outcome and explanation, and the limits that conflict if they do."""

    reason: tuple[RetimingStatus, str]
    conflict: Conflict | None = None


@dataclass(frozen=True)
class _Search:
    """The search for the profile of one piece, and for the reason if there is none."""

    constant: ScalingResult
    piece: PathPiece
    points: tuple[LoadPoint | None, ...]
    ends: tuple[float, float]

    def run(self, progress: Progress) -> TimedPiece | _Failure:
        """The fastest profile, or why there is none."""
        parts, with_root = [], []
        for number, point in enumerate(self.points):
            progress(number, len(self.points))
            problem = self._problem(point)
            if problem.speed is None:
                parts.append(speed_regions(problem, float(np.sum(self.piece.step)), self.ends))
            else:
                with_root.append(problem)
        if with_root:
            steps = successive_profiles(with_root, self.piece.step, self.ends)
            progress(len(self.points), len(self.points))
            if isinstance(steps, Obstacle):
                return self._explained(steps)
            return self._unusual(steps[-1].profile, steps[-1].regions) or TimedPiece(
                self.piece, steps[-1].regions, steps[-1].profile
            )
        progress(len(self.points), len(self.points))
        regions = parts[0] if len(parts) == 1 else intersect_regions(parts)
        for sample in regions.undecided:
            conflict = self._conflict(sample)
            if conflict is None:
                raise SolverError(
                    f"the admissible speeds at {self._place(sample)} were not found, although its limits hold "
                    "together. This is a defect of mrts or of extremely scaled data: please report cell and motion."
                )
            return _Failure((RetimingStatus.INFEASIBLE, f"{conflict}."), conflict)
        found = fastest_profile(self.piece.step, regions, self.ends)
        if isinstance(found, Obstacle):
            return self._explained(found)
        return self._unusual(found, regions) or TimedPiece(self.piece, regions, found)

    def _unusual(self, found: SpeedProfile, regions: SpeedRegions) -> _Failure | None:
        """A profile that takes no time, or for ever."""
        fastest = int(np.argmax(found.x))
        if found.x[fastest] >= UNBOUNDED_SHARE * regions.bound:
            why = f"nothing limits the speed at {self._place(fastest)}. Give velocity limits."
            return _Failure((RetimingStatus.UNBOUNDED, why))
        with np.errstate(divide="ignore"):
            times = TimedPiece(self.piece, regions, found).segment_times
        stuck = ~(times <= STUCK * np.median(times)) | np.isinf(times)
        if not np.any(stuck):
            return None
        why = f"the limits let the cell only hold still at {self._place(int(np.argmax(stuck)))}"
        upper = self.constant.range.upper
        why += "." if upper is None or upper.time is None else f"; c² is limited {upper.place()}."
        return _Failure((RetimingStatus.STANDSTILL, why))

    def _explained(self, obstacle: Obstacle) -> _Failure:
        k, reach = obstacle.sample, obstacle.reach
        for sample in (k, k + 1) if obstacle.kind == "segment" else (k,):
            conflict = self._conflict(sample)
            if conflict is not None:
                return _Failure((RetimingStatus.INFEASIBLE, f"{conflict}."), conflict)
        if obstacle.kind != "segment":
            return self._wrong_end(obstacle)
        conflict = self._conflict(k, reach)
        low, high = (np.sqrt(x) / self.piece.speed[k + 1] if self.piece.speed[k + 1] > 0 else 0.0 for x in reach)
        why = (
            f"no speed at {self._place(k)} leads on to where the end can still be reached, ṙ in [{low:.6g}, "
            f"{high:.6g}] at the next sample{_rows(conflict)}. Change the path or its end speeds, or raise a limit."
        )
        return _Failure((RetimingStatus.NOT_CONTROLLABLE, why), conflict)

    def _wrong_end(self, obstacle: Obstacle) -> _Failure:
        start = obstacle.kind == "start"
        speed, given = self.piece.speed[obstacle.sample], self.ends[0 if start else 1]
        place, status = self._place(obstacle.sample), RetimingStatus.START_SPEED if start else RetimingStatus.END_SPEED
        conflict = self._conflict(obstacle.sample, obstacle.next_reach, given)
        if given == 0:
            why = f"the motion cannot {'start from' if start else 'come to'} rest at {place}{_rows(conflict)}."
            return _Failure((status, why), conflict)
        low, high = (np.sqrt(x) / speed for x in obstacle.reach)
        why = (
            f"at {place} the motion may {obstacle.kind} with ṙ in [{low:.6g}, {high:.6g}], but "
            f"{np.sqrt(given) / speed:.6g} is asked for{_rows(conflict)}. Give another {obstacle.kind} speed, "
            "or a motion that is at rest there."
        )
        return _Failure((status, why), conflict)

    def _place(self, sample: int) -> str:
        sample += self.piece.first
        return f"t = {self.constant.motion.object.time[sample]:.6g} s (sample {sample})"

    def _problem(self, point: LoadPoint | None) -> SampleProblem:
        load = None if point is None else point.load
        cell, sharing = self.constant.cell, self.constant.rule.sharing
        return build_sample_problem(cell, self.piece.path, sharing=sharing, load=load, varying=True)

    def _conflict(
        self, sample: int, reach: tuple[float, float] | None = None, x: float | None = None
    ) -> Conflict | None:
        """The limits that conflict at a sample, or on the segment from it into the reach, with the worst load."""
        time = self.constant.motion.object.time[self.piece.first :]
        worst: Conflict | None = None
        for point in self.points:
            if reach is None:
                found = sample_conflict(self._problem(point), time, sample, x)
            else:
                step = float(self.piece.step[sample])
                found = segment_conflict(self._problem(point), time, sample, step, reach, x)
            if found is not None and (worst is None or found.widening > worst.widening):
                worst = replace(found, sample=self.piece.first + sample, load=point)
        return worst


def _rows(conflict: Conflict | None) -> str:
    """The limits that conflict, as the end of a sentence."""
    if conflict is None:
        return ""
    load = "" if conflict.load is None else f" with {conflict.load}"
    return f"; these conflict{load}: {'; '.join(str(row) for row in conflict.rows)}"
