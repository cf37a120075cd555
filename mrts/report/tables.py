# SPDX-License-Identifier: MIT
"""Tables of the report: what was given, the range, limits and how far they are used, conflicts, loads."""

from collections.abc import Iterable, Sequence

import numpy as np

from mrts.base.arrays import Array
from mrts.base.interval_text import interval_text
from mrts.cell.cell import Cell
from mrts.cell.robot import JOINT_HEAD
from mrts.limits.rows import ActiveRow, RowName
from mrts.plots.labels import range_facts, range_text, row_text, short_name
from mrts.plots.limit_shares import LimitingRows
from mrts.plots.range_plots import ranked_loads
from mrts.plots.what_if_plot import MOST_BARS, changed_shares
from mrts.program.infeasibility import Conflict
from mrts.report.markup import Html, bar, element, html, joined, table
from mrts.scaling.limit_use import limit_uses, rate_uses
from mrts.scaling.range import ScalingRange
from mrts.scaling.result import ScalingResult
from mrts.scaling.what_if import WhatIf

MOST_CONFLICTS = 10
MOST_LOADS = 16
"""Rows of the tables of conflicts and loads; the rest is counted."""

MOST_LISTED = 12
"""Changes that are listed in words: with which it cannot be played, or can where it could not before."""

DECIMALS = 9
"""Of numbers in SI units: what is less is left over from sums of larger terms."""


def inputs_table(result: ScalingResult) -> Html:
    """Cell, object, motion and how the load is shared."""
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
    return element("dl", joined(joined([element("dt", name), element("dd", text)]) for name, text in entries))


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


def joints_table(cell: Cell) -> Html:
    """Limits of every joint."""
    rows = [(robot.name, *row) for robot in cell.robots for row in robot.joint_rows()]
    *head, velocity = ("robot", "joint", *JOINT_HEAD)
    return table((*head, velocity if cell.enforces_velocity_limits else f"{velocity} (not enforced)"), rows)


def motors_table(cell: Cell) -> list[Html]:
    """What is known of the motors, where that is more than their largest torque; nothing if all are ideal."""
    rows = []
    for robot in cell.robots:
        motors = robot.motors
        for j, joint in enumerate(robot.joints):
            torque, speed = robot.torque_units[j], f"{robot.position_units[j]}/s"
            curve = motors.torque_speed[j]
            corners = [] if curve is None else [f"{most:g} {torque} at {dq:g} {speed}" for dq, most in curve.tolist()]
            numbers = (motors.armature[j], motors.coulomb[j], motors.viscous[j])
            rated = f"{motors.rated[j]:g} {torque}" if np.isfinite(motors.rated[j]) else ""
            known = (*(f"{value:g}" if value else "" for value in numbers), _lines(corners), rated)
            if any(known):
                rows.append((f"{robot.name}/{joint}", *known))
    head = ("joint", "armature", "Coulomb friction", "viscous friction", "torque-speed curve", "rated torque")
    note = "Armature in kg m², friction in N m and N m s/rad; of prismatic joints in kg, N and N s/m."
    return [table(head, rows), element("p", note, class_="note")] if rows else []


def wrench_limits_table(cell: Cell) -> Html:
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
    return table(head, rows)


def range_table(found: ScalingRange) -> list[Html]:
    """Both ends of the range and what sets them; nothing if there are none."""
    rows = []
    ends = [("c²⁻", found.lower), ("c²⁺", found.upper)]
    for name, end in ends:
        if end is None:
            continue
        if end.time is None:
            rows.append((name, "∞", "∞", "", "nothing limits it"))
            continue
        place = f"{end.time:.4g} s" + ("" if end.load is None else f", {end.load}")
        rows.append((name, f"{end.c2:.6g}", f"{np.sqrt(max(end.c2, 0)):.4g} ×", place, _rows_list(end.rows)))
    return [table(("end", "c²", "speed", "set at", "by"), rows)] if rows else []


def margins_table(result: ScalingResult, limiting: LimitingRows) -> Html:
    """Every limit by falling share that the trajectory uses; those that set the speed first, each hand's failure once.

    Args:
        result: A result.
        limiting: Which rows set its speed.
    """
    rows: dict[str, tuple[str, ...]] = {}
    for use in sorted(limit_uses(result), key=lambda use: use.name not in limiting.setting):
        values = interval_text(use.lower, use.upper, use.name.unit), f"{use.least:.4g}", f"{use.largest:.4g}"
        told = ("", "", "") if use.name.failure else values  # of what there is no value that people know
        share = bar(use.share, 1), f"{use.time:.4g} s"
        rows.setdefault(short_name(use.name), (_marked(use.name, limiting), *told, *share))
    return table(("limit", "from … to", "least", "largest", "share used", "most used at"), rows.values())


def _marked(name: RowName, limiting: LimitingRows) -> Html:
    """The name of a limit with what is to be said of it below."""
    sets = limiting.setting.get(name)
    words = limiting.reached.get(name, "") if sets is None else sets
    mark = element("span", words, class_="mark" if sets is None else "mark limiting")
    return joined([html(short_name(name)), *([Html("<br>"), mark] if words else [])])


