# SPDX-License-Identifier: MIT
"""The answer in one line, and the limits that are nearest: for terminal, report and figures alike; and in lines."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

from mrts.base.words import aligned
from mrts.limits.rows import RowName
from mrts.scaling.range import LoadStudy, RangeEnd
from mrts.scaling.scale import Result, ScalingResult
from mrts.scaling.scaled_trajectory import LimitUse

if TYPE_CHECKING:
    from mrts.timing.result import RetimingResult

MOST_BARS = 5
"""Limits that are told: those of which most is used."""

BAR_LETTERS = 20

LOADS_SHOWN = 8
"""Loads of a box that are printed."""

LIMITS_SHOWN = 4
"""Limits that are printed of a timing."""


@dataclass(frozen=True)
class Card:
    """The outcome in one line, and the limits of which most is used; none without a trajectory."""

    outcome: str
    bars: tuple[LimitUse, ...]

    @property
    def deciding(self) -> LimitUse | None:
        """The limit that decides how fast the motion may be played, or is used or passed the most."""
        return next(iter(self.bars), None)

    def lines(self) -> Iterator[str]:
        """The bars as text."""
        width = max((len(bar.label) for bar in self.bars), default=0)
        for bar in self.bars:
            full = round(BAR_LETTERS * min(bar.share, 1.0))
            drawn = "━" * full + " " * (BAR_LETTERS - full)
            yield f"  {bar.label:<{width}}  {drawn} {100 * bar.share:5.1f} %  at {bar.time:.4g} s"


def answer_card(result: "ScalingResult | RetimingResult") -> Card:
    """What the user asked: how much faster, how long, limited by what; or why not."""
    timing, shown = (None, result) if isinstance(result, ScalingResult) else (result, result.retimed)
    if shown is None or shown.trajectory is None:
        return Card(_refusal(result), ())
    if not shown.status.admits_motion:
        return Card(_refusal(result), _nearest(shown, ()))
    given, done, end = float(result.motion.object.time[-1]), shown.trajectory, shown.range.upper
    parts = [f"{given / done.duration:.3g} × as fast", f"{done.duration:.4g} s (given {given:.4g} s)"]
    if timing is not None:
        parts = [f"{done.duration:.4g} s"] if timing.given.untimed else parts
        before = "before it made room " if timing.made_room else ""
        parts += [f"{before}limited by {name}, {100 * share:.0f} % of the time" for name, share in timing.limits[:1]]
    elif not shown.origin and end.time is not None:
        if end.is_at(done.c2):
            parts.append(_limited(end, done.c2))
        else:
            parts.append(f"up to {sqrt(end.c2):.3g} × as fast, {_limited(end, end.c2)}")
    return Card(" · ".join(parts), _nearest(shown, result.setting_rows()))


def _limited(end: RangeEnd, c2: float) -> str:
    first, *others = dict.fromkeys(map(str, end.rows))
    more = f" and {len(others)} more" if others else ""
    return f"limited by {first}{more}, at {(end.time or 0.0) / sqrt(c2):.4g} s"


def _refusal(result: "ScalingResult | RetimingResult") -> str:
    if not isinstance(result, ScalingResult):
        return f"no timing: {result.explanation}" if result.explanation else str(result.status.value)
    if result.status.admits_motion:
        return result.sentence()
    return f"no speed keeps all limits · {result.range.reason()}"


def _nearest(result: ScalingResult, setting: Sequence[RowName]) -> tuple[LimitUse, ...]:
    """What sets the speed, then limits by falling share; the rows of one hand that fail alike are one.

    Velocities count only where their limits are kept.
    """
    place = {name: number for number, name in enumerate(setting)}
    bars: dict[str, LimitUse] = {}
    for use in sorted(result.uses, key=lambda use: place.get(use.name, len(place))):
        if use.name.kind != "velocity" or result.cell.enforces_velocity_limits:
            bars.setdefault(use.label, use)
    return tuple(bars.values())[:MOST_BARS]


def answer_lines(result: "ScalingResult | RetimingResult", card: Card | None) -> Iterator[str]:
    """What the command line says of a result, with the nearest limits of its card as bars; without one, all."""
    yield from result.notebook_words()
    yield from _plan_lines(result, card) if isinstance(result, ScalingResult) else _timing_lines(result, card)
    if result.changes is not None:
        yield ""
        yield from result.changes.lines()


def _plan_lines(result: ScalingResult, card: Card | None) -> Iterator[str]:
    if result.load is not None:
        yield from _load_lines(result.load)
    done = result.trajectory
    if done is None:
        return
    given = result.motion.object.time[-1]
    yield f"chosen c² = {done.c2:.6g}: {given:.4g} s become {done.duration:.4g} s, energy {done.energy:.4g} J"
    yield f"reserve: {result.reserve}"
    yield f"torques for a load of {result.cell.mass:.4g} kg\n" if result.load is not None else ""
    yield from _limit_lines(result, card)


def _timing_lines(found: "RetimingResult", card: Card | None) -> Iterator[str]:
    if found.retimed is None or found.retimed.trajectory is None or found.excess is None:
        return
    limits = "; ".join(f"{name} {100 * share:.0f} % of the time" for name, share in found.limits[:LIMITS_SHOWN])
    yield f"{'before it made room ' if found.made_room else ''}limited by {limits}"
    loads = f"for each of {len(found.loads)} corners of the load's box, " if len(found.loads) > 1 else ""
    if found.excess.share > 0:
        yield f"between the samples, {loads}limits are overstepped by at most {100 * found.excess.share:.2g} %"
    else:
        yield f"between the samples, {loads}no limit is overstepped"
    effort = "" if found.smooth is None else f", ∫ τᵀWτ dt = {found.effort:.4g}"
    energy = f"{found.retimed.trajectory.energy:.4g} J{effort}"
    yield f"energy {energy}; torques for a load of {found.retimed.cell.mass:.4g} kg\n"
    yield from _limit_lines(found, card)


def _limit_lines(result: Result, card: Card | None) -> Iterator[str]:
    table = result.limits_table()
    yield from card.lines() if card is not None else aligned([table.head, *table.rows])


def _load_lines(study: LoadStudy) -> Iterator[str]:
    table = study.table()
    yield from (f"  {line}" for line in aligned([table.head, *table.rows[:LOADS_SHOWN]]) if table.rows)
    if len(study.ranges) > LOADS_SHOWN:
        yield f"  … and {len(study.ranges) - LOADS_SHOWN} more loads (--json has all)"
    if not study.box.axes_are_the_objects:
        columns = zip("xyz", study.box.principal_axes.T, strict=True)
        axes = "; ".join(f"{name} {column.round(4).tolist()}" for name, column in columns)
        yield f"  factors of ixx, iyy, izz are about the principal axes, in the object frame: {axes}"
