# SPDX-License-Identifier: MIT
"""`mrts scale`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mrts.commands.exit_codes import FEASIBLE, INFEASIBLE
from mrts.commands.options import add_cell_and_motion, require, sharing_option
from mrts.commands.terminal import say, show_progress, warn
from mrts.errors import InputError

if TYPE_CHECKING:
    from mrts.cell import Cell
    from mrts.result import ScalingResult
    from mrts.rigid_transform import Array
    from mrts.scaling import Selection


def add(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb to the command line."""
    scale = verbs.add_parser(
        "scale",
        help="find the range of c², choose c², distribute the torques",
        epilog="Example: mrts scale cell.yaml motion.yaml --fastest --json result.json",
    )
    add_cell_and_motion(scale)
    choice = scale.add_mutually_exclusive_group()
    choice.add_argument("--fastest", action="store_const", const="fastest", dest="select",
                        help="play as fast as the limits allow (default)")  # fmt: skip
    choice.add_argument("--nominal", action="store_const", const="nominal", dest="select", help="play as given, c² = 1")
    choice.add_argument("--c2", type=float, dest="select", metavar="VALUE", help="play at this c²")
    scale.add_argument("--share", metavar="equal|A,B,…",
                       help="fixed distribution of the load: equal, or one share an arm")  # fmt: skip
    scale.add_argument("--load", default="auto", metavar="QUESTION",
                       help="of a load that varies: guaranteed (for every load; the default if the cell gives "
                       "object.variation), possible (for some load), grid:N (for N masses), or nominal")  # fmt: skip
    scale.add_argument("--carry", metavar="KEY=VALUE,…",
                       help="torques for this load of the box, as mass=1.5,izz=0.8 (default: nominal)")  # fmt: skip
    scale.add_argument("--no-wrench-limits", action="store_true", help="ignore the limits on the contact wrenches")
    scale.add_argument("--formulation", choices=["wrench", "torque"], default="wrench",
                       help="unknowns of the programs (default: %(default)s)")  # fmt: skip
    scale.add_argument("--solver", default=None, help="solver of the registry (default: kernel)")
    scale.add_argument("--json", type=Path, metavar="FILE", help="write the whole result ('-' is standard output)")
    scale.add_argument("--csv", type=Path, metavar="FILE", help="write the scaled trajectory as a table")
    scale.add_argument("--ros-bag", type=Path, metavar="DIR",
                       help="write the scaled trajectory as a ROS 2 bag (MCAP; needs the extra 'ros')")  # fmt: skip
    scale.add_argument("--plot", type=Path, metavar="DIR", help="write figures (needs the extra 'plot')")
    scale.add_argument("--report", type=Path, metavar="FILE",
                       help="write an HTML page that opens offline (needs the extra 'report')")  # fmt: skip
    scale.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Scale a motion."""
    from mrts.cell import load_cell
    from mrts.known_load import torques_for_load
    from mrts.motion_file import load_motion
    from mrts.scaling import SelectionError, scale
    from mrts.solvers import DEFAULT_SOLVER
    from mrts.text_report import report_lines

    require("matplotlib", "--plot", "plot", wanted=options.plot is not None)
    require("plotly", "--report", "report", wanted=options.report is not None)
    require("rosbags", "--ros-bag", "ros", wanted=options.ros_bag is not None)
    motion = load_motion(options.motion)
    sharing = sharing_option(options.share)
    cell = load_cell(options.cell)
    if options.no_wrench_limits:
        cell = cell.without_wrench_limits()
    select: Selection = "auto" if options.select is None else options.select
    carried = _known_load(cell, options.carry, options.load)
    try:
        result = scale(
            cell,
            motion,
            select,
            sharing=sharing,
            formulation=options.formulation,
            solver=options.solver or DEFAULT_SOLVER,
            load=options.load,
            progress=show_progress,
        )
        if carried is not None and result.trajectory is not None:
            result = torques_for_load(result, carried, solver=options.solver or DEFAULT_SOLVER)
    except SelectionError as error:
        if error.result is not None:
            _write(options, error.result)
        raise
    if str(options.json) != "-":
        for line in report_lines(result):
            say(line)
        if result.fallbacks:
            warn(f"{result.fallbacks} programs were left by the chosen solver and solved by another")
    _write(options, result)
    return FEASIBLE if result.status.admits_motion else INFEASIBLE


def _known_load(cell: "Cell", text: str | None, question: str) -> "Array | None":
    """The load of `--carry`."""
    if text is None:
        return None
    if cell.load_box is None:
        raise InputError("--carry", "picks a load of the box, but the cell gives no object.variation.", value=text)
    if question == "possible":
        raise InputError("--carry", "what is possible chooses no c², so there are no torques.", value=text)
    parameters: dict[str, float] = {}
    for part in text.split(","):
        name, _, number = part.partition("=")
        if name.strip() in parameters:
            raise InputError("--carry", f"gives {name.strip()} twice.", value=text)
        try:
            parameters[name.strip()] = float(number)
        except ValueError:
            raise InputError("--carry", "must be KEY=NUMBER, such as mass=1.5,izz=0.8.", value=text) from None
    return cell.load_box.load_at(parameters)


def _write(options: argparse.Namespace, result: "ScalingResult") -> None:
    if options.json is not None:
        if str(options.json) == "-":
            say(result.json_text())
        else:
            result.write_json(options.json)
    if options.csv is not None:
        from mrts.trajectory_table import write_trajectory_csv

        write_trajectory_csv(result, options.csv)
    if options.ros_bag is not None:
        from mrts.ros_bag import write_ros_bag

        write_ros_bag(result, options.ros_bag)
    if options.plot is not None:
        from mrts.figures import write_result_figures

        write_result_figures(result, options.plot)
    if options.report is not None:
        from mrts.report import write_report

        write_report(result, options.report)
