# SPDX-License-Identifier: MIT
"""The outcome of scaling as lines of text."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mrts.base.words import aligned
from mrts.plots.card import Card
from mrts.scaling.result import Result, ScalingResult

if TYPE_CHECKING:
    from mrts.scaling.loads import LoadStudy
    from mrts.timing.result import RetimingResult

LOADS_SHOWN = 8
"""Loads of a box that are printed."""

LIMITS_SHOWN = 4
"""Limits that are printed of a timing."""


def answer_lines(result: "ScalingResult | RetimingResult", card: Card | None) -> Iterator[str]:
    """What the command line says of a result, with the nearest limits of its card as bars; without one, all."""
    yield f"{result.cell.name}: {result.sentence()}"
    yield from map(str, result.warnings)
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


def _load_lines(study: "LoadStudy") -> Iterator[str]:
    table = study.table()
    yield from (f"  {line}" for line in aligned([table.head, *table.rows[:LOADS_SHOWN]]) if table.rows)
    if len(study.ranges) > LOADS_SHOWN:
        yield f"  … and {len(study.ranges) - LOADS_SHOWN} more loads (--json has all)"
    if not study.box.axes_are_the_objects:
        columns = zip("xyz", study.box.principal_axes.T, strict=True)
        axes = "; ".join(f"{name} {column.round(4).tolist()}" for name, column in columns)
        yield f"  factors of ixx, iyy, izz are about the principal axes, in the object frame: {axes}"
