# SPDX-License-Identifier: MIT
"""What a trajectory makes of every joint, hand and object, beside its limits, as a table for a terminal."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mrts.scaling.limit_use import limit_tables, limit_uses

if TYPE_CHECKING:
    from mrts.scaling.result import ScalingResult

INDENT = "  "
"""Before the name of a row."""

LEAST_NAME_WIDTH = 20
"""Of the column of names [characters]."""

NEXT_SHOWN = 3
"""Limits that come next, in words."""

AT_LIMIT = 0.9995
"""Share of a limit from which on the table reads 100 %."""


def limit_table(result: "ScalingResult") -> Iterator[str]:
    """The tables of `mrts.scaling.limit_use.limit_tables` below one another."""
    tables = list(limit_tables(result))
    names = max(LEAST_NAME_WIDTH, *(len(INDENT + row[0]) for table in tables for row in table.rows))
    yield f"{'':<{names}} {'least':>11} {'largest':>11} {'used':>6}  limits"
    for table in tables:
        yield table.head[0]
        for name, least, largest, used, limits in table.rows:
            yield f"{INDENT + name:<{names}} {least:>11} {largest:>11} {used:>6}  {limits}"


def next_limits_line(result: "ScalingResult") -> Iterator[str]:
    """The limits that are nearest after those that are met, with what is left of them."""
    kept = (use for use in limit_uses(result) if use.name.kind != "velocity" or result.cell.enforces_velocity_limits)
    following = [use for use in kept if use.share < AT_LIMIT][:NEXT_SHOWN]
    if following:
        told = ", ".join(f"{use.name} has {100 * (1 - use.share):.3g} % left" for use in following)
        yield f"next limits as distributed here: {told}"
