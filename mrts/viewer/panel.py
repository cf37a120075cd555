# SPDX-License-Identifier: MIT
"""What the panel says of an answer, as HTML: outcome, speed, time, and bars against the limits."""

from collections.abc import Mapping, Sequence
from importlib.resources import files
from math import inf
from types import MappingProxyType

import numpy as np
import viser

from mrts.base.load_box import LoadPoint
from mrts.base.printable import html_text
from mrts.base.remark import Remark
from mrts.base.words import interval_text
from mrts.cell.cell import Cell
from mrts.collisions.clearance import Clearance
from mrts.limits.rows import ActiveRow
from mrts.program.range_status import RangeStatus
from mrts.scene.scene import FORCE, MOMENT, Rgb
from mrts.viewer.held_poses import HeldPoses
from mrts.viewer.player_state import Bar, PlayerState
from mrts.viewer.scene import ViewerScene

WITHIN, OVER, PASSED = "#0072B2", "var(--mrts-over)", "#B36B00"
"""Colours of a value within its limit, beyond it, and beyond a limit that is only reported."""

FULL = 1.25
"""Share of a limit at which a bar meets the edge."""

SPLIT = 1 / FULL / 2
"""Where the limits stand, as a share of the width to either side of the middle."""


BAR_COLUMNS, LIMIT_COLUMNS = (34, 29, 37), (44, 33, 23)
"""Widths of a table's columns: name, bar, value; or name, torque, velocity [%]."""

ROUNDING = 1e-9
"""What is less is shown as 0: it is left over from sums of much larger terms."""

MOST_NAMED = 5
"""Limits named that are passed; the worst come first."""

PANEL = 400
"""Width of the panel beside the scene [pixels]; the scene has the rest of the window."""

STYLE = f"<style>{(files('mrts') / 'viewer' / 'viewer.css').read_text(encoding='utf-8')}</style><span data-mrts></span>"
"""Of the page."""


def verdict_html(outcome: str, error: str, *, computing: bool, outdated: bool) -> str:
    """What stands above all controls: the last outcome, why there is no newer one, and whether one is on its way.

    All that is shown fades while it is outdated: while controls have other values.
    """
    below = '<b data-text="computing">Computing …</b>' if computing else ""
    below += "<style>:root { --mrts-answer: 0.4; }</style>" if outdated else ""
    text = f"{'' if computing else error}{outcome}"
    return f"<div data-verdict><div>{text}</div>{below}</div>"


def outcome_html(state: PlayerState, *, coarse: bool = False) -> str:
    """The outcome in a sentence; red where no speed is admissible."""
    result = state.result
    admits = result.status.admits_motion and not state.refusal
    text = f"<b>{html_text(state.card.outcome)}</b><br>" if admits and state.admissible else ""
    text += html_text(state.sentence())
    if coarse:
        samples = len(result.motion.object.time)
        text = f"<b>Coarse, the whole answer follows</b> (limits are kept at {samples} samples only): {text}"
    if result.load is not None:
        text += f" Torques are those of the nominal load of {result.cell.mass:.4g} kg."
    text += "".join(f"<br>{html_text(str(remark))}" for remark in result.warnings)
    return _paragraph("outcome", text, "inherit" if admits else OVER)


def collisions_html(near: Clearance | None, said: Sequence[Remark]) -> str:
    """How near bodies come to each other and what was not looked at, in red where they collide; empty without both."""
    text = html_text(". ".join(remark.text for remark in said))
    return _paragraph("collisions", text, OVER if near is not None and near.collides else "inherit") if said else ""


def held_html(held: HeldPoses) -> str:
    """What the arms hold without a motion; of one that they cannot follow, why, and how far they stay from it."""
    stands = not held.message
    lost = [
        f"{html_text(robot.name)}{'' if stands else f' at {np.count_nonzero(~reached)} of {len(reached)} samples'}, "
        f"by up to {1000 * float(np.max(gap)):.3g} mm"
        for robot, reached, gap in zip(held.scene.cell.robots, held.reached.T, held.gap.T, strict=True)
        if not np.all(reached)
    ]
    missing = f" Red in the scene is what is missing: {'; '.join(lost)}." if lost else ""
    if held.message:
        return _paragraph("outcome", f"<b>No motion:</b> {html_text(held.message)}{missing}", OVER)
    arms = ", ".join(f"{html_text(robot.name)} ({len(robot.joints)} joints)" for robot in held.scene.cell.robots)
    text = (
        f"{html_text(held.scene.cell.name)} stands where {html_text(held.scene.cell.robots[0].name)} holds the object "
        f"({held.scene.cell.mass:.4g} kg) at its posture: {arms}. No motion was given: mrts view CELL MOTION plays one."
    )
    return _paragraph("outcome", text + missing, OVER if lost else "inherit")


