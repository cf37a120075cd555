# SPDX-License-Identifier: MIT
"""`mrts scale`."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from mrts.base.errors import InputError
from mrts.commands.options.common import (
    add_between,
    add_cell_and_motion,
    add_closure,
    add_plot,
    add_reserve,
    between_option,
    closure_option,
    limited_cell_option,
    numbers_option,
    plot_form,
    require,
    sharing_option,
    weights_option,
)
from mrts.commands.options.profile import add_profile, check_profile, rates_option, smooth_arguments
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.output_files import Outputs, check_outputs
from mrts.console.progress import working
from mrts.console.terminal import Style, put, say, warn
from mrts.output import TRAJECTORY_FORMATS, TrajectoryFormat
from mrts.program.formulation import DISTRIBUTIONS, FORMULATIONS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from mrts.base.arrays import Array
    from mrts.cell.cell import Cell
    from mrts.following.grasp_closure import ClosureBound
    from mrts.motion.joint_table import JointTable
    from mrts.motion.object_motion import ObjectMotion
    from mrts.program.load_sharing import LoadSharing
    from mrts.scaling.options import Selection
    from mrts.scaling.result import ScalingResult
    from mrts.timing.result import RetimingResult

EXAMPLES = """\
examples:
  mrts scale cell.yaml motion.yaml --save result.npz --report report.html --plot plots
  mrts scale cell.yaml motion.yaml --profile optimal --plot plots
  mrts scale cell.yaml motion.yaml --profile smooth --rates 11.5 --csv smooth.csv
  mrts scale cell.yaml motion.yaml --c2 0.8 --share 0.6,0.4 --csv trajectory.csv
  mrts scale cell.yaml motion.yaml --load guaranteed --carry mass=1.5,izz=0.8
  mrts scale cell.yaml motion.yaml --what-if --report report.html
  mrts scale cell.yaml motion.yaml -q --json - | jq .c2.upper"""


def add(scale: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    add_cell_and_motion(scale)
    add_profile(scale)
    scale.add_argument("--share", metavar="equal|A,B,…",
                       help="fixed distribution of the load: equal, or one share an arm")  # fmt: skip
    scale.add_argument("--load", default="auto", metavar="QUESTION",
                       help="of a load that varies: guaranteed (for every load; the default if the cell gives "
                       "object.variation), possible (for some load), grid:N (for N masses), or nominal")  # fmt: skip
    scale.add_argument("--carry", metavar="KEY=VALUE,…",
                       help="torques for this load of the box, factors as mass=1.5,izz=0.8, or mass=3kg (default: "
                       "nominal)")  # fmt: skip
    scale.add_argument("--distribute", choices=DISTRIBUTIONS, default="least-torque",
                       help="of redundant torques: the least ones, or those that keep most of every limit in reserve "
                       "(default: %(default)s)")  # fmt: skip
    scale.add_argument("--weights", metavar="W|A,B,…",
                       help="what the squares of torques weigh: 1 for all alike (as in the paper), or one a joint "
                       "(default: 1 / limit² of each); of no effect with --share or one arm")  # fmt: skip
    add_reserve(scale)
    add_between(scale)
    add_closure(scale)
    scale.add_argument("--no-wrench-limits", action="store_true", help="ignore the limits on the contact wrenches")
    scale.add_argument(
        "--no-velocity-limits", action="store_true", help="report velocity limits, but let them bound nothing"
    )
    scale.add_argument("--formulation", choices=FORMULATIONS, default="wrench",
                       help="unknowns of the programs (default: %(default)s)")  # fmt: skip
    scale.add_argument("--solver", default=None,
                       help="solver of the registry (default: kernel; the smooth profile has its own)")  # fmt: skip
    scale.add_argument("--what-if", action="store_true",
                       help="tell what 10 %% of each limit and of the mass, and 10 mm and 1° of each base and grasp, "
                       "would do to the speed")  # fmt: skip
    scale.add_argument("--json", type=Path, metavar="FILE", help="write the whole result ('-' is standard output)")
    scale.add_argument("--save", type=Path, metavar="FILE.npz",
                       help="save the whole result, for mrts.load_result")  # fmt: skip
    for name, form in TRAJECTORY_FORMATS.items():
        scale.add_argument(f"--{name}", type=Path, metavar="DIR" if form.is_folder else "FILE",
                           help=f"write the scaled trajectory {form.meaning}")  # fmt: skip
    add_plot(scale, "figures")
    scale.add_argument("--report", type=Path, metavar="FILE",
                       help="write an HTML page that opens offline (needs the extra 'report')")  # fmt: skip
    scale.add_argument(
        "-v", "--verbose", action="store_true", help="print the table of all limits, not the nearest ones"
    )
    scale.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Scale a motion."""
    from mrts.motion.motion_file import load_motion

    options.plot_format = plot_form(options)
    require("plotly", "--report", "report", wanted=options.report is not None)
    for name, form, path in _trajectory_files(options):
        if form.needs:
            require(form.needs[0], f"--{name}", form.needs[1], wanted=path is not None)
    check_profile(options)
    _check_outputs(options)
    if options.what_if and options.load == "possible":
        raise InputError("--what-if", "goes with --load guaranteed, not with what is possible with some load.")
    between_option(options.between)  # a wrong one is told before any work
    motion = load_motion(options.motion)
    sharing, closure = sharing_option(options.share), closure_option(options.closure)
    cell = limited_cell_option(options, motion, closure)
    options.weights = weights_option(options.weights, cell)
    carried = _known_load(cell, options.carry, options.load)
    if options.profile != "constant":
        return _retime(options, cell, motion, sharing, carried, closure)
    return _scale(options, cell, motion, sharing, carried, closure)


