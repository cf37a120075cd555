# SPDX-License-Identifier: MIT
"""The page of a result."""

from dataclasses import asdict, replace
from pathlib import Path

from mrts.base.argument_types import as_path, check_type
from mrts.base.atomic_file import write_text_atomically
from mrts.cell.cell import Cell
from mrts.plots.card import Card, answer_card
from mrts.plots.limit_plots import limit_map, limits_plot
from mrts.plots.limit_shares import LimitingRows, limiting_rows
from mrts.plots.phase_plane import phase_plane_plot, played_way
from mrts.plots.plot import Plot, one_panel
from mrts.plots.range_plots import load_study_plot, range_plot
from mrts.plots.trajectory_plots import joint_plots, power_plots, torque_plots, wrench_plots
from mrts.plots.what_if_plot import what_if_plot
from mrts.report.document import Plots, document, placed
from mrts.report.markup import Html, bar, element, joined, section, table
from mrts.report.player import Player, player
from mrts.report.tables import (
    conflicts_table,
    duty_table,
    inputs_table,
    joints_table,
    loads_table,
    margins_table,
    motors_table,
    range_table,
    rates_table,
    what_if_notes,
    wrench_limits_table,
)
from mrts.report.timing_part import timing_section
from mrts.scaling.result import ScalingResult, fallbacks_text
from mrts.scene.scene import PACES
from mrts.timing.result import RetimingResult

RANGE_TITLE = "c²⁻(t), c²⁺(t) and the limits that bind (↑ at the upper, ↓ at the lower side; bold: they set the range)"

DRAWN_BY_VALUE = ("torque", "wrench", "velocity")
"""Kinds of limits whose quantities are drawn in their own units."""


def write_report(result: ScalingResult | RetimingResult, path: Path | str) -> None:
    """Write the report of a result: one HTML file that opens offline.

    Args:
        result: Any result, feasible or not; of `mrts.retime`, the report begins with its timing.
        path: The file.

    Raises:
        InputError: If plotly is not installed or the file cannot be written.
    """
    check_type("result", result, ScalingResult, RetimingResult)
    write_text_atomically(as_path("path", path), report_html(result))


def report_html(result: ScalingResult | RetimingResult) -> str:
    """The report as text; the same result gives the same text.

    Args:
        result: Any result, feasible or not.

    Raises:
        InputError: If plotly is not installed.
    """
    plots: Plots = {}
    timing = result if isinstance(result, RetimingResult) else None
    shown = result if isinstance(result, ScalingResult) else result.retimed or result.constant
    scene = player(shown, None if timing is None or timing.retimed is None else played_way(timing))
    head = _head(shown) if timing is None else _timing_head(timing, shown)
    pieces = _sections(shown, timing, scene, plots)
    return document(f"{shown.cell.name}: {result.status.value}", head, pieces, plots, player=asdict(scene))


def _sections(result: ScalingResult, timing: RetimingResult | None, scene: Player, plots: Plots) -> list[Html]:
    """All sections in order; their plots are added to `plots`."""

    def place(*drawn: Plot) -> Html:
        return placed(plots, *drawn)

    found, study, done = result.range, result.load, result.trajectory
    pieces = [*_warnings(result), _player_section(scene, given=done is None)]
    if timing is not None and timing.retimed is not None:
        pieces.insert(-1, timing_section(timing, place(phase_plane_plot(timing))))
    if not result.origin:  # of a retimed motion the range is that of playing it still faster
        title = "Range of c²" if timing is None else "Range of c² of the best constant factor"
        pieces.append(
            section("range", title, *range_table(found), place(replace(range_plot(result), title=RANGE_TITLE)))
        )
    if result.changes is not None:
        bars = what_if_plot(result.changes)
        pieces.append(
            section("what-if", "What changes would do", *what_if_notes(result.changes), place(*filter(None, [bars])))
        )
    if found.samples.conflicts:
        pieces.append(section("conflicts", "Limits that conflict", conflicts_table(found.samples.conflicts)))
    if done is not None:
        limiting = limiting_rows(result, timing)
        pieces += [
            section("margins", "Limit utilisation", _margin_note(), margins_table(result, limiting)),
            section(
                "limits",
                "Limit utilisation along the motion",
                place(limit_map(result, limiting)),
                place(*_percents(result)),
            ),
            section("duty", "Motor duty", _duty_note(), duty_table(result)),
            section("torques", "Joint torques", _limit_note(), place(*torque_plots(result))),
            section("wrenches", "Contact wrenches", _limit_note(), place(*wrench_plots(result))),
            *_rates(result, limiting),
            section("velocities", "Joint velocities", _limit_note(), place(*joint_plots(result, "velocity"))),
            section("positions", "Joint positions", _limit_note(), place(*joint_plots(result, "position"))),
            section("power", "Power and energy", place(*power_plots(result))),
        ]
    if study is not None:
        shown = [place(load_study_plot(result))] if study.ranges else []
        pieces.append(
            section("loads", "Uncertain load", element("p", f"Asked {study.sentence()}."), *shown, loads_table(result))
        )
    return [*pieces, section("inputs", "What was given", inputs_table(result), *_given_limits(result.cell))]


