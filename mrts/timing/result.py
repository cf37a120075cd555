# SPDX-License-Identifier: MIT
"""A motion played with a speed that varies along its path, what limits it, or why there is none."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Remark, printable
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import WHOLE_WAY, polynomial_weights
from mrts.kernel.binding import filled, structure
from mrts.limits.rows import ActiveRow, RowName
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.rows_at_rest import pushing_ends
from mrts.program.between_samples import Excess
from mrts.program.infeasibility import Conflict
from mrts.program.motion_rows import motion_rows, travel_directions
from mrts.program.path_solver import CONVERGED, StepsTaken
from mrts.program.sample_problem import SampleProblem
from mrts.program.sample_ranges import RangeStatus, motion_ranges
from mrts.program.smooth_program import SmoothProgram, segment_times
from mrts.program.torque_distribution import torque_weights
from mrts.scaling.options import Options
from mrts.scaling.remarks import motion_remarks
from mrts.scaling.scale import Result, ScalingResult, SelectionError, chosen_factor, kept_text, with_torques
from mrts.scaling.scaled_trajectory import LimitUse, integral
from mrts.scaling.what_if import SpeedAnswer, SpeedQuestion, WhatIf
from mrts.timing.fastest_profile import SpeedProfile
from mrts.timing.path_pieces import PLACES, STRIDE, PathPiece, SmoothPath

BINDING = 1e-6
"""A limit binds where the motion could be no faster by more than this share of c²."""

ONLY_AT_SAMPLES = " at samples only"
"""Of a profile whose limits hold at the samples, and less well between them."""

AT_PLACES = polynomial_weights(PLACES)
"""Found once: to find them takes 1 % of a short timing."""

JOINT_PATH = structure("arm_tips.c", "mrts_joint_path")

AT_LIMIT = 1e-4
"""A limit binds where it is reached to this share: interior points come near limits, not to them."""


@dataclass(frozen=True, kw_only=True)
class TimedPiece:
    """A piece of a path with its speed.

    Attributes:
        piece: The piece, n samples; its time is the path parameter σ.
        x: σ̇² at the samples, Shape (n,).
        rates: σ̈ at the start and at the end of every segment, linear in between, Shape (n - 1, 2).
        profile: Of a fastest timing: x with the admissible (σ̈, σ̇²) in which it is the fastest.
    """

    piece: PathPiece
    x: Array
    rates: Array
    profile: SpeedProfile | None = None

    @cached_property
    def segment_times(self) -> Array:
        """Duration of each segment, Shape (n - 1,) [s]; of a smooth one, what the limits of rates were kept with."""
        return segment_times(self.piece.step, self.x, None if self.profile is None else self.profile.rise)

    def along_arc(self, x: Array) -> Array:
        """Speeds ṡ along the arc length at the samples, for some σ̇² there, Shape (n,)."""
        speed: Array = self.piece.arc_speed * np.sqrt(x)
        return speed

    def to_json(self, time: Array) -> dict[str, list[float | None]]:
        """The profile as JSON values, along the arc length; `time` of the given motion, Shape (N,) [s]."""
        own, speeds = time[self.piece.first :][: len(self.x)], {"speed": self.x}
        if self.profile is not None:
            speeds |= {"least_controllable": self.profile.lower, "largest_controllable": self.profile.upper}
            speeds["largest"] = self.profile.regions.upper
        along = {name: self.along_arc(x).tolist() for name, x in speeds.items()}
        finite = {name: [speed if np.isfinite(speed) else None for speed in of] for name, of in along.items()}
        return {"r": own.tolist(), "s": self.piece.arc.tolist(), **finite}


@dataclass(frozen=True, kw_only=True)
class SmoothPiece(TimedPiece):
    """A piece with its smooth timing, by σ.

    Attributes:
        program: All limits of it, for all loads.
        steps: How the timing was found.
        carried: Free wrenches of the timing for each load, Shape (n, f).
        plan: Free wrenches that carry the cell's own load: of the least torques within all limits and rates where it
            is delivered, Shape (n, f).
        problem: Rows of the own load at the nodes.
        own: All limits of it.
    """

    piece: SmoothPath
    program: SmoothProgram
    steps: StepsTaken
    carried: tuple[Array, ...]
    plan: Array
    problem: SampleProblem
    own: SmoothProgram

    def between(self) -> tuple[NDArray[np.int_], NDArray[np.int_], Array, Array, Array]:
        """The fine samples that are not nodes: which, segment, place in it, x and u there, each Shape (k,)."""
        fine, step = self.piece.fine, self.piece.step
        inside = np.flatnonzero(np.arange(fine.samples) % STRIDE)
        segment = inside // STRIDE
        after = fine.object.time[inside] - self.piece.path.object.time[segment]
        place, start, change = after / step[segment], self.rates[segment, 0], np.diff(self.rates)[segment, 0]
        x = self.x[segment] + 2 * after * (start + change * place / 2)
        return inside, segment, place, x, start + change * place


class RetimingStatus(Enum):
    """Outcome of retiming."""

    OPTIMAL = "optimal"
    AT_SAMPLES = f"optimal{ONLY_AT_SAMPLES}"
    LOCALLY_OPTIMAL = "locally optimal"
    LOCALLY_AT_SAMPLES = f"locally optimal{ONLY_AT_SAMPLES}"
    RATES_TOO_SMALL = "rates too small"
    TOO_SHORT = "duration too short"
    INFEASIBLE = "infeasible"
    NOT_CONTROLLABLE = "not controllable"
    START_SPEED = "start speed not admissible"
    END_SPEED = "end speed not admissible"
    STANDSTILL = "standstill"
    STATIONARY = "stationary"
    ZERO_LENGTH = "zero length"
    UNBOUNDED = "unbounded"

    @property
    def admits_motion(self) -> bool:
        """Whether there is a profile."""
        return self.value.removesuffix(ONLY_AT_SAMPLES) in {"optimal", "locally optimal"}


@dataclass(frozen=True)
class SmoothAnswer:
    """What a smooth timing is beside its profile.

    Attributes:
        longest: The duration within which its effort is least; None where the duration is least [s].
        steps: Convex programs solved, for all pieces and in all rounds of refinement.
        gain: Share by which the last of them lowered the cost; None where no solver took a last one.
        room: Share of the duration of the local optimum that it takes longer, to keep most of every limit in reserve.
        fastest: The path with its fastest timing without limits of rates; empty if nothing bounds it.
    """

    longest: float | None
    steps: int
    gain: float | None
    room: float = 0.0
    fastest: tuple[TimedPiece, ...] = ()

    @property
    def bound(self) -> float | None:
        """Duration of the fastest timing without limits of rates, below which none is, as exact as the samples of both.

        None if nothing bounds it [s].
        """
        return float(new_times(self.fastest)[-1]) if self.fastest else None

    def text(self, duration: float) -> str:
        """How the timing was found, and how long it takes at least, where it takes a duration [s]."""
        count = "1 step" if self.steps == 1 else f"{self.steps} steps"
        verb = f"takes {100 * self.room:.2g} % longer than" if self.room else "is"
        text = f"It {verb} a local optimum, found in {count}, of which the last gained {100 * (self.gain or 0.0):.2g} %"
        if self.gain is None:
            text = f"It was found in {count}, after which no solver took another: a better one may be near"
        elif self.gain >= CONVERGED:
            text = f"It was found in {count}, the last of which gained {100 * self.gain:.2g} %: a better one is near"
        if self.bound is None:
            return text
        if duration <= self.bound:
            return f"{text}; to within its samples that is as long as the fastest without limits of rates takes"
        return f"{text}; no timing takes less than {self.bound:.4g} s, the fastest without limits of rates"

    def to_json(self) -> dict[str, Any]:
        """The answer as JSON values."""
        return {
            "longest": self.longest,
            "bound": self.bound,
            "steps": self.steps,
            "last_gain": self.gain,
            "room": self.room,
        }


@dataclass(frozen=True, repr=False)
class RetimingResult(Result):
    """What `mrts.retime` found.

    Attributes:
        cell: The cell.
        motion: The given motion with the samples that were added; its time is the path parameter r.
        given: The motion as it was given.
        options: What was asked.
        status: The outcome.
        explanation: Why there is no profile; empty if there is one.
        conflict: The limits that conflict, where limits are the reason.
        loads: Load vectors that the profile carries, each Shape (10,).
        pieces: The path from stop to stop with its fastest speed; empty if there is none.
        retimed: The motion at the fastest timing with its torques, as a result at c² = 1; None without a profile.
        excess: How far limits are overstepped between the samples; None without a profile.
        smooth: What is known of a timing with limits of rates; None without them, or without any timing.
        end_speeds: ṙ at the start and at the end, where the given motion does not rest there.
        changes: What changes to the cell would do, from `what_if`, where it is to be shown with the result.
    """

    cell: Cell
    motion: CoordinatedMotion
    given: CoordinatedMotion
    options: Options
    status: RetimingStatus = RetimingStatus.OPTIMAL
    explanation: str = ""
    conflict: Conflict | None = None
    loads: tuple[Array, ...] = ()
    pieces: tuple[TimedPiece, ...] = ()
    retimed: ScalingResult | None = None
    excess: Excess | None = None
    smooth: SmoothAnswer | None = None
    end_speeds: tuple[float, float] = (0.0, 0.0)
    changes: WhatIf | None = None

    def part_along(self, piece: PathPiece, motion: CoordinatedMotion) -> tuple[int, NDArray[np.intp]] | None:
        """Which of the pieces was this one before samples were added to the motion, and where they are in it now.

        None where none was, or the path has other derivatives now.
        """
        path, time = piece.path, motion.object.time[piece.first :][: piece.path.samples]
        for number, part in enumerate(self.pieces):
            old = part.piece.path
            theirs = self.motion.object.time[part.piece.first :][: old.samples]
            if theirs[0] == time[0] and theirs[-1] == time[-1]:
                own = np.searchsorted(time, theirs)
                dq, ddq = path.dq.take(own, axis=0), path.ddq.take(own, axis=0)
                return (number, own) if np.array_equal(dq, old.dq) and np.array_equal(ddq, old.ddq) else None
        return None

    @property
    def what(self) -> str:
        """What the timing is, for people."""
        if self.smooth is None:
            return "fastest timing"
        longest = self.smooth.longest
        return "smooth timing" + ("" if longest is None else f" of least energy within {longest:g} s")

    @cached_property
    def factor(self) -> ScalingResult:
        """The best constant factor of the given motion, for comparison; without a c² where none moves the object."""
        try:
            return chosen_factor(self.cell, self.given, self.options)[0]
        except SelectionError as error:
            return error.result

    @cached_property
    def constant(self) -> ScalingResult:
        """`factor` with its torques."""
        return with_torques(self.factor)

    @cached_property
    def duration(self) -> float | None:
        """Of the fastest timing [s]; None without one."""
        return float(new_times(self.pieces)[-1]) if self.pieces else None

    @property
    def effort(self) -> float | None:
        """∫ τᵀWτ dt of the motion at the timing [s; N² m² s with W = 1]; None without one."""
        done = None if self.retimed is None else self.retimed.trajectory
        if done is None:
            return None
        W = torque_weights(self.options.weights, self.cell)
        return integral(done.time, np.einsum("ni,ij,nj->n", done.torque, W, done.torque))

    @property
    def saving(self) -> float | None:
        """Share of the best constant factor's duration that is saved; None where that motion starts or ends moving."""
        best, duration = self.factor.duration, self.duration
        if best is None or duration is None or self.factor.status is RangeStatus.UNBOUNDED:
            return None
        if not (self.pieces[0].piece.rests[0] and self.pieces[-1].piece.rests[1]):
            return None
        return 1 - duration / best

    @property
    def stops(self) -> Array:
        """Times of the given motion where it stops on its way, Shape (k,) [s]."""
        return self.motion.object.time[[part.piece.first for part in self.pieces[1:]]]

    @property
    def made_room(self) -> bool:
        """Whether it takes longer than the fastest, to keep a reserve: `limits` are then those of the fastest."""
        return self.smooth is not None and self.smooth.room > 0

    @cached_property
    def limits(self) -> list[tuple[str, float]]:
        """What limits the speed, for which share of the duration, most first."""
        return self._shares(str)

    def _shares(self, told: Callable[[ActiveRow | RowName], Any]) -> list[tuple[Any, float]]:
        """For which share of the duration something told of rows limits the speed, most first."""
        shares: dict[Any, float] = {}
        for rows, share in self.segment_limits:
            for what in dict.fromkeys(map(told, rows)):
                shares[what] = shares.get(what, 0.0) + share
        return sorted(shares.items(), key=lambda entry: (-entry[1], str(entry[0])))

    @cached_property
    def segment_limits(self) -> list[tuple[tuple[ActiveRow | RowName, ...], float]]:
        """What limits the speed on every segment between two samples, and the segment's share of the duration.

        Rows; of a smooth timing their names.
        """
        found: list[tuple[tuple[ActiveRow | RowName, ...], float]] = []
        for part in self.pieces:
            shares = (part.segment_times / new_times(self.pieces)[-1]).tolist()
            limited = zip(self._binding(part), shares, strict=True)
            found += [(tuple(sorted(rows, key=str)), share) for rows, share in limited]
        return found

    @property
    def uses(self) -> list[LimitUse]:
        """How much of each limit is used, rates too, by falling share; nothing without a profile."""
        return [] if self.retimed is None else self.retimed.uses

    def setting_rows(self) -> list[RowName]:
        """What limits the speed somewhere along the path, by falling share of the duration."""
        return [name for name, _ in self._shares(lambda row: row if isinstance(row, RowName) else row.name)]

    def _binding(self, part: TimedPiece) -> Sequence[Iterable[ActiveRow | RowName]]:
        """The limits that bind on every segment; those of a smooth timing are reached.

        A point of a region's edge is one where the motion, faster or slower as a whole, would have c² <= 1; the rows
        that bind there are the edge's.
        """
        if isinstance(part, SmoothPiece):
            return part.program.binding(part.steps.best, AT_LIMIT)
        sharing, bound = self.options.sharing, [set[ActiveRow]() for _ in part.piece.step]
        for motion in at_segment_ends(part):
            rows = motion_rows(self.cell, motion, sharing)
            for load in self.loads:
                found = motion_ranges(rows, load, 1 + BINDING)
                for segment in np.flatnonzero(found.upper <= 1 + BINDING).tolist():
                    bound[segment] |= {*found.binding(segment, "upper")}
        return bound

    @property
    def warnings(self) -> tuple[Remark, ...]:
        """What to know of the cell and the motion before trusting the answer."""
        if self.retimed is not None:
            return self.retimed.warnings
        return motion_remarks(self.cell, self.given, self.given)

    def speed_question(self) -> SpeedQuestion:
        """How long a changed cell takes at least, at the samples of this timing.

        Raises:
            InputError: If rates were limited: such a timing takes seconds.
        """
        from mrts.timing.fastest_timing import fastest_timing  # noqa: PLC0415 (it makes results)

        if self.smooth is not None:
            rule = "within limits of rates it would be timed again for every change, seconds each. Ask without rates."
            raise InputError("what if", rule)
        asked = replace(self, options=replace(self.options, rates=None, between=None))

        def answer(cell: Cell, motion: CoordinatedMotion, _before: SpeedAnswer | None) -> SpeedAnswer:
            timed = fastest_timing(replace(asked, cell=cell, given=motion), motion)
            if not timed.status.admits_motion:
                return SpeedAnswer(status=timed.status.value, reason=timed.explanation)
            limits = tuple(dict.fromkeys(name.short for name in timed.setting_rows()))
            return SpeedAnswer(status="feasible", duration=timed.duration, limits=limits)

        return self.cell, self.motion, answer

    def sentence(self) -> str:
        """The outcome alone."""
        kept = kept_text(self.cell.reserve)
        if not self.status.admits_motion:
            return printable(f"{kept}{self.status.value}: {self.explanation}")
        given, best = float(self.motion.object.time[-1]), self.factor
        compared = " along a path without times" if self.given.untimed else f", the given one {given:.4g} s"
        text = f"{kept}the {self.what} takes {self.duration:.4g} s{compared}"
        if self.saving is not None and not self.given.untimed:
            less = "less" if self.saving >= 0 else "more"
            text += f"; {100 * abs(self.saving):.3g} % {less} than {best.duration:.4g} s at the best constant c² = "
            text += f"{best.c2:.4g}"
            if self.options.rates is not None and any(pushing_ends(best.motion.dq, best.motion.ddq)):
                text += ", whose torques jump at its ends"
        if self.stops.size:
            text += f". It stops at t = {', '.join(f'{time:.4g}' for time in self.stops)} s of the given motion"
        if self.smooth is not None and self.duration is not None:
            text += f". {self.smooth.text(self.duration)}"
        excess = self.excess if self.retimed is None else self.retimed.excess  # the latter in the time of the timing
        if excess is not None and excess.passes:
            text += f". But {excess}" if self.stops.size or self.smooth is not None else f"; but {excess}"
        return f"{text}."

    def to_json(self) -> dict[str, Any]:
        """The outcome as JSON values; null stands for what nothing bounds."""
        output: dict[str, Any] = {
            **self.said_json(),
            "status": self.status.value,
            "explanation": self.explanation or None,
            "duration": self.duration,
            "saving": self.saving,
            "constant": self.factor.range.to_json(),
            "conflict": None if self.conflict is None else [row.to_json() for row in self.conflict.rows],
            "smooth": self.smooth and self.smooth.to_json() | {"effort": self.effort},
            "kept_rates": self.smooth and self.options.rates and self.options.rates.to_json(),
        }
        done = None if self.retimed is None else self.retimed.trajectory
        if self.retimed is None or done is None or self.excess is None:
            return output
        time = self.motion.object.time
        at = self.excess.time or 0.0
        output["excess"] = self.excess.to_json() | {"sample": int(np.searchsorted(time, at, side="right")) - 1}
        output["limits"] = [{"limit": name, "share_of_duration": share} for name, share in self.limits]
        output["stops"] = self.stops.tolist()
        output["profile"] = [part.to_json(time) for part in self.pieces]
        return output | self.retimed.played_json(done)


