# SPDX-License-Identifier: MIT
"""What a trajectory makes of every joint, hand and object, beside its limits, as a table for a terminal."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mrts.base.interval_text import interval_text
from mrts.limits.rows import TORQUE_SPEED
from mrts.scaling.limit_use import LimitUse, limit_uses

if TYPE_CHECKING:
    from mrts.scaling.result import ScalingResult

OWN_KINDS = ("torque", "wrench", "velocity")
"""Kinds of limits with a part of the table each; what a limit of yours bounds comes after them."""

ELSEWHERE = ("contact", TORQUE_SPEED, "motor speed")
"""Kinds that other lines sum up."""

TITLES = {"torque": "torque", "wrench": "contact wrench", "velocity": "velocity", "": "other"}

LEAST_NAME_WIDTH = 20
"""Of the column of names [characters]."""

LIMIT_DIGITS = 6
"""Significant digits of a limit: as many as it is given with."""

NEXT_SHOWN = 3
"""Limits that come next, in words."""

AT_LIMIT = 0.9995
"""Share of a limit from which on the table reads 100 %."""


def limit_table(result: "ScalingResult") -> Iterator[str]:
    """Least and largest value of each torque, contact wrench and velocity, its limits and how much of them is used.

    "binds" stands at the limits that end the range, where its end was chosen: no distribution of torques gets past
    them. Another one at 100 % is where this distribution puts it.

    Args:
        result: A result with a trajectory.
    """
    tables = {kind: limit_uses(result, kind) for kind in OWN_KINDS}
    tables["velocity"] = [use for use in tables["velocity"] if _is_limited(use) or use.name.robot != "object"]
    tables[""] = [use for use in limit_uses(result) if use.name.kind not in {*OWN_KINDS, *ELSEWHERE}]
    names = max(LEAST_NAME_WIDTH, *(len(_shown_name(use)) for uses in tables.values() for use in uses))
    yield f"{'':<{names}} {'least':>11} {'largest':>11} {'used':>6}  limits"
    chosen = None if result.trajectory is None else result.trajectory.c2
    binding = set() if chosen is None else {row.name for _, end in result.range.ends_at(chosen) for row in end.rows}
    for kind, uses in tables.items():
        if uses:
            told = "" if kind != "velocity" or result.cell.enforces_velocity_limits else " (limits not enforced)"
            yield f"{TITLES[kind]}{told}"
        for use in uses:
            limits = interval_text(use.lower, use.upper, use.name.unit, LIMIT_DIGITS)
            if not _is_limited(use):
                limits = f"none, {use.name.unit}" if use.name.unit else "none"
            used = f"{round(100 * use.share, 1):g} %" if _is_limited(use) else ""
            binds = ", binds" if use.name in binding else ""
            values = f"{use.least:>11.4g} {use.largest:>11.4g} {used:>6}"
            yield f"{_shown_name(use):<{names}} {values}  {limits}{binds}"


def next_limits_line(result: "ScalingResult") -> Iterator[str]:
    """The limits that are nearest after those that are met, with what is left of them.

    Args:
        result: A result with a trajectory.
    """
    kept = (use for use in limit_uses(result) if use.name.kind != "velocity" or result.cell.enforces_velocity_limits)
    following = [use for use in kept if use.share < AT_LIMIT][:NEXT_SHOWN]
    if following:
        told = ", ".join(f"{use.name} has {100 * (1 - use.share):.3g} % left" for use in following)
        yield f"next limits as distributed here: {told}"


def _is_limited(use: LimitUse) -> bool:
    return use.lower > -float("inf") or use.upper < float("inf")


def _shown_name(use: LimitUse) -> str:
    name = use.name
    return "  " + (f"{name.robot}/{name.element}" if name.kind in OWN_KINDS else name.short)
