# SPDX-License-Identifier: MIT
"""The outcome of retiming: the profile, its trajectory and what limits it, or why there is none."""

from collections.abc import Iterable, Sequence
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
from mrts.limits.rows import ActiveRow, RowName
from mrts.motion.rows_at_rest import pushing_ends
from mrts.program.between_samples import Excess
from mrts.program.infeasibility import Conflict
from mrts.program.motion_rows import motion_rows
from mrts.program.range_status import RangeStatus
from mrts.program.sample_ranges import motion_ranges
from mrts.program.successive_steps import CONVERGED
from mrts.program.torque_distribution import torque_weights
from mrts.scaling.options import Options
from mrts.scaling.remarks import motion_remarks
from mrts.scaling.scale import Result, ScalingResult, SelectionError, chosen_factor, kept_text, with_torques
from mrts.scaling.scaled_trajectory import LimitUse
from mrts.scaling.what_if import SpeedAnswer, SpeedQuestion, WhatIf
from mrts.timing.path_pieces import PathPiece
from mrts.timing.retimed_motion import SmoothPiece, TimedPiece, at_segment_ends, new_times

BINDING = 1e-6
"""A limit binds where the motion could be no faster by more than this share of c²."""


ONLY_AT_SAMPLES = " at samples only"
"""Of a profile whose limits hold at the samples, and less well between them."""


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

    @property
    def what(self) -> str:
        """What the timing is, for people."""
        return "smooth timing" + ("" if self.longest is None else f" of least energy within {self.longest:g} s")

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

    def __repr__(self) -> str:
        return f"RetimingResult({self.cell.name}: {self.sentence()})"

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
                same = np.array_equal(path.dq[own], old.dq) and np.array_equal(path.ddq[own], old.ddq)
                return (number, own) if same else None
        return None

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
        squares = np.einsum("ni,ij,nj->n", done.torque, W, done.torque)
        return float(np.sum(np.diff(done.time) * (squares[1:] + squares[:-1]) / 2))

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
        shares: dict[str, float] = {}
        for rows, share in self.segment_limits:
            for name in dict.fromkeys(map(str, rows)):
                shares[name] = shares.get(name, 0.0) + share
        return sorted(shares.items(), key=lambda entry: (-entry[1], entry[0]))

    @cached_property
    def segment_limits(self) -> list[tuple[tuple[ActiveRow | RowName, ...], float]]:
        """What limits the speed on every segment between two samples, and the segment's share of the duration.

        Rows; of a smooth timing their names.
        """
        found: list[tuple[tuple[ActiveRow | RowName, ...], float]] = []
        for part in self.pieces:
            smooth = part if isinstance(part, SmoothPiece) else None
            binding: Sequence[Iterable[ActiveRow | RowName]] = smooth.binding if smooth else self._binding(part)
            shares = (part.segment_times / new_times(self.pieces)[-1]).tolist()
            found += [(tuple(sorted(rows, key=str)), share) for rows, share in zip(binding, shares, strict=True)]
        return found

    @property
    def uses(self) -> list[LimitUse]:
        """How much of each limit is used, rates too, by falling share; nothing without a profile."""
        return [] if self.retimed is None else self.retimed.uses

    def setting_rows(self) -> list[RowName]:
        """What limits the speed somewhere along the path, by falling share of the duration."""
        shares = dict.fromkeys((use.name for use in self.uses), 0.0)
        for told, share in self.segment_limits:  # the two sides of a row apart: both do not bind at once
            for name in shares:
                shares[name] += share * any((row if isinstance(row, RowName) else row.name) == name for row in told)
        return sorted((name for name in shares if shares[name] > 0), key=lambda name: -shares[name])

    def _binding(self, part: TimedPiece) -> list[set[ActiveRow]]:
        """The limits that bind on every segment.

        A point of a region's edge is one where the motion, faster or slower as a whole, would have c² <= 1; the rows
        that bind there are the edge's.
        """
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
            limits = dict.fromkeys((name.rpartition(" (")[0] or name).partition(":")[0] for name, _ in timed.limits)
            return SpeedAnswer(status="feasible", duration=timed.duration, limits=tuple(limits))

        return self.cell, self.motion, answer

    def sentence(self) -> str:
        """The outcome alone."""
        kept = kept_text(self.cell.reserve)
        if not self.status.admits_motion:
            return printable(f"{kept}{self.status.value}: {self.explanation}")
        given, best = float(self.motion.object.time[-1]), self.factor
        what = "fastest timing" if self.smooth is None else self.smooth.what
        compared = " along a path without times" if self.given.untimed else f", the given one {given:.4g} s"
        text = f"{kept}the {what} takes {self.duration:.4g} s{compared}"
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
