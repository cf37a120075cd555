# SPDX-License-Identifier: MIT
"""The answer in one line, and the limits that are nearest: for terminal, report and figures alike."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

from mrts.limits.rows import RowName
from mrts.scaling.limit_use import LimitUse
from mrts.scaling.range import RangeEnd
from mrts.scaling.result import AT_END, ScalingResult

if TYPE_CHECKING:
    from mrts.timing.result import RetimingResult

MOST_BARS = 5
"""Limits that are told: those of which most is used."""

BAR_LETTERS = 20


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
    elif not shown.origin and end is not None and end.time is not None:
        if any(side == "upper" for side, _ in shown.range.ends_at(done.c2, AT_END)):
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
