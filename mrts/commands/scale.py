# SPDX-License-Identifier: MIT
"""`mrts scale`."""

from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from click import Choice, option

from mrts.base.errors import InputError, require_extra
from mrts.commands import options
from mrts.commands.console import FEASIBLE, INFEASIBLE, Outputs, Style, warn, working
from mrts.commands.options import HTML, Written, take
from mrts.program.formulation import DISTRIBUTIONS, FORMULATIONS

if TYPE_CHECKING:
    from mrts.cell.cell import Cell
    from mrts.control.simulate import ReserveSearch
    from mrts.motion.joint_table import JointTable
    from mrts.motion.object_motion import ObjectMotion
    from mrts.plots.card import Card
    from mrts.scaling.scale import ScalingResult
    from mrts.timing.result import RetimingResult

PROFILES = ("constant", "optimal", "smooth")

STYLES: dict[str, Style] = {"free": "plain", "near": "note", "reached": "bad"}
"""Of the limits that are told, by how near they are."""

PLANS = ("csv", "ros_bag")
"""Arguments that name files of the trajectory at the chosen speed."""

FILES = ("save", *PLANS, "plot", "report")
"""Arguments that name outputs."""

HOW = ("what_if", "merged", "rate", "verbose", "brief")
"""Arguments that say what is told and written."""


@options.command
@options.cell
@options.motion
@option("--c2", "select", type=float, metavar="VALUE",
        help="play at this c²; 1 is as given (default: as fast as the limits allow)")  # fmt: skip
@option("--profile", type=Choice(PROFILES), default="constant", show_default=True,
        help="one factor of speed, the fastest timing r(t), or a smooth one, the fastest whose torques and "
        "accelerations change at limited rates")  # fmt: skip
@option("--start-speed", type=float, metavar="R",
        help="of the optimal and the smooth profile, as a multiple of the given speed, where the motion does not start "
        "from rest (default: 0)")  # fmt: skip
@option("--end-speed", type=float, metavar="R", help="the same at the end")
@options.rates
@option("--least-energy-in", type=float, metavar="SECONDS",
        help="the smooth profile of least energy ∫ τᵀWτ dt that takes at most so long")  # fmt: skip
@options.share
@option("--load", metavar="QUESTION",
        help="of a load that varies: guaranteed (for every load; the default if the cell gives object.variation), "
        "possible (for some load), grid:N (for N masses), or nominal")  # fmt: skip
@option("--distribute", type=Choice(DISTRIBUTIONS),
        help="of redundant torques: the least ones, or those that keep most of every limit in reserve (default: "
        "least-torque; of the smooth profile reserve)")  # fmt: skip
@options.weights
@options.between
@options.closure
@option("--smooth", type=float, metavar="RAD",
        help="of noisy recordings of joints: how far smooth splines may be from any position, such as 1e-3 [rad, "
        "m]")  # fmt: skip
@options.limits
@option("--formulation", type=Choice(FORMULATIONS), help="unknowns of the programs (default: wrench)")
@options.solver
@option("--what-if", is_flag=True,
        help="tell what 10 % of each limit and of the mass, and 10 mm and 1° of each base and grasp, would do to the "
        "speed")  # fmt: skip
@options.json
@option("--save", type=Written(".npz"), metavar="FILE.npz", help="save the whole result, for mrts.load_result")
@option("--csv", type=Written(), metavar="FILE", help="write the scaled trajectory as a table")
@option("--ros-bag", type=Written(folder=True, new=True, needs=("rosbags",), extra="ros"), metavar="DIR",
        help="write it as a ROS 2 bag (MCAP; needs the extra 'ros')")  # fmt: skip
@option("--merged", is_flag=True, help="of --ros-bag: one trajectory of all arms")
@option("--sample-rate", "rate", type=float, metavar="HZ",
        help="of --csv and --ros-bag: rows at equal steps, as a controller takes them (default: the "
        "samples)")  # fmt: skip
@options.plot("figures")
@option("--report", type=HTML, metavar="FILE",
        help="write an HTML page that opens offline (needs the extra 'report')")  # fmt: skip
