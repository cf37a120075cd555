# SPDX-License-Identifier: MIT
"""Tables of the report of a result: what was given, the range, limits and how far they are used, conflicts, loads."""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from mrts.base.arrays import Array
from mrts.base.words import interval_text
from mrts.cell.cell import Cell
from mrts.cell.robot import JOINT_HEAD
from mrts.limits.rows import ActiveRow, RowName
from mrts.plots.card import Card
from mrts.plots.labels import range_facts, range_text, row_text, short_name
from mrts.plots.limit_shares import LimitingRows, played
from mrts.plots.range_plots import ranked_loads
from mrts.plots.what_if_plot import MOST_BARS, changed_shares
from mrts.program.infeasibility import Conflict
from mrts.scaling.limit_use import limit_uses, rate_uses
from mrts.scaling.loads import LoadStudy
from mrts.scaling.range import ScalingRange
from mrts.scaling.result import ScalingResult
from mrts.scaling.what_if import WhatIf
from mrts.timing.result import RetimingResult

MOST_CONFLICTS = 10
MOST_LOADS = 16
"""Rows of the tables of conflicts and loads; the rest is counted."""

MOST_LISTED = 12
"""Limits of a timing, and changes in words; the rest is counted."""

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
    """Titles of the columns, rows, and what is left out."""

    head: Sequence[str]
    rows: Sequence[Sequence[Entry]]
    more: str = ""


def bar(share: float, digits: int = 0, style: str = "") -> Styled:
    """A share as a bar with its percentage."""
    return Styled(f"{100 * share:.{digits}f} %", style, share)


def more(count: int, what: str) -> str:
    """How many are left out; empty if none are."""
    return f"{count} more {what}" if count > 0 else ""


def nearest_table(card: Card) -> Table:
    """The limits that are nearest."""
    rows = [(one.label, bar(one.share, 1, one.nearness), f"at {one.time:.4g} s") for one in card.bars]
    return Table(("nearest limits", "used at most", ""), rows)


def durations_table(found: RetimingResult) -> Table:
    """A timing beside the best constant factor and the given motion."""
    given, best, smooth = float(found.motion.object.time[-1]), found.factor, found.smooth
    longest = max(given, found.duration or 0.0, best.duration or 0.0)

    def row(name: str, duration: float | None, more: str = "") -> tuple[Entry, ...]:
        if duration is None:
            return (name, "none", "", more)
        return (name, f"{duration:.4g} s", Styled(f"{100 * duration / given:.4g} %", share=duration / longest), more)

    saving = ""
    if found.saving is not None:
        less = "less" if found.saving >= 0 else "more"
        saving = f"{100 * abs(found.saving):.3g} % {less} than the best constant factor"
    rows = [row(smooth.what if smooth is not None else "fastest timing", found.duration, saving)]
    if smooth is not None and smooth.bound is not None:
        rows.append(row("fastest without limits of rates", smooth.bound, "no timing takes less"))
    at = "" if best.c2 is None else f"c² = {best.c2:.4g}"
    rows += [row("best constant factor", best.duration, at), row("as given", given)]
    return Table(("timing", "duration", "of the given time", ""), rows)


def timing_limits_table(found: RetimingResult) -> Table:
    """What limits a timing, and for how much of it."""
    rows = [(name, bar(share)) for name, share in found.limits[:MOST_LISTED]]
    head = ("what limits the speed", "for this share of the duration")
    return Table(head, rows, more(len(found.limits) - MOST_LISTED, "limits"))