def _check_outputs(options: argparse.Namespace) -> None:
    """One file an option, of the kind that it writes, where it can be written."""
    for option, path, suffixes in (
        ("--save", options.save, (".npz",)),
        ("--report", options.report, (".html", ".htm")),
    ):
        if path is not None and str(path) != "-" and path.suffix not in suffixes:
            raise InputError(option, f"writes a file that ends in {suffixes[0]}.", value=str(path))
    trajectories = _trajectory_files(options)
    files = {"--json": options.json, "--save": options.save}
    files |= {f"--{name}": path for name, form, path in trajectories if not form.is_folder}
    files |= {"--report": options.report}
    new_folders = {f"--{name}": path for name, form, path in trajectories if form.is_folder}
    check_outputs(files, {"--plot": options.plot}, new_folders)


def _trajectory_files(options: argparse.Namespace) -> list[tuple[str, TrajectoryFormat, Path | None]]:
    """Every format of the trajectory with its name and where it is asked for."""
    return [(name, form, getattr(options, name.replace("-", "_"))) for name, form in TRAJECTORY_FORMATS.items()]


def _scale(
    options: argparse.Namespace,
    cell: "Cell",
    motion: "ObjectMotion | JointTable",
    sharing: "LoadSharing | None",
    carried: "Array | None",
    closure: "ClosureBound | None",
) -> int:
    from mrts.output.summary_lines import scaling_lines
    from mrts.program.solvers import DEFAULT_SOLVER
    from mrts.scaling.scale import SelectionError, scale, torques_for_load

    outputs = Outputs()
    select: Selection = "auto" if options.select is None else options.select
    try:
        with working(f"scaling {options.motion}") as progress:
            result = scale(
                cell,
                motion,
                select,
                sharing=sharing,
                formulation=options.formulation,
                solver=options.solver or DEFAULT_SOLVER,
                load=options.load,
                distribute=options.distribute,
                weights=options.weights,
                closure=closure,
                between=between_option(options.between),
                rates=rates_option(options, cell),
                progress=progress,
            )
        if options.what_if:
            with working("changing the cell") as progress:
                changes = result.what_if(solver=options.solver or DEFAULT_SOLVER, progress=progress)
            result = replace(result, changes=changes)
        if carried is not None and result.trajectory is not None:
            result = torques_for_load(result, carried, solver=options.solver or DEFAULT_SOLVER)
    except SelectionError as error:
        if error.result is not None:
            _write(options, error.result, outputs)
            if str(options.json) == "-":
                put(error.result.json_text())
            outputs.raise_defect()
        raise
    with working("writing"):  # files first: whoever reads the lines may go away
        _write(options, result, outputs)
    code = _answered(options, result, scaling_lines(result, whole=options.verbose), outputs)
    if result.fallbacks and str(options.json) != "-":
        from mrts.scaling.result import fallbacks_text

        warn(fallbacks_text(result.fallbacks))
    return code


def _answered(
    options: argparse.Namespace, found: "ScalingResult | RetimingResult", lines: "Iterable[str]", outputs: Outputs
) -> int:
    """Print the answer in words, or its JSON text where `-` asks for that; the exit code."""
    from mrts.plots.card import answer_card

    admits = found.status.admits_motion
    if str(options.json) == "-":
        put(found.json_text())
    else:
        card = answer_card(found)
        styles: dict[str, Style] = {"free": "plain", "near": "note", "reached": "bad"}
        bars = {line: styles[bar.nearness] for line, bar in zip(card.lines(), card.bars, strict=True)}
        outcome, *details = lines
        say(outcome, "strong" if admits else "bad")
        for line in details:
            say(line, "note" if line.startswith(("note:", "warning:")) else bars.get(line, "plain"))
        for line in outputs.lines():
            say(line)
    return outputs.code(FEASIBLE if admits else INFEASIBLE)


