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
from mrts.commands.console.answer import FEASIBLE, INFEASIBLE, Outputs
from mrts.commands.console.terminal import Style, warn, working
from mrts.commands.options import HTML, Written, take
from mrts.program.formulation import DISTRIBUTIONS, FORMULATIONS

if TYPE_CHECKING:
    from mrts.cell.cell import Cell
    from mrts.motion.joint_table import JointTable
    from mrts.motion.object_motion import ObjectMotion
    from mrts.plots.card import Card
    from mrts.scaling.result import ScalingResult
    from mrts.simulation.simulate import ReserveSearch
    from mrts.timing.result import RetimingResult

EXAMPLES = """\
examples:
  mrts scale cell.yaml motion.yaml --save result.npz --report report.html --plot plots
  mrts scale cell.yaml motion.yaml --profile optimal --plot plots
  mrts scale cell.yaml motion.yaml --profile smooth --rates 11.5 --csv smooth.csv
  mrts scale cell.yaml motion.yaml --c2 0.8 --share 0.6,0.4 --csv trajectory.csv
  mrts scale cell.yaml motion.yaml --load guaranteed
  mrts scale cell.yaml motion.yaml --what-if --report report.html
  mrts scale cell.yaml motion.yaml -q --json - | jq .c2.upper"""

PROFILES = ("constant", "optimal", "smooth")

STYLES: dict[str, Style] = {"free": "plain", "near": "note", "reached": "bad"}
"""Of the limits that are told, by how near they are."""

PLANS = ("csv", "ros_bag")
"""Arguments that name files of the trajectory at the chosen speed."""

FILES = ("save", *PLANS, "plot", "report")
"""Arguments that name outputs, in the order in which they are written."""


@options.command(EXAMPLES)
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
def run(
    cell: Path,
    motion: Path,
    profile: str,
    json: Path | None = None,
    rate: float | None = None,
    *,
    merged: bool = False,
    what_if: bool = False,
    verbose: bool = False,
    brief: bool = False,
    **given: Any,
) -> int:
    """How fast may this motion be played, and with which torques?"""
    from mrts.motion.motion_file import load_motion
    from mrts.plots.card import answer_card
    from mrts.scaling.result import ScalingResult, fallbacks_text
    from mrts.scaling.scale import SelectionError

    if brief and verbose:
        raise InputError("verbose", "does not go with --brief, which is one line.")
    _check(profile, given | ({"what_if": True} if what_if else {}))
    files = take(given, FILES)
    if merged and "ros_bag" not in files:
        raise InputError("merged", "goes with --ros-bag.")
    if rate is not None and not files.keys() & {*PLANS}:
        raise InputError("rate", "goes with --csv or --ros-bag.")
    motion_given = load_motion(motion, **take(given, ("smooth",)))
    automatic = _is_automatic(given)
    limited = options.compiled_cell(cell, motion_given, given.get("closure"), **take(given, options.LIMITS))
    if "weights" in given and len(limited.robots) == 1 and profile != "smooth":
        warn("--weights has no effect: one arm leaves no torques to choose")
    try:
        search = _searched(limited, motion_given, profile, given) if automatic else None
        found = (search and search.found) or _solved(limited, motion_given, profile, given)
    except SelectionError as error:
        if error.result is not None:  # the range that c² is not in
            Outputs(error.result, json).answer((), INFEASIBLE)
        raise
    if what_if:
        with working("changing the cell") as progress:
            found = replace(found, changes=found.what_if(progress=progress))
    with working("comparing with a constant factor"):
        card = None if verbose else answer_card(found)
        lines = _words(found, card, search, brief=brief)
        plan = found if isinstance(found, ScalingResult) else found.retimed
        plan = None if plan is None or plan.trajectory is None else plan if rate is None else plan.at_rate(rate)
    with working("writing"):  # files first: whoever reads the lines may go away
        outputs = Outputs(found, json)
        _write(outputs, found, plan, files, search, merged=merged)
    outcome = FEASIBLE if found.status.admits_motion and (search is None or search.found) else INFEASIBLE
    bars = () if card is None else zip(card.lines(), card.bars, strict=True)
    code = outputs.answer(lines, outcome, {line: STYLES[bar.nearness] for line, bar in bars})
    if isinstance(found, ScalingResult) and found.fallbacks and outputs.json_text is None:
        warn(fallbacks_text(found.fallbacks))
    return code


def _is_automatic(given: dict[str, Any]) -> bool:
    """Whether the least reserve is to be found; the option is then taken out of the others."""
    if given.get("reserve") != "auto":
        return False
    require_extra("reserve", "simulate", "mujoco")
    del given["reserve"]
    return True


def _words(
    found: "ScalingResult | RetimingResult", card: "Card | None", search: "ReserveSearch | None", *, brief: bool
) -> list[str]:
    from mrts.output.summary_lines import answer_lines

    if brief and card is not None:
        for warning in found.warnings:
            warn(warning.text)
        return [f"{found.cell.name}: {card.outcome}"]
    return [*answer_lines(found, card), *([] if search is None else ["", *search.lines()])]


def _check(profile: str, given: dict[str, Any]) -> None:
    from inspect import signature

    module, name = ("scaling", "scale") if profile == "constant" else ("timing", "retime")
    solve = getattr(import_module(f"mrts.{module}.{name}"), name)
    known = {*signature(solve).parameters, *FILES, *options.LIMITS, "smooth"}
    known |= {"what_if"} if profile != "smooth" else set()
    known -= {"rates"} if profile == "optimal" else set()
    for name in given:
        if name not in known:
            raise InputError(name, f"does not go with --profile {profile}.")
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


def _searched(
    cell: "Cell", motion: "ObjectMotion | JointTable", profile: str, given: dict[str, Any]
) -> "ReserveSearch":
    from mrts.simulation.simulate import least_reserve

    return least_reserve(lambda reserve: _solved(cell.with_reserve(reserve), motion, profile, dict(given)))


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
    left_out = []
    for name, path in files.items():
        if name in PLANS and plan is None:
            left_out.append(f"--{name.replace('_', '-')}")
        else:
            outputs.write(path, partial(_write_file, name, plan if name in PLANS else found, search, merged=merged))
    if left_out:
        warn(f"there is no trajectory for {', '.join(left_out)}: not written")


def _write_file(
    name: str,
    found: Any,
    search: "ReserveSearch | None",
    path: Path,
    *,
    merged: bool,
) -> None:
    if name == "save":
        from mrts.output.saved_result import save_result

        save_result(found, path)
    elif name == "csv":
        from mrts.output.trajectory_table import write_trajectory_csv

        write_trajectory_csv(found, path)
    elif name == "ros_bag":
        from mrts.output.ros_bag import write_ros_bag

        write_ros_bag(found, path, merged=merged)
    elif name == "plot":
        from mrts.plots import reserve_plot, result_plots, write_plots

        write_plots(result_plots(found) + ([] if search is None else [reserve_plot(search)]), path)
    else:
        from mrts.report import write_report

        write_report(found, path)