def inputs(result: ScalingResult) -> list[tuple[str, str]]:
    """Cell, object, motion and how the load is shared, by name."""
    cell, given = result.cell, result.motion.object
    where = f"planar in {cell.plane}" if cell.plane else "spatial"
    path = f"from {_vector(given.position[0])} m to {_vector(given.position[-1])} m"
    fastest = (
        f"{limit:.4g} {unit}"
        for limit, unit in zip(cell.object_velocity_limit, ("m/s", "rad/s"), strict=True)
        if np.isfinite(limit)
    )
    entries = [
        ("cell", f"{cell.name}, {where}, gravity {_vector(cell.gravity)} m/s²"),
        ("object", _object_text(cell)),
        ("speed of the object", f"at most {speed}" if (speed := ", ".join(fastest)) else "unlimited"),
        ("load", "known" if result.load is None else result.load.sentence()),
    ]
    for robot in cell.robots:
        base = _vector(robot.T_world_base.p)
        entries.append((f"robot {robot.name}", f"{len(robot.joints)} joints, base at {base} m"))
    entries += [
        ("given motion", f"{given.time[-1]:.4g} s in {result.motion.samples} samples, {path}"),
        ("torques", _distribution_text(result)),
    ]
    if result.cell.reserve:
        entries.append(("kept in reserve", f"{100 * result.cell.reserve:.4g} % of every limit"))
    if result.reserve is not None:
        entries.append(("reserve", str(result.reserve)))
    entries.append(("between the samples", _between_text(result)))
    return entries


def _object_text(cell: Cell) -> str:
    diagonal = ", ".join(f"{value:.4g}" for value in np.diag(cell.inertia))
    text = f"{cell.mass:.4g} kg, moments of inertia {diagonal} kg m²"
    xy, xz, yz = cell.inertia[0, 1], cell.inertia[0, 2], cell.inertia[1, 2]
    if xy or xz or yz:
        text += f", products xy {xy:.4g}, xz {xz:.4g}, yz {yz:.4g} kg m²"
    if np.any(cell.load[1:4] != 0):
        text += f", first moments {_vector(cell.load[1:4])} kg m"
    return text


def _between_text(result: ScalingResult) -> str:
    found = result.excess
    if found is None:
        return "not looked at"
    if found.share > 0:
        return str(found).removeprefix("between the samples ")
    return f"all limits are kept to {100 * found.tolerance:.2g} % of them"


def _distribution_text(result: ScalingResult) -> str:
    sharing = result.options.sharing
    if sharing is None and len(result.cell.robots) == 1:
        return "those of one arm"
    if sharing is None:
        if result.options.distribute == "reserve":
            return "those that keep most of every limit in reserve, and the least weighted squares among them"
        if result.options.rates is not None:
            return "the least weighted squares over the whole motion that keep all limits, and those of rates"
        return "the least weighted squares that keep all limits"
    if sharing.shares is None:
        return "a fixed distribution, equal shares"
    return f"a fixed distribution, shares {', '.join(f'{share:.4g}' for share in sharing.shares)}"


def joints_table(cell: Cell) -> Table:
    """Limits of every joint."""
    rows = [(robot.name, *row) for robot in cell.robots for row in robot.joint_rows()]
    *head, velocity = ("robot", "joint", *JOINT_HEAD)
    return Table((*head, velocity if cell.enforces_velocity_limits else f"{velocity} (not enforced)"), rows)


def motors_table(cell: Cell) -> Table:
    """What is known of the motors, where that is more than their largest torque; no rows if all are ideal."""
    rows: list[tuple[Entry, ...]] = []
    for robot in cell.robots:
        motors = robot.motors
        for j, joint in enumerate(robot.joints):
            torque, speed = robot.torque_units[j], f"{robot.position_units[j]}/s"
            curve = motors.torque_speed[j]
            corners = [] if curve is None else [f"{most:g} {torque} at {dq:g} {speed}" for dq, most in curve.tolist()]
            numbers = (motors.armature[j], motors.coulomb[j], motors.viscous[j])
            rated = f"{motors.rated[j]:g} {torque}" if np.isfinite(motors.rated[j]) else ""
            known: tuple[Entry, ...] = (*(f"{value:g}" if value else "" for value in numbers), tuple(corners), rated)
            if any(known):
                rows.append((f"{robot.name}/{joint}", *known))
    head = ("joint", "armature", "Coulomb friction", "viscous friction", "torque-speed curve", "rated torque")
    return Table(head, rows)


