# SPDX-License-Identifier: MIT
"""Tables of results, as notebooks and the command line show them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mrts.base.interval_text import interval_text
from mrts.base.notebook.in_notebooks import NotebookTable
from mrts.limits.rows import TORQUE_SPEED
from mrts.scaling.limit_use import LimitUse

if TYPE_CHECKING:
    from mrts.scaling.range import ScalingRange
    from mrts.scaling.result import ScalingResult
    from mrts.scaling.what_if import WhatIf

TITLES = {"torque": "torque", "wrench": "contact wrench", "velocity": "velocity", "": "other"}
"""Of tables by the kind of their limits; those of the last are of kinds that mrts does not know."""

ELSEWHERE = ("contact", TORQUE_SPEED, "motor speed")
"""Kinds that are summed up elsewhere."""

LIMIT_DIGITS = 6
"""Significant digits of a limit: as many as it is given with."""

MOST_CHANGES = 8
"""Changes that are shown of those that gain, that lose, and that cannot be played."""


class LimitRow(NamedTuple):
    """A limited quantity in texts.

    Attributes:
        name: Its own.
        least: Its least value.
        largest: Its largest.
        used: How much of a limit, empty where there is none.
        limits: Its limits with their unit, and whether they end the range.
    """

    name: str
    least: str
    largest: str
    used: str
    limits: str


def result_rows(result: "ScalingResult") -> Iterator[tuple[str, str]]:
    """Outcome, range, and chosen speed.

    Args:
        result: The result.
    """
    yield "outcome", result.status.value
    if result.status.admits_motion:
        yield "range of c²", result.range.text()
    done = result.trajectory
    if done is None:
        return
    yield "chosen c²", f"{done.c2:.4g}"
    yield "duration", f"{done.duration:.4g} s, as given {result.motion.object.time[-1]:.4g} s"


def limit_tables(result: "ScalingResult") -> Iterator[tuple[str, list[LimitRow]]]:
    """Least and largest value of each torque, contact wrench and velocity, its limits and how much of them is used.

    "binds" stands at the limits that end the range, where its end was chosen: no distribution of torques gets past
    them. Another one at 100 % is where this distribution puts it. What a limit of yours bounds comes last; motors and
    hands have tables of their own.

    Args:
        result: The result; without a trajectory there are none.

    Yields:
        A title, and its rows.
    """
    chosen = None if result.trajectory is None else result.trajectory.c2
    binding = set() if chosen is None else {row.name for _, end in result.range.ends_at(chosen) for row in end.rows}
    for kind, title in TITLES.items():
        uses = [use for use in result.limit_uses if _is_listed(use, kind)]
        told = "" if kind != "velocity" or result.cell.enforces_velocity_limits else " (limits not enforced)"
        if uses:
            yield f"{title}{told}", [_limit_row(use, binds=use.name in binding) for use in uses]


def _is_listed(use: LimitUse, kind: str) -> bool:
    """Whether a use stands in the table of a kind, or, if it has none, in that of all others."""
    name = use.name
    if not kind:
        return use.limited and name.kind not in {*TITLES, *ELSEWHERE}
    return name.kind == kind and (use.limited or kind != "velocity" or name.robot != "object")


def _limit_row(use: LimitUse, *, binds: bool) -> LimitRow:
    name, unit = use.name, use.name.unit
    limits = interval_text(use.lower, use.upper, unit, LIMIT_DIGITS) if use.limited else f"none, {unit}".rstrip(", ")
    return LimitRow(
        name=f"{name.robot}/{name.element}" if name.kind in TITLES else name.short,
        least=f"{use.least:.4g}",
        largest=f"{use.largest:.4g}",
        used=f"{round(100 * use.share, 1):g} %" if use.limited else "",
        limits=f"{limits}{', binds' if binds else ''}",
    )


def range_ends(found: "ScalingRange") -> NotebookTable:
    """Both ends, and what sets them.

    Args:
        found: The range.
    """
    rows = []
    for name, end in (("c²⁺", found.upper), ("c²⁻", found.lower)) if found.status.admits_motion else ():
        if end is not None:
            speed = f"{np.sqrt(max(end.c2, 0.0)):.4g} ×" if np.isfinite(end.c2) else "∞"
            place = "nothing limits it" if end.time is None else end.place()
            rows.append((name, f"{end.c2:.6g}" if np.isfinite(end.c2) else "∞", speed, place))
    return NotebookTable(("end", "c²", "speed", "set"), rows)


def changes_table(found: "WhatIf") -> NotebookTable:
    """What gains most, what loses most, and with what the motion cannot be played.

    Args:
        found: What changes would do.
    """
    rows = [
        (str(one.change), one.amount if one.after.duration is not None else one.after.status,
         ", ".join(one.after.limits) or one.after.reason)
        for group in found.sorted()
        for one in group[:MOST_CHANGES]
    ]  # fmt: skip
    return NotebookTable(("change", "effect", "then limited by"), rows)
