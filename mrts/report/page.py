# SPDX-License-Identifier: MIT
"""The page of a result."""

from dataclasses import asdict
from pathlib import Path

from mrts.base.argument_types import as_path, check_type
from mrts.base.atomic_file import write_text_atomically
from mrts.cell.cell import Cell
from mrts.report.document import Place, document, placing
from mrts.report.limit_map import limit_map
from mrts.report.limiting import LimitingRows, limiting_rows
from mrts.report.markup import Html, element, joined, section
from mrts.report.player import Player, player
from mrts.report.plots import (
    Plot,
    load_plot,
    position_plots,
    power_plots,
    rate_plots,
    torque_plots,
    velocity_plots,
    wrench_plots,
)
from mrts.report.range_plot import range_plot
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
    wrench_limits_table,
)
from mrts.report.timing_part import played_way, timing_section
from mrts.report.what_if_plot import what_if_notes, what_if_plots
from mrts.scaling.result import ScalingResult, fallbacks_text
from mrts.scene.scene import PACES
from mrts.timing.result import RetimingResult


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
    plots: list[Plot] = []
    timing = result if isinstance(result, RetimingResult) else None
    shown = result if isinstance(result, ScalingResult) else result.retimed or result.constant
    scene = player(shown, None if timing is None or timing.retimed is None else played_way(timing))
    head = _head(shown) if timing is None else _timing_head(timing, shown)
    pieces = _sections(shown, timing, scene, plots)
    return document(f"{shown.cell.name}: {result.status.value}", head, pieces, plots, player=asdict(scene))


def _sections(result: ScalingResult, timing: RetimingResult | None, scene: Player, plots: list[Plot]) -> list[Html]:
    """All sections in order; their plots are added to `plots`."""
    place = placing(plots)
    found, study, done = result.range, result.load, result.trajectory
    pieces = [*_warnings(result), *_timing(timing, place), _player_section(scene, given=done is None)]
    pieces.append(
        section(
            "range",
            _range_title(timing),
            *range_table(found),
            place(range_plot(found, "retimed" if result.origin else "given")),
        )
    )
    if result.changes is not None:
        drawn_changes = place(*what_if_plots(result.changes))
        pieces.append(section("what-if", "What changes would do", *what_if_notes(result.changes), drawn_changes))
    if found.samples.conflicts:
        pieces.append(section("conflicts", "Limits that conflict", conflicts_table(found.samples.conflicts)))
    if done is not None:
        limiting = limiting_rows(result, timing)
        pieces += [
            section("margins", "How far the limits are used", _margin_note(), margins_table(result, limiting)),
            section("limits", "Per cent of limits along the motion", place(limit_map(result, limiting))),
            section("duty", "What is asked of the motors", _duty_note(), duty_table(result)),
            section("torques", "Joint torques", _limit_note(), place(*torque_plots(result))),
            section("wrenches", "Contact wrenches", _limit_note(), place(*wrench_plots(result))),
            *_rates(result, limiting, place),
            section("velocities", "Joint velocities", _limit_note(), place(*velocity_plots(result))),
            section("positions", "Joint positions", _limit_note(), place(*position_plots(result))),
            section("power", "Power and energy", place(*power_plots(result))),
        ]
    if study is not None:
        drawn = load_plot(result)
        shown = [] if drawn is None else [place(drawn)]
        pieces.append(
            section("loads", "Uncertain load", element("p", f"Asked {study.sentence()}."), *shown, loads_table(result))
        )
    return [*pieces, section("inputs", "What was given", inputs_table(result), *_given_limits(result.cell))]


def _given_limits(cell: Cell) -> list[Html]:
    return [
        element("h3", "Joints"),
        joints_table(cell),
        *_motors(cell),
        element("h3", "Contact wrenches"),
        wrench_limits_table(cell),
    ]


def _range_title(timing: RetimingResult | None) -> str:
    if timing is None:
        return "Range of c²"
    return "Range of c² of the best constant factor" if timing.retimed is None else "Range of c² of the retimed motion"


def _timing(timing: RetimingResult | None, place: Place) -> list[Html]:
    return [] if timing is None or timing.retimed is None else [timing_section(timing, place)]


def _timing_head(timing: RetimingResult, shown: ScalingResult) -> Html:
    """The answer; where there is no profile, that of the best constant factor below it."""
    status = "feasible" if timing.status.admits_motion else "infeasible"
    text = timing.sentence()
    lines = [element("h1", timing.cell.name), element("p", f"{text[0].upper()}{text[1:]}", class_=f"outcome {status}")]
    if timing.retimed is None:
        lines.append(element("p", f"The best constant factor, which is shown below: {shown.sentence()}"))
    elif shown.trajectory is not None:
        lines.append(element("p", f"The motors give {shown.trajectory.energy:.4g} J."))
    return joined(lines)


def _rates(result: ScalingResult, limiting: LimitingRows, place: Place) -> list[Html]:
    """How fast torques, wrenches and accelerations change; nothing where that is not limited."""
    listed = rates_table(result, limiting)
    return [section("rates", "How fast torques change", *listed, place(*rate_plots(result)))] if listed else []


def _head(result: ScalingResult) -> Html:
    done = result.trajectory
    lines = [
        element("h1", result.cell.name),
        element("p", result.sentence(), class_=f"outcome {result.status.value}"),
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