def wrench_limits_table(cell: Cell) -> Table:
    """Limits of every contact wrench, and what else the hands can exert where that is told."""
    rows: list[tuple[str, ...]] = []
    for robot in cell.robots:
        sides = zip(robot.wrench_lower, robot.wrench_upper, cell.wrench_units, strict=True)
        rows.append((robot.name, *(interval_text(lower, upper, unit) for lower, upper, unit in sides)))
    head: tuple[str, ...] = ("robot", *cell.wrench_components)
    if any(robot.contacts for robot in cell.robots):
        head = (*head, "hand")
        hands = [", ".join(f"{own.name} ({len(own.rows)} rows)" for own in robot.contacts) for robot in cell.robots]
        rows = [(*row, hand) for row, hand in zip(rows, hands, strict=True)]
    return Table(head, rows)


def range_table(found: ScalingRange) -> Table:
    """Both ends of the range and what sets them."""
    rows: list[tuple[Entry, ...]] = []
    ends = [("c²⁻", found.lower), ("c²⁺", found.upper)]
    for name, end in ends:
        if end is None:
            continue
        if end.time is None:
            rows.append((name, "∞", "∞", "", "nothing limits it"))
            continue
        place = f"{end.time:.4g} s" + ("" if end.load is None else f", {end.load}")
        rows.append((name, f"{end.c2:.6g}", f"{np.sqrt(max(end.c2, 0)):.4g} ×", place, _limits(end.rows)))
    return Table(("end", "c²", "speed", "set at", "by"), rows)


def margins_table(result: ScalingResult, limiting: LimitingRows) -> Table:
    """Every limit by falling share that is used; those that set the speed first, each hand's failure once."""
    rows: dict[str, tuple[Entry, ...]] = {}
    for use in sorted(limit_uses(result), key=lambda use: use.name not in limiting.setting):
        values = interval_text(use.lower, use.upper, use.name.unit), f"{use.least:.4g}", f"{use.largest:.4g}"
        told = ("", "", "") if use.name.failure else values  # of what there is no value that people know
        share = bar(use.share, 1), f"{use.time:.4g} s"
        rows.setdefault(short_name(use.name), (_marked(use.name, limiting), *told, *share))
    return Table(("limit", "from … to", "least", "largest", "share used", "most used at"), [*rows.values()])


def _marked(name: RowName, limiting: LimitingRows) -> tuple[Entry, ...]:
    if name in limiting.setting:
        return short_name(name), Styled(limiting.setting[name], "mark limiting")
    words = limiting.reached.get(name)
    return (short_name(name), *([Styled(words, "mark")] if words else []))


def duty_table(result: ScalingResult) -> Table:
    """What the motion asks of every motor, with the share of what it bears where that is known."""
    rows: list[tuple[Entry, ...]] = []
    for robot, duty in zip(result.cell.robots, played(result).duty.values(), strict=True):
        for j, joint in enumerate(robot.joints):
            torque, speed = robot.torque_units[j], f"{robot.position_units[j]}/s"
            rows.append(
                (
                    f"{robot.name}/{joint}",
                    _of_limit(duty.rms_torque[j], torque, duty.rated_share[j]),
                    _of_limit(duty.peak_torque[j], torque, duty.torque_share[j]),
                    _of_limit(duty.peak_speed[j], speed, duty.speed_share[j]),
                    (
                        f"{_cleared(duty.drive_power[j]):.3g} / {_cleared(duty.brake_power[j]):.3g} W",
                        *([f"{100 * duty.power_share[j]:.1f} %"] if duty.power_share[j] > 0 else []),
                    ),
                    _of_limit(duty.torque_rate[j], f"{torque}/s", duty.torque_rate_share[j]),
                    _of_limit(duty.jerk[j], f"{speed}³", duty.jerk_share[j]),
                )
            )
    head = ("joint", "rms torque", "peak torque", "peak speed", "power given / taken", "torque rate", "jerk")
    return Table(head, rows)