def duty_table(result: ScalingResult) -> Html:
    """What the motion asks of every motor, with the share of what it bears where that is known."""
    done = result.trajectory
    if done is None:
        return Html("")
    rows = []
    for robot, duty in zip(result.cell.robots, done.duty.values(), strict=True):
        for j, joint in enumerate(robot.joints):
            torque, speed = robot.torque_units[j], f"{robot.position_units[j]}/s"
            rows.append(
                (
                    f"{robot.name}/{joint}",
                    _of_limit(duty.rms_torque[j], torque, duty.rated_share[j]),
                    _of_limit(duty.peak_torque[j], torque, duty.torque_share[j]),
                    _of_limit(duty.peak_speed[j], speed, duty.speed_share[j]),
                    f"{_cleared(duty.drive_power[j]):.3g} / {_cleared(duty.brake_power[j]):.3g} W",
                    _of_limit(duty.torque_rate[j], f"{torque}/s", duty.torque_rate_share[j]),
                    _of_limit(duty.jerk[j], f"{speed}³", duty.jerk_share[j]),
                )
            )
    head = ("joint", "rms torque", "peak torque", "peak speed", "power given / taken", "torque rate", "jerk")
    return table(head, rows)


def rates_table(result: ScalingResult, limiting: LimitingRows) -> list[Html]:
    """Every rate that is limited by falling share; nothing if none is.

    Args:
        result: A result.
        limiting: Which rows set its speed.
    """
    if result.trajectory is None:
        return []
    rows, uses = [], rate_uses(result)
    for use in sorted(uses, key=lambda use: use.name not in limiting.setting):
        unit = use.name.unit
        numbers = (f"{use.upper:.4g} {unit}", f"{use.size:.4g} {unit}", f"{100 * use.share:.1f} %")
        rows.append((_marked(use.name, limiting), *numbers, f"{use.time:.4g} s"))
    kept = "They are kept" if result.options.rates is not None else "They are reported, and bound nothing"
    note = f"{kept}; differences of neighbouring samples."
    head = ("limited rate", "limit", "largest", "share", "at")
    return [table(head, rows), element("p", note, class_="note")] if rows else []


def _cleared(value: float) -> float:
    """A number without what is left over from sums of larger terms."""
    return float(np.round(value, DECIMALS) + 0.0)


def _of_limit(value: float, unit: str, share: float) -> Html:
    shown = html(f"{_cleared(value):.4g} {unit}")
    return joined([shown, *([Html("<br>"), html(f"{100 * share:.1f} %")] if share > 0 else [])])


def conflicts_table(conflicts: Sequence[Conflict]) -> Html:
    """Which limits conflict and when; conflicts of the same limits share a row, which tells of their worst sample."""
    groups: dict[str, list[Conflict]] = {}
    for conflict in sorted(conflicts, key=lambda conflict: -conflict.widening):
        load = "" if conflict.load is None else f" with {conflict.load}"
        groups.setdefault(f"{sorted(map(str, conflict.rows))}{load}", []).append(conflict)
    rows = []
    for alike in list(groups.values())[:MOST_CONFLICTS]:
        worst = alike[0]
        moves = zip(worst.rows, worst.moves, strict=True)
        named = _lines(f"{row_text(row)}: by {move:.3g} {row.name.unit}".rstrip() for row, move in moves)
        times = [conflict.time for conflict in alike]
        when = html(f"{worst.time:.4g} s")
        if len(alike) > 1:
            span = f"{len(alike)} samples from {min(times):.4g} s to {max(times):.4g} s,"
            when = _lines((span, f"worst at {worst.time:.4g} s"))
        load = "" if worst.load is None else str(worst.load)
        rows.append((when, f"{100 * worst.widening:.3g} %", named, load))
    head = ("t", "all limits wider by", "these conflict, and how far each would have to move", "load")
    with_load = any(row[-1] for row in rows)
    whole = table(head if with_load else head[:-1], rows if with_load else [row[:-1] for row in rows])
    return joined([whole, *_rest(len(groups) - MOST_CONFLICTS, "sets of limits that conflict")])


def loads_table(result: ScalingResult) -> Html:
    """Ranges by load, the worst first; nothing if no load was looked at by itself."""
    study = result.load
    if study is None or not study.ranges:
        return Html("")
    rows = []
    for index in ranked_loads(study)[:MOST_LOADS]:
        found = study.ranges[index]
        ends, by = range_text(found), _lines(range_facts(found))
        if found.upper is not None and found.status.admits_motion:
            by = _rows_list(found.upper.rows)
        rows.append((str(study.points[index]), ends, by))
    whole = table(("load", "c²", "c²⁺ is set by"), rows)
    return joined([whole, *_rest(len(study.ranges) - MOST_LOADS, "loads")])


def what_if_notes(found: WhatIf) -> list[Html]:
    """What the bars of changes do not show, in words."""
    first, *_ = found.lines(gains=0, losses=0)
    told = [element("p", f"{first[0].upper()}{first[1:]}.", class_="note")]
    more, _, lost = found.sorted()
    for title, listed in (
        ("With these it can be played:", [one for one in more if one.faster is None]),
        ("With these it cannot be played:", lost),
    ):
        if listed:
            lines = [element("li", str(one)) for one in listed[:MOST_LISTED]]
            rest = len(listed) - MOST_LISTED
            lines += [element("li", f"… and {rest} more")] if rest > 0 else []
            told += [element("p", title), element("ul", joined(lines))]
    hidden = len(changed_shares(found)) - MOST_BARS
    rest_of_bars = f"{hidden} more do less than these" if hidden > 0 else ""
    sentences = [text for text in (rest_of_bars, found.nothing_else(), found.left_out) if text]
    return [*told, *(element("p", f"{text[0].upper()}{text[1:]}.", class_="note") for text in sentences)]


def _rest(count: int, what: str) -> list[Html]:
    return [element("p", f"… and {count} more {what}.")] if count > 0 else []


def _rows_list(rows: Sequence[ActiveRow]) -> Html:
    return _lines(dict.fromkeys(map(row_text, rows)))


def _lines(lines: Iterable[str]) -> Html:
    return Html("<br>".join(html(line) for line in lines))


def _vector(values: Array) -> str:
    return f"({', '.join(f'{_cleared(value):.4g}' for value in values)})"