def _card(card: Card, status: str) -> list[Html]:
    """The answer, and the limits that are nearest."""
    bars = [(one.label, bar(one.share, 1, state=one.nearness), f"at {one.time:.4g} s") for one in card.bars]
    nearest = [table(("nearest limits", "used at most", ""), bars)] if bars else []
    return [element("p", card.outcome, class_=f"outcome {status}"), *nearest]


def _given_limits(cell: Cell) -> list[Html]:
    return [
        element("h3", "Joints"),
        joints_table(cell),
        *_motors(cell),
        element("h3", "Contact wrenches"),
        wrench_limits_table(cell),
    ]


def _percents(result: ScalingResult) -> list[Plot]:
    """Hands, motors and rates, whose values have no plot of their own, as per cents of their limits."""
    panels = [panel for row in limits_plot(result, "", DRAWN_BY_VALUE).rows for panel in row]
    return [one_panel(f"limits-{number}", panel, "played") for number, panel in enumerate(panels)]


def _timing_head(timing: RetimingResult, shown: ScalingResult) -> Html:
    """The answer; where there is no profile, that of the best constant factor below it."""
    status = "feasible" if timing.status.admits_motion else "infeasible"
    text = timing.sentence()
    lines = [
        element("h1", timing.cell.name),
        *_card(answer_card(timing), status),
        element("p", f"{text[0].upper()}{text[1:]}"),
    ]
    if timing.retimed is None:
        lines.append(element("p", f"The best constant factor, which is shown below: {shown.sentence()}"))
    elif shown.trajectory is not None:
        lines.append(element("p", f"The motors give {shown.trajectory.energy:.4g} J."))
    return joined(lines)


def _rates(result: ScalingResult, limiting: LimitingRows) -> list[Html]:
    """How fast torques, wrenches and accelerations change; nothing where that is not limited."""
    listed = rates_table(result, limiting)
    return [section("rates", "Rates of torques, wrenches and accelerations", *listed)] if listed else []


def _head(result: ScalingResult) -> Html:
    done = result.trajectory
    lines = [
        element("h1", result.cell.name),
        *_card(answer_card(result), result.status.value),
        element("p", result.sentence()),
    ]
    if done is not None:
        given = float(result.motion.object.time[-1])
        if result.load is not None:
            load = f"The torques below are those of a load of {result.cell.mass:.4g} kg."
            lines.append(element("p", load))
        speed = f"The given {given:.4g} s become {done.duration:.4g} s, {given / done.duration:.3g} × as fast. "
        lines.append(element("p", f"{'' if result.origin else speed}The motors give {done.energy:.4g} J."))
    return joined(lines)


def _warnings(result: ScalingResult) -> list[Html]:
    notes = [warning.text for warning in result.warnings] + result.too_fast()
    if result.fallbacks:
        notes.append(fallbacks_text(result.fallbacks))
    if result.load is not None and result.load.not_converged:
        count = len(result.load.not_converged)
        notes.append(f"at {count} samples the search over loads was not verified: the range of a corner stands there")
    if not notes:
        return []
    return [section("warnings", "Warnings", element("ul", joined(element("li", note) for note in notes)))]


def _limit_note() -> Html:
    return element(
        "p",
        "Thin lines are limits; those far outside are not shown. A click on a name hides its lines; hovering moves "
        "the motion above.",
        class_="note",
    )


def _margin_note() -> Html:
    text = (
        "Of a limit that is 0, 100 % is the largest limit of its kind. Of a torque-speed line, it is what the line "
        "gives at standstill, and the limits are those of the moment at which most is used. A limit that sets the "
        "speed stands first; one that is only reached because of how the load is distributed does not set it."
    )
    return element("p", text, class_="note")


def _motors(cell: Cell) -> list[Html]:
    known = motors_table(cell)
    return [element("h3", "Motors"), *known] if known else []


def _duty_note() -> Html:
    text = (
        "Percentages are shares of what the joint bears: the torque rated for ever, the largest torque, speed, torque "
        "rate and jerk, where they are known. Torque rate and jerk are differences of neighbouring samples."
    )
    return element("p", text, class_="note")


def _player_section(scene: Player, *, given: bool) -> Html:
    speeds = joined(_speed(speed, chosen=speed == scene.speed) for speed in PACES)
    last = str(len(scene.time) - 1)
    controls = [
        element("button", "Play", id="play", type="button"),
        element("label", "time", for_="frame"),
        Html(f'<input id="frame" type="range" min="0" max="{last}" value="0" step="1">'),
        element("output", "", id="now", for_="frame"),
        element("label", "speed", for_="speed"),
        element("select", speeds, id="speed"),
    ]
    what = "The given motion." if given else "The motion at the chosen speed."
    if scene.largest_force > 0:
        what += f" Arrows are the forces of the arms on the object; the longest is {scene.largest_force:.4g} N."
    return section(
        "motion",
        "Motion",
        element(
            "p",
            f"{what} Arms are lines through their joints; an object of unknown shape is the box of its inertia.",
            class_="note",
        ),
        element("div", joined(controls), class_="controls"),
        element("div", "", id="player"),
    )


def _speed(speed: float, *, chosen: bool) -> Html:
    more = {"selected": "selected"} if chosen else {}
    return element("option", PACES[speed], value=f"{speed:g}", **more)