def rates_table(result: ScalingResult, limiting: LimitingRows) -> Table:
    """Every rate that is limited by falling share."""
    rows: list[tuple[Entry, ...]] = []
    for use in sorted(rate_uses(result), key=lambda use: use.name not in limiting.setting):
        unit = use.name.unit
        numbers = (f"{use.upper:.4g} {unit}", f"{use.size:.4g} {unit}", f"{100 * use.share:.1f} %")
        rows.append((_marked(use.name, limiting), *numbers, f"{use.time:.4g} s"))
    return Table(("limited rate", "limit", "largest", "share", "at"), rows)


def _cleared(value: float) -> float:
    return float(np.round(value, DECIMALS) + 0.0)


def _of_limit(value: float, unit: str, share: float) -> tuple[Entry, ...]:
    return (f"{_cleared(value):.4g} {unit}", *([f"{100 * share:.1f} %"] if share > 0 else []))


def conflicts_table(conflicts: Sequence[Conflict]) -> Table:
    """Which limits conflict and when; conflicts of the same limits share a row, which tells of their worst sample."""
    groups: dict[str, list[Conflict]] = {}
    for conflict in sorted(conflicts, key=lambda conflict: -conflict.widening):
        load = "" if conflict.load is None else f" with {conflict.load}"
        groups.setdefault(f"{sorted(map(str, conflict.rows))}{load}", []).append(conflict)
    rows: list[tuple[Entry, ...]] = []
    for alike in list(groups.values())[:MOST_CONFLICTS]:
        worst = alike[0]
        moves = zip(worst.rows, worst.moves, strict=True)
        named = tuple(f"{row_text(row)}: by {move:.3g} {row.name.unit}".rstrip() for row, move in moves)
        times = [conflict.time for conflict in alike]
        when: Entry = f"{worst.time:.4g} s"
        if len(alike) > 1:
            span = f"{len(alike)} samples from {min(times):.4g} s to {max(times):.4g} s,"
            when = span, f"worst at {worst.time:.4g} s"
        load = "" if worst.load is None else str(worst.load)
        rows.append((when, f"{100 * worst.widening:.3g} %", named, load))
    head = ("t", "all limits wider by", "these conflict, and how far each would have to move", "load")
    with_load = any(row[-1] for row in rows)
    rest = more(len(groups) - MOST_CONFLICTS, "sets of limits that conflict")
    return Table(head if with_load else head[:-1], rows if with_load else [row[:-1] for row in rows], rest)


def loads_table(study: LoadStudy) -> Table:
    """Ranges by load, the worst first."""
    rows: list[tuple[Entry, ...]] = []
    for index in ranked_loads(study)[:MOST_LOADS]:
        found = study.ranges[index]
        ends, by = range_text(found), tuple(range_facts(found))
        if found.upper is not None and found.status.admits_motion:
            by = _limits(found.upper.rows)
        rows.append((str(study.points[index]), ends, by))
    return Table(("load", "c²", "c²⁺ is set by"), rows, more(len(study.ranges) - MOST_LOADS, "loads"))


def changes_in_words(found: WhatIf) -> list[tuple[str, list[str]]]:
    """Changes that bars do not show, under their titles: with which it cannot be played, or can for the first time."""
    gains, _, lost = found.sorted()
    told = (
        ("With these it can be played:", [one for one in gains if one.faster is None]),
        ("With these it cannot be played:", lost),
    )
    return [
        (title, [*map(str, listed[:MOST_LISTED]), *filter(None, [more(len(listed) - MOST_LISTED, "changes")])])
        for title, listed in told
        if listed
    ]


def changes_left_out(found: WhatIf) -> list[str]:
    """What else there is to know of changes, a sentence each."""
    hidden = len(changed_shares(found)) - MOST_BARS
    rest = f"{hidden} more do less than these" if hidden > 0 else ""
    return [text for text in (rest, found.nothing_else(), found.left_out) if text]


def _limits(rows: Sequence[ActiveRow]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(map(row_text, rows)))


def _vector(values: Array) -> str:
    return f"({', '.join(f'{_cleared(value):.4g}' for value in values)})"