def _retime(
    options: argparse.Namespace,
    cell: "Cell",
    motion: "ObjectMotion | JointTable",
    sharing: "LoadSharing | None",
    carried: "Array | None",
    closure: "ClosureBound | None",
) -> int:
    from mrts.output.summary_lines import retiming_lines
    from mrts.scaling.scale import torques_for_load
    from mrts.timing.retime import retime

    outputs, further = Outputs(), smooth_arguments(options, cell)
    with working(f"timing {options.motion}") as progress:
        found = retime(
            cell,
            motion,
            sharing=sharing,
            load=options.load,
            distribute=options.distribute,
            weights=options.weights,
            closure=closure,
            between=between_option(options.between),
            start_speed=options.start_speed or 0.0,
            end_speed=options.end_speed or 0.0,
            progress=progress,
            **further,
        )
        if carried is not None and found.retimed is not None:
            found = replace(found, retimed=torques_for_load(found.retimed, carried))
    if options.what_if:
        with working("changing the cell") as progress:
            changes = found.what_if(progress=progress)
        played = found.retimed and replace(found.retimed, changes=changes)
        found = replace(found, changes=changes, retimed=played)
    with working("comparing with a constant factor"):
        lines = list(retiming_lines(found, whole=options.verbose))
    with working("writing"):  # files first: whoever reads the lines may go away
        _write_timing(options, found, outputs)
    return _answered(options, found, lines, outputs)


def _write_timing(options: argparse.Namespace, found: "RetimingResult", outputs: Outputs) -> None:
    """Write what was asked for of the fastest timing; files of one trajectory get the retimed motion."""
    _write_json(options, found, outputs)
    if found.retimed is None:
        _say_unwritten(options)
    else:
        _write_trajectory(options, found.retimed, outputs)
    _save(options, found, outputs)
    _write_pictures(options, found, outputs)


def _known_load(cell: "Cell", text: str | None, question: str) -> "Array | None":
    """The load of `--carry`."""
    if text is None:
        return None
    if cell.load_box is None:
        raise InputError("--carry", "picks a load of the box, but the cell gives no object.variation.", value=text)
    if question == "possible":
        raise InputError("--carry", "what is possible chooses no c², so there are no torques.", value=text)
    units = {"mass": ("kg", cell.load_box.mass)}
    return cell.load_box.load_at(numbers_option("--carry", text, "mass=1.5,izz=0.8 or mass=3kg", units))


def _write(options: argparse.Namespace, result: "ScalingResult", outputs: Outputs) -> None:
    """Write what was asked for, each output whatever becomes of the others; what `-` asks for comes after them."""
    _write_json(options, result, outputs)
    if result.trajectory is not None:
        _write_trajectory(options, result, outputs)
    else:
        _say_unwritten(options)
    _save(options, result, outputs)
    _write_pictures(options, result, outputs)


def _write_json(options: argparse.Namespace, found: "ScalingResult | RetimingResult", outputs: Outputs) -> None:
    if options.json is not None and str(options.json) != "-":
        with outputs.attempt(options.json):
            found.write_json(options.json)


def _save(options: argparse.Namespace, result: "ScalingResult | RetimingResult", outputs: Outputs) -> None:
    if options.save is not None:
        with outputs.attempt(options.save):
            from mrts.output.saved_result import save_result

            save_result(result, options.save)


def _write_pictures(options: argparse.Namespace, found: "ScalingResult | RetimingResult", outputs: Outputs) -> None:
    if options.report is not None:
        with outputs.attempt(options.report):
            from mrts.report import write_report

            write_report(found, options.report)
    if options.plot is not None:
        with outputs.attempt(options.plot):
            from mrts.plots import write_result_plots

            write_result_plots(found, options.plot, options.plot_format)


def _say_unwritten(options: argparse.Namespace) -> None:
    wanted = {f"--{name}": path for name, _, path in _trajectory_files(options)}
    if left_out := [name for name, path in wanted.items() if path is not None]:
        warn(f"there is no trajectory for {', '.join(left_out)}: not written")


def _write_trajectory(options: argparse.Namespace, result: "ScalingResult", outputs: Outputs) -> None:
    for _, form, path in _trajectory_files(options):
        if path is not None:
            with outputs.attempt(path):
                form.write(result, path)