@option("-v", "--verbose", is_flag=True, help="print the table of all limits, not the nearest ones")
@option("--brief", is_flag=True, help="print the answer in one line, warnings on standard error")
def run(cell: Path, motion: Path, profile: str, json: Path | None = None, **given: Any) -> int:
    """How fast may this motion be played, and with which torques?

    Examples:
        mrts scale cell.yaml motion.yaml --save result.npz --report report.html --plot plots
        mrts scale cell.yaml motion.yaml --profile optimal --plot plots
        mrts scale cell.yaml motion.yaml --profile smooth --rates 11.5 --csv smooth.csv
        mrts scale cell.yaml motion.yaml --c2 0.8 --share 0.6,0.4 --csv trajectory.csv
        mrts scale cell.yaml motion.yaml --load guaranteed
        mrts scale cell.yaml motion.yaml --what-if --report report.html
        mrts scale cell.yaml motion.yaml -q --json - | jq .c2.upper
    """
    from mrts.motion.motion_file import load_motion
    from mrts.plots.card import answer_card
    from mrts.scaling.scale import ScalingResult, SelectionError

    _check(profile, given)
    files, how = take(given, FILES), take(given, HOW)
    motion_given = load_motion(motion, **take(given, ("smooth",)))
    if automatic := given.get("reserve") == "auto":
        require_extra("reserve", "simulate", "mujoco")
        del given["reserve"]
    limited = options.compiled_cell(cell, motion_given, given.get("closure"), **take(given, options.LIMITS))
    if "weights" in given and len(limited.robots) == 1 and profile != "smooth":
        warn("--weights has no effect: one arm leaves no torques to choose")
    solved, search = partial(_solved, motion=motion_given, profile=profile, given=given), None
    try:
        if automatic:
            from mrts.control.simulate import least_reserve

            search = least_reserve(lambda reserve: solved(limited.with_reserve(reserve)))
        found = (search and search.found) or solved(limited)
    except SelectionError as error:  # with the range that c² is not in
        Outputs(error.result, json).answer((), INFEASIBLE)
        raise
    if "what_if" in how:
        with working("changing the cell") as progress:
            found = replace(found, changes=found.what_if(progress=progress))
    with working("comparing with a constant factor"):
        card = None if "verbose" in how else answer_card(found)
        lines = _words(found, card, search, brief="brief" in how)
        plan = found if isinstance(found, ScalingResult) else found.retimed
        plan = None if plan is None or plan.trajectory is None else plan
        plan = plan.at_rate(how["rate"]) if plan and "rate" in how else plan
    with working("writing"):  # files first: whoever reads the lines may go away
        outputs = Outputs(found, json)
        _write(outputs, found, plan, files, search, merged="merged" in how)
    outcome = FEASIBLE if found.status.admits_motion and (search is None or search.found) else INFEASIBLE
    bars = () if card is None else zip(card.lines(), card.bars, strict=True)
    return outputs.answer(lines, outcome, {line: STYLES[bar.nearness] for line, bar in bars})


def _words(
    found: "ScalingResult | RetimingResult", card: "Card | None", search: "ReserveSearch | None", *, brief: bool
) -> list[str]:
    from mrts.plots.card import answer_lines

    if brief and card is not None:
        for warning in found.warnings:
            warn(warning.text)
        return [f"{found.cell.name}: {card.outcome}"]
    return [*answer_lines(found, card), *([] if search is None else ["", *search.lines()])]


def _check(profile: str, given: dict[str, Any]) -> None:
    from inspect import signature

    module, name = ("scaling", "scale") if profile == "constant" else ("timing", "retime")
    solve = getattr(import_module(f"mrts.{module}.{name}"), name)
    known = {*signature(solve).parameters, *FILES, *HOW, *options.LIMITS, "smooth"}
    known -= {"constant": set(), "optimal": {"rates"}, "smooth": {"what_if"}}[profile]
    for name in given:
        if name not in known:
            raise InputError(name, f"does not go with --profile {profile}.")
    if "brief" in given and "verbose" in given:
        raise InputError("verbose", "does not go with --brief, which is one line.")
    if "merged" in given and "ros_bag" not in given:
        raise InputError("merged", "goes with --ros-bag.")
    if "rate" in given and not given.keys() & {*PLANS}:
        raise InputError("rate", "goes with --csv or --ros-bag.")
    if "what_if" in given and given.get("load") == "possible":
        raise InputError("what_if", "goes with --load guaranteed, not with what is possible with some load.")
    if "weights" in given and "sharing" in given and profile != "smooth":
        raise InputError("weights", "does not go with --share, which leaves no torques to choose.")


def _solved(
    cell: "Cell", motion: "ObjectMotion | JointTable", profile: str, given: dict[str, Any]
) -> "ScalingResult | RetimingResult":
    from mrts.scaling.scale import scale

    if profile == "constant":
        with working(f"scaling {cell.name}") as progress:
            return scale(cell, motion, **given, progress=progress)
    from mrts.timing.retime import retime

    if profile == "smooth":
        given.setdefault("rates", True)
    with working(f"timing {cell.name}") as progress:
        return retime(cell, motion, **given, progress=progress)


def _write(
    outputs: Outputs,
    found: "ScalingResult | RetimingResult",
    plan: "ScalingResult | None",
    files: dict[str, Path],
    search: "ReserveSearch | None",
    *,
    merged: bool,
) -> None:
    """Write what was asked for; files of one trajectory hold the plan, if there is one."""
    if "save" in files:
        from mrts.output.saved_result import save_result

        outputs.write(files["save"], partial(save_result, found))
    if plan is None and (left_out := [f"--{name.replace('_', '-')}" for name in PLANS if name in files]):
        warn(f"there is no trajectory for {', '.join(left_out)}: not written")
    if plan is not None and "csv" in files:
        from mrts.output.trajectory_table import write_trajectory_csv

        outputs.write(files["csv"], partial(write_trajectory_csv, plan))
    if plan is not None and "ros_bag" in files:
        from mrts.output.ros_bag import write_ros_bag

        outputs.write(files["ros_bag"], partial(write_ros_bag, plan, merged=merged))
    if "plot" in files:
        from mrts.plots import reserve_plot, result_plots, write_plots

        of_search = [] if search is None else [reserve_plot(search)]
        outputs.write(files["plot"], lambda folder: write_plots([*result_plots(found), *of_search], folder))
    if "report" in files:
        from mrts.output.report_page import write_report

        outputs.write(files["report"], partial(write_report, found))