def smooth_parts(pieces: Sequence[TimedPiece]) -> list[SmoothPiece]:
    """The pieces of a smooth timing; none of another one."""
    return [part for part in pieces if isinstance(part, SmoothPiece)]


def new_times(pieces: Sequence[TimedPiece]) -> Array:
    """Times of all samples of a path in pieces, Shape (N,) [s]."""
    times: Array = np.concatenate([[0.0], *[part.segment_times for part in pieces]]).cumsum()
    return times


def retimed_motion(motion: CoordinatedMotion, pieces: Sequence[TimedPiece]) -> CoordinatedMotion:
    """The given samples at their new times.

    Where s̈ jumps at a sample it is the mean of before and after, which limits admit as they admit both. So is the
    direction of travel at a stop, where friction jumps with it.
    """
    played = []
    for part in pieces:
        rates, path = part.rates, part.piece.path
        at_samples = np.concatenate([rates[:1, 0], (rates[:-1, 1] + rates[1:, 0]) / 2, rates[-1:, 1]])
        own = path.played(path.object.time, np.sqrt(part.x)[:, None], at_samples[:, None])
        played.append((own.dq, own.ddq, own.object.twist, own.object.acceleration, *travel_directions(path)))
    dq, ddq, twist, acceleration, *travel = map(_joined, zip(*played, strict=True))
    of = motion.object
    carried = ObjectMotion(new_times(pieces), of.position, of.rotation, twist, acceleration, checked=False)
    return CoordinatedMotion(carried, motion.q, dq, ddq, travel=np.array(travel), checked=False)


