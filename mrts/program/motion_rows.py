# SPDX-License-Identifier: MIT
"""A cell along a motion as the programs take it: its limits, with what bounds the speed alone in ṙ², and its motors."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, with_part
from mrts.base.manifest import GEOMETRY
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.binding import filled, structure, work_arrays
from mrts.kernel.cell_library import sample_inputs
from mrts.limits import limit_rows
from mrts.limits.rows import LimitRows, few_sides
from mrts.motion.rows_at_rest import REST, moving_joints
from mrts.program.formulation import FormulationName
from mrts.program.load_sharing import LoadSharing
from mrts.program.solvers import DEFAULT_SOLVER

TERMS = structure("rows.h", "mrts_terms")


@dataclass(frozen=True, kw_only=True)
class MotorTerms:
    """τ of the motors less τ of the arms: square ṙ² + rate r̈ + speed ṙ + dry, at N samples of m joints.

    Attributes:
        square: I_a q'', Shape (N, m).
        rate: I_a q', Shape (N, m).
        speed: b q', Shape (N, m); None where no joint has viscous friction.
        dry: τ_c in the direction of travel, Shape (N, m) [N m or N].
        turning: τ_c where a joint turns back at a sample: it acts in both directions there, and `dry` has none,
            Shape (N, m) [N m or N]; None where no joint does.
    """

    square: Array
    rate: Array
    speed: Array | None
    dry: Array
    turning: Array | None

    def at(self, samples: NDArray[np.int_] | slice) -> "MotorTerms":
        """The same at some samples only."""
        return with_part(self, vars(self), samples)

    def torque(self, speed: float) -> Array:
        """All that the motors give besides at a constant factor of speed, Shape (N, m) [N m or N]."""
        return self.square * speed**2 + self.friction(speed)

    def margin(self, rows: LimitRows) -> Array | None:
        """By how much limits move inward where friction may act in both directions, Shape (N, r); None if none does."""
        return None if self.turning is None else self.turning @ np.abs(rows.limits.torque_matrix).T

    def friction(self, speed: float | Array) -> Array:
        """The part of τ that friction is at ṙ, one for all samples, or Shape (N, 1): Shape (N, m) [N m or N]."""
        return self.dry if self.speed is None else self.dry + self.speed * speed


def motor_terms(cell: Cell, motion: CoordinatedMotion) -> MotorTerms | None:
    """Rotor inertia and friction of a cell along a motion; None where its motors are ideal."""
    armature, coulomb, viscous = map(cell.stacked, ("motors.armature", "motors.coulomb", "motors.viscous"))
    if not (armature.any() or coulomb.any() or viscous.any()):
        return None
    before, after = travel_directions(motion)
    turns = (before != after) & (coulomb > 0)
    return MotorTerms(
        square=armature * motion.ddq,
        rate=armature * motion.dq,
        speed=viscous * motion.dq if viscous.any() else None,
        dry=coulomb * (before + after) / 2,
        turning=coulomb * turns if turns.any() else None,
    )


def travel_directions(motion: CoordinatedMotion) -> Array:
    """Signs of each joint's velocity just before and just after every sample, Shape (2, N, m); 0 where it stands.

    Where the motion does not tell them and q' = 0, q'' does: a joint arrives against it and leaves with it. At the
    first sample nothing is before, at the last nothing after.
    """
    if motion.travel is not None:
        return motion.travel
    dq, ddq = motion.dq, motion.ddq
    change, moves = np.abs(ddq), moving_joints(dq)
    moving = np.where(moves, np.sign(dq), 0.0)
    leaving = np.where((change > REST * change.max()) & moves.any(axis=0), np.sign(ddq), 0.0)
    before, after = np.where(moving == 0, -leaving, moving), np.where(moving == 0, leaving, moving)
    before[0], after[-1] = after[0], before[-1]
    return np.array([before, after])


CAPS_TIE = 2e-7
"""Caps that bound ṙ² this closely to the one that bounds it most bind with it."""

MOST_ROWS = 32_767
"""The kernel keeps the rows of each sample's answer as 16-bit numbers."""

SPEED_AT_REST = 1e-12
"""A speed below this share of its largest along the motion is rounding of rest."""