def limits_html(cell: Cell, colours: Mapping[str, Rgb]) -> str:
    """The limits of every arm, as they are now."""
    rows = []
    for robot in cell.robots:
        rows.append(_robot_row(robot.name, colours, "torque", "velocity"))
        for joint, _, torque, _, velocity in robot.joint_rows():
            rows.append(_limit_row(joint, torque, velocity))
        bounds = zip(cell.wrench_components, cell.wrench_units, robot.wrench_lower, robot.wrench_upper, strict=True)
        for name, unit, lower, upper in bounds:
            if np.isfinite(lower) or np.isfinite(upper):
                rows.append(_limit_row(f"wrench {name}", interval_text(lower, upper, unit), ""))
        rows += [_limit_row(f"contact {contact.name}", "by its rows", "") for contact in robot.contacts]
    return _table(rows, LIMIT_COLUMNS)


def speed_html(state: PlayerState | None) -> str:
    """The chosen speed, whether it is admissible, and what is shown if it is not; None leaves the place empty."""
    if state is None:
        return _paragraph("speed", "")
    done, samples = state.trajectory, len(state.excess)
    text = f"c = {done.c:.4g}, c² = {done.c2:.4g}, duration {done.duration:.4g} s, energy {done.energy:.4g} J. "
    passed = state.violations()
    if fast := sum(
        name.kind == "velocity" and f"{name.robot}/{name.element}" in done.cell.joint_names for name, _, _ in passed
    ):
        text += f"{fast} of {done.q.shape[1]} joints beyond their velocity limit. "
    if state.admissible:
        return _paragraph("speed", f"{text}Inside the admissible range.")
    over = int(np.count_nonzero(state.excess))
    text += "<b>Outside the admissible range</b>: "
    if over == 0:
        load = ", though the load shown keeps all limits" if state.result.load is not None else ""
        return _paragraph("speed", f"{text}no torques are guaranteed{load}.", OVER)
    text += f"{over} of {samples} samples beyond a limit (red): "
    text += "; ".join(
        f"{html_text(name.short)} by {_number(100 * excess)} % at {time:.3g} s"
        for name, excess, time in passed[:MOST_NAMED]
    )
    text += f"; and {len(passed) - MOST_NAMED} more. " if len(passed) > MOST_NAMED else ". "
    if state.result.options.sharing is not None or len(state.result.cell.robots) == 1:
        text += "The torques follow from the motion alone."
    else:
        text += "Where torques or wrenches do, all limits are moved outward by the least share that leaves torques."
    return _paragraph("speed", text, OVER)


def moment_html(state: PlayerState | None) -> str:
    """The chosen time, and which speeds its sample alone admits and why; None leaves the place empty."""
    if state is None:
        return _paragraph("moment", "")
    ranged, sample = state.result.range, state.sample
    found = ranged.samples
    given = found.time[sample]
    text = f"t = {state.time:.4g} s of {state.trajectory.duration:.4g} s (given motion: {given:.4g} s). "
    conflict = next((conflict for conflict in found.conflicts if conflict.sample == sample), None)
    if conflict is not None:
        return _paragraph("moment", f"{text}Infeasible: {html_text(str(conflict))}.", OVER)
    low, high = found.lower[sample], found.upper[sample]
    alone = interval_text(low, high)
    if np.isinf(high):
        return _paragraph("moment", f"{text}Nothing limits how fast this sample may be played: c² ∈ {alone}.")
    empty = found.status[sample] is RangeStatus.EMPTY
    reach = f"This sample alone admits c² ∈ {alone}"
    text += f"No c² suits every load here: {alone}; " if empty else f"{reach}; "
    text += f"faster is forbidden by {_rows(ranged.binding(sample, 'upper'), found.upper_loads, sample)}"
    if low > 0:
        text += f", slower by {_rows(ranged.binding(sample, 'lower'), found.lower_loads, sample)}"
    return _paragraph("moment", f"{text}.")


def bars_html(
    kind: str, groups: dict[str, list[Bar]], colours: Mapping[str, Rgb] = MappingProxyType({}), *, kept: bool = True
) -> str:
    """Bars about zero, a group a robot; the thin lines are the limits."""
    colour = OVER if kept else PASSED
    rows = []
    for robot, bars in groups.items():
        rows.append(_robot_row(robot, colours))
        rows += [_bar_row(kind, robot, bar, colour) for bar in bars]
    return _table(rows)


def _table(rows: Sequence[str], widths: Sequence[int] = BAR_COLUMNS) -> str:
    columns = "".join(f'<col style="width:{width}%">' for width in widths)
    return f"<table data-bars><colgroup>{columns}</colgroup>{''.join(rows)}</table>"


