# SPDX-License-Identifier: MIT
"""Limits as the programs take them: what bounds the speed alone in ṙ², and which rows do nothing but that."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.limits.rows import LimitRows, moved

CAPS_TIE = 2e-7
"""Caps that bound ṙ² this closely to the one that bounds it most bind with it."""

SQUARE_AT_REST = 1e-24
"""A squared speed below this share of its largest along the motion is rounding of rest."""


@dataclass(frozen=True, kw_only=True)
class SquaredRows:
    """Rows lower <= M_τ τ + M_F F + a r̈ + b ṙ + e ṙ² <= upper of which none has ṙ for its only term.

    Attributes:
        given: The r rows as they were given.
        rows: The same rows; those of ṙ alone in ṙ².
        size: `LimitRows.units`: what the rows are divided by, Shape (r,).
        unit: What 100 % of a limit near it is, in its own unit; of a squared speed half its size, Shape (r,).
        is_cap: Rows that standstill keeps and nothing but the speed moves: all that they do is bound ṙ² from above,
            Shape (r,).
    """

    given: LimitRows
    rows: LimitRows
    size: Array
    unit: Array
    is_cap: NDArray[np.bool_]

    @cached_property
    def kept(self) -> NDArray[np.intp]:
        """Those that are no caps, Shape (k,)."""
        return np.flatnonzero(~self.is_cap)

    @cached_property
    def crosses(self) -> bool:
        """Whether the sides of some row cross, as a reserve leaves them: it admits nothing."""
        return bool(np.any(self.rows.lower > self.rows.upper))

    @cached_property
    def uncapped(self) -> LimitRows:
        """The rows that are no caps."""
        return self.rows.only(~self.is_cap)

    def caps(self, samples: int) -> "SpeedCaps":
        """The caps by themselves.

        Args:
            samples: N.
        """
        lower, upper, square = self.rows.lower[self.is_cap], self.rows.upper[self.is_cap], self.rows.square
        square = np.zeros((samples, len(lower))) if square is None else square[:, self.is_cap]
        return SpeedCaps(np.flatnonzero(self.is_cap), side_share(square, lower, upper), square > 0)


@dataclass(frozen=True)
class SpeedCaps:
    """Rows that do nothing but bound ṙ² from above.

    Attributes:
        places: Which of all rows these are, Shape (s,).
        share: What each is of its limit at ṙ = 1, Shape (N, s).
        upper: Whether that is its upper limit, Shape (N, s).
    """

    places: NDArray[np.int_]
    share: Array
    upper: NDArray[np.bool_]

    def largest(self) -> Array:
        """Largest ṙ² that keeps all of them, infinity where nothing moves, Shape (N,)."""
        with np.errstate(divide="ignore"):
            return np.asarray(1 / np.max(self.share, axis=1, initial=0.0), dtype=np.float64)


def side_share(square: Array, lower: Array, upper: Array) -> Array:
    """What rows e ṙ² are of the limit on their side at ṙ = 1, 0 where they have none: Shape (…, s) as `square`."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(square > 0, square / upper, square / lower)
    return np.where(square == 0, 0.0, share)


def binds(share: Array) -> NDArray[np.bool_]:
    """Which caps bound ṙ², none at rest.

    Args:
        share: As in `SpeedCaps`, of one sample, Shape (s,), or of all, Shape (N, s).
    """
    most = np.max(share, axis=-1, initial=0.0, keepdims=True)
    return np.asarray((share >= (1 - CAPS_TIE) * most) & (most > 0))


def squared(given: LimitRows) -> SquaredRows:
    """Bring rows that nothing but ṙ moves into a form that is linear in ṙ².

    A row b ṙ becomes b |b| ṙ² between l |l| and u |u|: as ṙ >= 0, squares with their sign keep the order. Where the
    speed is limited alike in both directions that is b² ṙ² <= u². A row with other terms beside ṙ keeps it.

    Args:
        given: Rows along a motion.
    """
    unit = given.units()
    column = given.speed if given.speed is not None else given.square
    if column is None:
        return SquaredRows(given=given, rows=given, size=unit, unit=unit, is_cap=np.zeros(len(unit), dtype=bool))
    count, alone = len(unit), given.is_of_speed
    by_speed = moved(given.speed, count)
    mixed = by_speed & (~alone if given.square is None else moved(given.square, count) | ~alone)
    by_speed &= ~mixed
    places = np.flatnonzero(alone & ~mixed)
    size, least, most = unit[places], given.lower[places] / unit[places], given.upper[places] / unit[places]
    part = np.zeros((len(column), 1)) if given.square is None else given.square[:, places] / size
    if np.any(by_speed) and given.speed is not None:
        of_speed = by_speed[places]
        share, alike = given.speed[:, places] / size, of_speed & (least == -most)
        part = part + share * (share if np.all(alike) else np.where(alike, share, np.abs(share)))
        least = np.where(alike, -np.inf, np.where(of_speed, least * np.abs(least), least))
        most = np.where(of_speed, most * np.abs(most), most)
    magnitude = np.abs(part)
    part[magnitude <= SQUARE_AT_REST * np.max(magnitude, axis=0, initial=0.0)] = 0.0
    rows = _with_squares(given, places, size * part, size * least, size * most)
    if np.any(mixed) and given.speed is not None:
        rows = replace(rows, speed=given.speed * mixed)
    stays = (least <= 0) & (most >= 0)
    is_cap = np.zeros(count, dtype=bool)
    is_cap[places] = stays & ~np.any((part > 0) & (most <= 0) | (part < 0) & (least >= 0), axis=0)
    return SquaredRows(given=given, rows=rows, size=unit, unit=np.where(by_speed, unit / 2, unit), is_cap=is_cap)


def _with_squares(given: LimitRows, places: NDArray[np.int_], square: Array, lower: Array, upper: Array) -> LimitRows:
    """The rows without ṙ, some of them with another term in ṙ², Shape (N, s), and other limits, Shape (s,)."""
    whole = np.zeros((len(given.names), len(square))).T
    if given.square is not None:
        whole[:] = given.square
    whole[:, places] = square
    limits = given.lower.copy(), given.upper.copy()
    limits[0][places], limits[1][places] = lower, upper
    return replace(given, lower=limits[0], upper=limits[1], speed=None, square=whole)
