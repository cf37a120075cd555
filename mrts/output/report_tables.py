# SPDX-License-Identifier: MIT
"""Tables of the report of a result: what was given, nearest limits, motors, conflicts; and of a study."""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from mrts.base.words import first_names
from mrts.limits.rows import MOST_NAMES
from mrts.plots.card import Card
from mrts.plots.study_plots import OUTCOMES, StudyTable, percent
from mrts.program.infeasibility import Conflict
from mrts.scaling.scale import ScalingResult
from mrts.timing.result import RetimingResult

MOST_BEST = 10
"""Rows of the table of the best variants."""

DECIMALS = 9
"""Of numbers in SI units: what is less is left over from sums of larger terms."""


class Styled(NamedTuple):
    """A cell whose text has a style of its own, or a bar of that style before it, which a share of 1 fills."""

    text: str
    style: str = ""
    share: float | None = None


Entry: TypeAlias = "str | Styled | tuple[Entry, ...]"
"""Of a table; a tuple has its parts below each other."""


class Table(NamedTuple):
    """Titles of the columns, and rows."""

    head: Sequence[str]
    rows: Sequence[Sequence[Entry]]


def bar(share: float, digits: int = 0, style: str = "") -> Styled:
    """A share as a bar with its percentage."""
    return Styled(f"{100 * share:.{digits}f} %", style, share)


def nearest_table(card: Card) -> Table:
    """The limits that are nearest."""
    rows = [(one.label, bar(one.share, 1, one.nearness), f"at {one.time:.4g} s") for one in card.bars]
    return Table(("nearest limits", "used at most", ""), rows)


def setting_table(found: RetimingResult) -> Table:
    """What limits the speed of a timing, for how long."""
    rows = [(name, f"{100 * share:.3g} %") for name, share in found.limits]
    return Table(("what limits the speed", "of the duration"), rows)


def inputs(result: ScalingResult) -> list[tuple[str, str]]:
    """What was asked beside cell and motion, by name."""
    asked, load = result.options, result.load
    shares = None if asked.sharing is None else asked.sharing.shares
    fixed = "equal" if shares is None else ", ".join(f"{share:.4g}" for share in shares)
    entries = [
        ("load", "known" if load is None else load.sentence()),
        ("torques", asked.distribute if asked.sharing is None else f"fixed shares of the load: {fixed}"),
        ("accuracy", "between the samples not looked at" if result.excess is None else str(result.excess)),
    ]
    if result.cell.reserve:
        entries.append(("kept in reserve", f"{100 * result.cell.reserve:.4g} % of every limit"))
    if result.reserve is not None:
        entries.append(("reserve", str(result.reserve)))
    return entries


def duty_table(result: ScalingResult) -> Table:
    """What the motion asks of every motor, with the share of what it bears where that is known."""
    rows: list[tuple[Entry, ...]] = []
    for robot, duty in zip(result.cell.robots, result.done.duty.values(), strict=True):
        for j, joint in enumerate(robot.joints):
            torque, speed = robot.torque_units[j], f"{robot.position_units[j]}/s"
            rows.append(
                (
                    f"{robot.name}/{joint}",
                    _of_limit(torque, duty.rated_share[j], duty.rms_torque[j]),
                    _of_limit(torque, duty.torque_share[j], duty.peak_torque[j]),
                    _of_limit(speed, duty.speed_share[j], duty.peak_speed[j]),
                    _of_limit("W", duty.power_share[j], duty.drive_power[j], duty.brake_power[j]),
                    _of_limit(f"{torque}/s", duty.torque_rate_share[j], duty.torque_rate[j]),
                    _of_limit(f"{speed}³", duty.jerk_share[j], duty.jerk[j]),
                )
            )
    head = ("joint", "rms torque", "peak torque", "peak speed", "power given / taken", "torque rate", "jerk")
    return Table(head, rows)


def _of_limit(unit: str, share: float, *values: float) -> tuple[Entry, ...]:
    told = " / ".join(f"{np.round(value, DECIMALS) + 0.0:.4g}" for value in values)
    return (f"{told} {unit}", *([f"{100 * share:.1f} %"] if share > 0 else []))


def conflicts_table(conflicts: Sequence[Conflict]) -> Table:
    """Which limits conflict and when; conflicts of the same limits share a row, which tells of their worst sample."""
    groups: dict[str, list[Conflict]] = {}
    for conflict in sorted(conflicts, key=lambda conflict: -conflict.widening):
        groups.setdefault(f"{sorted(map(str, conflict.rows))}{conflict.with_load}", []).append(conflict)
    rows: list[tuple[Entry, ...]] = []
    for alike in groups.values():
        worst = alike[0]
        moves = zip(worst.rows, worst.moves, strict=True)
        named = tuple(f"{row}: by {move:.3g} {row.name.unit}".rstrip() for row, move in moves)
        times = [conflict.time for conflict in alike]
        when: Entry = f"{worst.time:.4g} s"
        if len(alike) > 1:
            span = f"{len(alike)} samples from {min(times):.4g} s to {max(times):.4g} s,"
            when = span, f"worst at {worst.time:.4g} s"
        load = "" if worst.load is None else str(worst.load)
        rows.append((when, f"{100 * worst.widening:.3g} %", named, load))
    head = ("t", "all limits wider by", "these conflict, and how far each would have to move", "load")
    with_load = any(row[-1] for row in rows)
    return Table(head if with_load else head[:-1], rows if with_load else [row[:-1] for row in rows])


def best_table(found: StudyTable) -> Table:
    """The best variants; no line of a limit breaks before its arrow."""
    head = ("variant", "duration [s]", "c²⁺ [1]", *found.titles.values(), "limited by")
    rows: list[tuple[Entry, ...]] = []
    for row in found.ranked[:MOST_BEST].tolist():
        c2 = f"{found.c2[row]:.4g}" if np.isfinite(found.c2[row]) else ""
        limits = first_names(found.limits(row), MOST_NAMES).split(", ")
        numbers = (f"{found.duration[row]:.4g}", c2, *(f"{value:.4g}" for value in found.values[row].tolist()))
        rows.append((str(found.rows["variant"].iloc[row]), *numbers, tuple(Styled(limit, "whole") for limit in limits)))
    return Table(head, rows)


def limit_counts_table(found: StudyTable) -> Table:
    """Which limit binds how often."""
    counts, total = found.limit_counts(found.admitted), int(np.sum(found.admitted))
    rows = [(name, bar(count / total)) for name, count in counts]
    return Table(("limit at c²⁺", "of all that can be played"), rows)


def outcomes_table(found: StudyTable) -> Table:
    """What became of the variants."""
    counts = found.outcome_counts(np.ones(found.variants, dtype=bool))
    rows = [(name, OUTCOMES[name], str(count), percent(count, found.variants)) for name, count in counts]
    return Table(("outcome", "what it means", "variants", "share"), rows)


def reasons_table(found: StudyTable) -> Table:
    """Why variants have no speed."""
    rows = [(outcome, Styled(reason, "prose"), str(count)) for outcome, reason, count in found.reasons()]
    return Table(("outcome", "reason of the first", "variants alike"), rows)
