# SPDX-License-Identifier: MIT
"""The answer in one line, and the limits that are nearest: for terminal, report and figures alike."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, Literal

import numpy as np

from mrts.cell.robot import Robot
from mrts.limits.rows import RowName
from mrts.plots.labels import range_facts, row_text, short_name
from mrts.plots.limit_shares import AT_END, AT_LIMIT, REACHED, all_shares, played, setting_rows
from mrts.scaling.range import RangeEnd
from mrts.scaling.result import ScalingResult

if TYPE_CHECKING:
    from mrts.timing.result import RetimingResult

MOST_BARS = 5
"""Limits that are told: those of which most is used."""

NEAR = 0.9
"""Share of a limit from which it is near."""

BAR_LETTERS = 20

Nearness = Literal["free", "near", "reached"]


@dataclass(frozen=True)
class LimitBar:
    """How much of a limit is used at most.

    Attributes:
        name: What it limits; the first of those that fail alike.
        share: Of it that is used, 1 at the limit.
        sample: Where.
        time: Of that sample, as the motion is played [s].
    """

    name: RowName
    share: float
    sample: int
    time: float

    @property
    def label(self) -> str:
        """What it limits, for people."""
        return short_name(self.name)

    def body(self, robot: Robot) -> int | None:
        """The body of an arm that it is about: that of the joint, else the hand; None of another arm."""
        if self.name.robot != robot.name:
            return None
        joint = self.name.element
        return robot.joints.index(joint) + 1 if joint in robot.joints else len(robot.joints)

    @property
    def nearness(self) -> Nearness:
        """How near the limit is."""
        return "reached" if self.share >= REACHED else "near" if self.share >= NEAR else "free"


@dataclass(frozen=True)
class Card:
    """The outcome in one line, and the limits of which most is used; none without a trajectory."""

    outcome: str
    bars: tuple[LimitBar, ...]

    @property
    def deciding(self) -> LimitBar | None:
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
        return Card(_refusal(result), _nearest(shown, None))
    given, done, end = float(result.motion.object.time[-1]), shown.trajectory, shown.range.upper
    parts = [f"{given / done.duration:.3g} × as fast", f"{done.duration:.4g} s (given {given:.4g} s)"]
    if timing is not None:
        parts = [f"{done.duration:.4g} s"] if timing.untimed else parts
        before = "before it made room " if timing.made_room else ""
        parts += [f"{before}limited by {name}, {100 * share:.0f} % of the time" for name, share in timing.limits[:1]]
    elif not shown.origin and end is not None and end.time is not None:
        if any(side == "upper" for side, _ in shown.range.ends_at(done.c2, AT_END)):
            parts.append(_limited(end, done.c2))
        else:
            parts.append(f"up to {sqrt(end.c2):.3g} × as fast, {_limited(end, end.c2)}")
    return Card(" · ".join(parts), _nearest(shown, timing))


def _limited(end: RangeEnd, c2: float) -> str:
    first, *others = dict.fromkeys(map(row_text, end.rows))
    more = f" and {len(others)} more" if others else ""
    return f"limited by {first}{more}, at {(end.time or 0.0) / sqrt(c2):.4g} s"


def _refusal(result: "ScalingResult | RetimingResult") -> str:
    if not isinstance(result, ScalingResult):
        return f"no timing: {result.explanation}" if result.explanation else str(result.status.value)
    if result.status.admits_motion:
        return result.sentence()
    return " · ".join(["no speed keeps all limits", *range_facts(result.range)])


def _nearest(result: ScalingResult, timing: "RetimingResult | None") -> tuple[LimitBar, ...]:
    """What sets the speed, then limits by falling share; the rows of one hand that fail alike are one.

    Velocities count only where their limits are kept.
    """
    names, shares = all_shares(result)
    time, largest = played(result).time, np.max(shares, axis=0)
    most = np.where(largest > 1 + AT_LIMIT, largest, np.minimum(largest, REACHED))  # those at 100 % are alike
    first = {name: place for place, name in enumerate(setting_rows(result, timing, names))}
    bars: dict[str, LimitBar] = {}
    for row in sorted(range(len(names)), key=lambda row: (first.get(names[row], len(first)), -most[row])):
        if names[row].kind != "velocity" or result.cell.enforces_velocity_limits:
            at = int(np.argmax(shares[:, row] >= most[row]))
            bars.setdefault(short_name(names[row]), LimitBar(names[row], float(largest[row]), at, float(time[at])))
    return tuple(bars.values())[:MOST_BARS]