def _robot_row(robot: str, colours: Mapping[str, Rgb], *columns: str) -> str:
    mark = f'<span style="color:rgb{colours[robot]}">■</span> ' if robot in colours else ""
    cells = "".join(f"<td>{column}</td>" for column in columns)
    return f'<tr class="robot"><td colspan="{3 - len(columns)}">{mark}<b>{html_text(robot)}</b></td>{cells}</tr>'


def _limit_row(*cells: str) -> str:
    return f"<tr>{''.join(f'<td>{html_text(cell)}</td>' for cell in cells)}</tr>"


def _rows(rows: Sequence[ActiveRow], loads: Sequence[LoadPoint] | None, sample: int) -> str:
    load = f" with {loads[sample]}" if loads else ""
    names = (row.name.short for row in rows)
    return html_text(", ".join(names) + load)


def _bar_row(kind: str, robot: str, bar: Bar, over: str) -> str:
    colour = over if bar.over else WITHIN
    share = 0.0 if bar.share is None else float(np.clip(bar.share, -FULL, FULL))
    left, width = 50 + min(share, 0) * 100 * SPLIT, abs(share) * 100 * SPLIT
    drawn = f'<div class="value" style="left:{left:.2f}%;width:{width:.2f}%;background:{colour}"></div>'
    marks = [50.0] if bar.share is None else [50 - 100 * SPLIT, 50.0, 50 + 100 * SPLIT]
    drawn += "".join(f'<div class="limit" style="left:{at:.1f}%"></div>' for at in marks)
    weight = f"color:{over};font-weight:bold" if bar.over else ""
    return (
        f'<tr data-bar="{kind} {html_text(f"{robot}/{bar.name}")}" data-over="{str(bar.over).lower()}">'
        f'<td>{html_text(bar.name)}</td><td><div class="track">{drawn}</div></td>'
        f'<td style="{weight}">{_value(bar)}</td></tr>'
    )


def _value(bar: Bar) -> str:
    if bar.unit == "%":
        return f"{_number(bar.value)} %"
    if bar.limit is None:
        return f"{_number(bar.value)} {bar.unit} (no limit)"
    return f"{_number(bar.value)} of {_number(bar.limit)} {bar.unit}"


def _number(value: float) -> str:
    if abs(value) < ROUNDING:
        return "0"
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"  # noqa: PLR2004 (no powers of ten)


def text_html(kind: str, text: str) -> str:
    """A text of the panel, such as a "note", what was "saved", or an "error"."""
    return _paragraph(kind, html_text(text), OVER if kind == "error" else "inherit")


def _paragraph(kind: str, text: str, colour: str = "inherit") -> str:
    return f'<div data-text="{kind}" style="color:{colour}">{text}</div>'


class Readings:
    """Bars of the moment that is shown, under the limits that are nearest all along the motion."""

    def __init__(self, gui: viser.GuiApi, scene: ViewerScene) -> None:
        self._scene = scene
        with gui.add_folder("Nearest limits, at most"):
            self._nearest = gui.add_html("")
        with gui.add_folder("Joint torques"):
            self._torques = gui.add_html("")
        with gui.add_folder("Contact wrenches on the object, base axes"):
            self._wrenches, self._arrows = gui.add_html(""), gui.add_html("")
        with gui.add_folder("Joint velocities", expand_by_default=False):
            self._velocities = gui.add_html("")

    def show_answer(self, state: PlayerState | None) -> None:
        """Show the limits that are nearest, and say what the arrows mean; None empties all."""
        nearest, arrows = "", ""
        if state is None:
            self._torques.content = self._wrenches.content = self._velocities.content = ""
        else:
            bars = [Bar(one.label, 100 * one.share, -inf, 100.0, "%") for one in state.card.bars]
            nearest = bars_html("nearest", {"": bars} if bars else {})
            newtons, newton_metres = 1 / self._scene.metres_per_newton, 1 / self._scene.metres_per_newton_metre
            arrows = (
                f'<b style="color:rgb{FORCE}">force</b>: 1 m of arrow is {newtons:.4g} N, '
                f'<b style="color:rgb{MOMENT}">moment</b>: 1 m of arrow is {newton_metres:.4g} N m'
            )
        self._nearest.content, self._arrows.content = nearest, _paragraph("arrows", arrows)

    def show_moment(self, state: PlayerState) -> None:
        """Show the numbers at the chosen sample."""
        colours, bars = self._scene.colours, state.bars()
        self._torques.content = bars_html("torque", bars.pop("torque"), colours)
        self._wrenches.content = bars_html("wrench", bars.pop("wrench"), colours)
        velocities = {robot: of for robot, of in bars.pop("velocity").items() if robot != "object"}
        kept = state.result.cell.enforces_velocity_limits
        self._velocities.content = bars_html("velocity", velocities, colours, kept=kept) + "".join(
            bars_html(kind, of_kind, colours) for kind, of_kind in bars.items()
        )