@dataclass(frozen=True)
class MotionRows:
    """All limits of a cell along a motion of N samples, and what its motors add, as every program takes them.

    Programs are those of a formulation, "wrench" or "torque", or of a fixed distribution of the load, for a solver.

    Attributes:
        cell: The cell.
        motion: Its motion.
        sharing: A fixed distribution of the load; None for a free one.
        formulation: That of the programs where the distribution is free.
        solver: Name in the registry of what solves them.
        given: The r rows as they were given.
        motors: What motors add; None where they are ideal.
    """

    cell: Cell
    motion: CoordinatedMotion
    sharing: LoadSharing | None
    formulation: FormulationName
    solver: str
    given: LimitRows
    motors: MotorTerms | None

    @cached_property
    def _square_terms(self) -> Array:
        """Terms b or e of the s rows that bound ṙ², Shape (N, s)."""
        given, places = self.given, self.given.limits.in_squares
        term = np.zeros((self.motion.samples, len(places)))
        for column in (given.speed, given.square):
            if column is not None:
                term += column[:, places]
        size, rest = np.abs(term), np.where(given.limits.by_speed[places], SPEED_AT_REST, SPEED_AT_REST**2)
        term[size <= rest * size.max(axis=0, initial=0.0)] = 0.0
        return term

    @cached_property
    def _caps(self) -> tuple[NDArray[np.bool_], Array]:
        limits, is_cap = self.given.limits, np.zeros(len(self.given.names), dtype=bool)
        least, most = limits.lower[limits.in_squares], limits.upper[limits.in_squares]
        share = side_share(self._square_terms, least, most)
        own = (least <= 0) & (most >= 0) & np.isfinite(share).all(axis=0)
        is_cap[limits.in_squares] = own
        share, by_speed, alike = share[:, own], limits.by_speed[is_cap], (least == -most)[own]
        return is_cap, np.where(by_speed, share * np.where(alike, share, np.abs(share)), share)

    @property
    def is_cap(self) -> NDArray[np.bool_]:
        """Rows that standstill keeps and nothing but the speed moves: they only bound ṙ² from above, Shape (r,)."""
        return self._caps[0]

    @property
    def cap_share(self) -> Array:
        """What each of these caps is of its limit at ṙ = 1, in ṙ², as from `side_share`, Shape (N, caps)."""
        return self._caps[1]

    def passed_caps(self, c2: Array, samples: NDArray[np.intp]) -> Array:
        """By how much k samples pass the caps at ṙ² = c², Shape (k,), in shares of each, at most: 0 or more."""
        passed, limits, (caps, share) = np.zeros(len(c2)), self.given.limits, self._caps
        over = (c2 > self.most[samples]).nonzero()[0]
        if over.size:
            share = share[samples[over]]
            side = np.where(share > 0, limits.upper[caps], -limits.lower[caps]) / limits.units[caps]
            size = np.where(limits.by_speed[caps], side**2, side)
            passed[over] = ((np.abs(share) * c2[over, None] - 1) * size).max(axis=1)
        return passed

    @cached_property
    def rows(self) -> LimitRows:
        """The rows, those with no term but b ṙ in ṙ², as `RowLimits.squared`. A row with others beside ṙ keeps it."""
        given, limits, squared = self.given, self.given.limits, self.given.limits.squared
        places, square, speed = limits.in_squares, np.zeros((len(limits.names), self.motion.samples)).T, given.speed
        if not len(places):
            return given
        if given.square is not None:
            square[:] = given.square
        by_speed, alike = limits.by_speed[places], (limits.lower == -limits.upper)[places]
        term = np.where(by_speed & alike, np.abs(self._square_terms), self._square_terms)
        square[:, places] = np.where(by_speed, term * np.abs(term) / limits.units[places], term)
        if speed is not None:
            speed = np.where(squared.terms[1], speed, 0.0) if squared.terms[1].any() else None
        return replace(given, limits=squared, square=square, speed=speed)

    @property
    def unit(self) -> Array:
        """What 100 % of a limit near it is, in its own unit; of a squared speed half its size, Shape (r,)."""
        limits, unit = self.given.limits, self.given.limits.units.copy()
        unit[limits.by_speed] /= 2
        return unit

    @cached_property
    def kept(self) -> LimitRows:
        """The rows that are no caps."""
        alone = np.count_nonzero(self.is_cap) == len(self.given.limits.in_squares)
        return (self.given if alone else self.rows).only(~self.is_cap)

    @cached_property
    def compiled(self) -> bool:
        """Whether the kernel takes the programs: of a free distribution in the wrench form, whose sides do not cross.

        They cross where a reserve leaves less than nothing between them: such rows admit nothing.
        """
        free = self.formulation == "wrench" and self.sharing is None
        few = len(self.kept.names) + self.cell.library.unknowns <= MOST_ROWS
        return free and few and not (self.given.limits.lower > self.given.limits.upper).any()

    def over_samples(
        self,
        function: str,
        asked: Sequence[Array],
        outputs: Sequence[NDArray[Any]],
        for_all: tuple[Any, ...] = (),
        *,
        load: Array | None = None,
        speed: float | Array | None = None,
        samples: NDArray[np.intp] | None = None,
    ) -> None:
        """Call a C function of whole trajectories for all samples, or some.

        `asked` is what it takes of each of k samples, `for_all` what it takes besides, `outputs` what it fills. ṙ is
        one of all of them, or Shape (k, 1), and None where it is to be found.
        """
        library, count, limits = self.cell.library, len(asked[0]), self.kept.limits.in_c
        given = sample_inputs(library.records["wrench_form"], count, self.inputs(load, samples))
        kept, motors = self.kept, self.motors
        if samples is not None:
            kept, motors = kept.at(samples), None if motors is None else motors.at(samples)
        where = count, *given, limits, added_terms(kept, motors, speed)
        work = work_arrays(library.opened, "mrts_samples", limits.rows)
        failed = getattr(library.opened, function)(*where, *asked, *for_all, *outputs, *work)
        assert not failed  # noqa: S101 (`compiled` has looked at the limits)

    @cached_property
    def most(self) -> Array:
        """Largest ṙ² that keeps all caps, Shape (N,)."""
        return largest_square(self.cap_share)

    def inputs(self, load: Array | None, samples: NDArray[np.intp] | None = None) -> dict[str, Array]:
        """Inputs of the generated formulation at k samples, all or some, by name.

        The load is the cell's where none is given, one of all samples, Shape (10,), or one of each, Shape (k, 10).
        """
        inputs = self.motion.inputs(self.cell.load) | {GEOMETRY: self.cell.geometry}
        inputs |= {} if self.sharing is None else self.sharing.inputs(self.cell, self.motion)
        if samples is not None:
            for name, value in inputs.items():
                inputs[name] = value if value.ndim == 1 else value[samples]
        return inputs if load is None else inputs | {"load": load}

    @property
    def has_speed_terms(self) -> bool:
        """Whether a row has a term in ṙ beside others."""
        by_motors = self.motors is not None and self.motors.speed is not None
        return by_motors or "speed" in self.given.limits.squared.columns

    def along(self, motion: CoordinatedMotion) -> "MotionRows":
        """The rows of the same cell and the same programs along another motion."""
        return motion_rows(self.cell, motion, self.sharing, self.formulation, self.solver)