def smooth_torques(pieces: Sequence[TimedPiece]) -> tuple[Array, Array]:
    """Torques and wrenches of a smooth timing, Shape (N, m) and (N, n w); at a stop they are alike on both sides."""
    parts = smooth_parts(pieces)
    unknowns = [np.column_stack([part.plan, part.steps.profile.u, part.x]) for part in parts]
    torques = _joined([part.problem.torque(of) for part, of in zip(parts, unknowns, strict=True)])
    return torques, _joined([part.problem.wrench(of) for part, of in zip(parts, unknowns, strict=True)])


def _joined(parts: Sequence[Array]) -> Array:
    """Values of pieces in a row; where two meet, their mean."""
    rows = parts[0]
    for part in parts[1:]:
        rows = np.concatenate([rows[:-1], (rows[-1:] + part[:1]) / 2, part[1:]])
    return rows


def at_segment_ends(part: TimedPiece) -> tuple[CoordinatedMotion, CoordinatedMotion]:
    """The starts and the ends of all segments, each with the s̈ of its segment; their time only counts them."""
    path, speed, travel = part.piece.path, np.sqrt(part.x)[:, None], travel_directions(part.piece.path)
    start, end = (
        path.at(side).played(np.arange(len(rate), dtype=np.float64), speed[side], rate[:, None], travel[:, side])
        for side, rate in zip((slice(None, -1), slice(1, None)), part.rates.T, strict=True)
    )
    return start, end


def between_path_samples(cell: Cell, part: TimedPiece, segments: NDArray[np.intp]) -> CoordinatedMotion:
    """The retimed motion at `PLACES` inside some segments, with dq/ds on the polynomials of `velocity_polynomials`.

    Args:
        segments: Which, in order, Shape (s,).

    Returns:
        The motion at p s samples, segment after segment; its time is the path parameter, from the first place on.
    """
    path, library = part.piece.path, cell.library
    joints = {"time": path.object.time, "q": path.q, "dq": path.dq, "ddq": path.ddq}
    along = filled(JOINT_PATH, **joints, weight=AT_PLACES, at=PLACES, whole=WHOLE_WAY, places=len(PLACES))
    count = len(PLACES) * len(segments)
    found = [np.empty((count, *shape)) for shape in [(), *[(library.joints,)] * 3, (3,), (3, 3), (6,), (6,)]]
    library.opened.mrts_path_places(count, along, part.x, part.rates, cell.geometry, segments, cell.wrench_rows, *found)
    s, q, dq, ddq, position, rotation, twist, acceleration = found
    by_columns = rotation.transpose(0, 2, 1)  # as generated functions want them
    carried = ObjectMotion(s, position, by_columns, twist, acceleration, checked=False)
    return CoordinatedMotion(carried, q, dq, ddq, checked=False)