def added_terms(rows: LimitRows, motors: MotorTerms | None, speed: float | Array | None = None) -> Any:
    """The `mrts_terms` of rows.h: what is added to rows and to torques, with terms in a known ṙ put in."""
    terms = {"square": rows.square, "speed": rows.speed, "offset": rows.offset}
    if rows.speed is not None and speed is not None:
        terms |= {"speed": None, "offset": rows.speed * speed + (0.0 if rows.offset is None else rows.offset)}
    if motors is not None:
        terms |= {
            "torque_square": motors.square,
            "torque_offset": motors.friction(0.0 if speed is None else speed),
            "torque_speed": motors.speed if speed is None else None,
            "margin": motors.margin(rows),
        }
    return filled(TERMS, **terms)


def largest_square(cap_share: Array) -> Array:
    """Largest ṙ² that keeps all caps, infinity where none moves, Shape (…), of shares Shape (…, s)."""
    with np.errstate(divide="ignore"):
        return np.asarray(1 / np.abs(cap_share).max(axis=-1, initial=0.0), dtype=np.float64)


def side_share(square: Array, lower: Array, upper: Array) -> Array:
    """What rows e ṙ² are of the limit on their side at ṙ = 1, below 0 on the lower, 0 where they have none.

    Shape (…, s) as `square`.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        share = square / np.where(square > 0, upper, -lower)
    return np.where(square == 0, 0.0, share)


def binds(share: Array) -> NDArray[np.bool_]:
    """Which caps bound ṙ², none at rest; shares as `MotionRows.cap_share`, of one sample or of all."""
    size = np.abs(share)
    most = size.max(axis=-1, initial=0.0, keepdims=True)
    return np.asarray((size >= (1 - CAPS_TIE) * most) & (most > 0))


def motion_rows(
    cell: Cell,
    motion: CoordinatedMotion,
    sharing: LoadSharing | None = None,
    formulation: FormulationName = "wrench",
    solver: str = DEFAULT_SOLVER,
    *,
    circles: bool = False,
) -> MotionRows:
    """A cell along a motion as the programs take it; for `circles` polygons have as many sides as tell these.

    Raises:
        InputError: If a limit that the cell was given gives no rows of this cell along this motion.
    """
    given = limit_rows(cell, motion)
    given = given.only(few_sides(given.names)) if circles else given
    return MotionRows(cell, motion, sharing, formulation, solver, given, motor_terms(cell, motion))
