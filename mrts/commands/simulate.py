# SPDX-License-Identifier: MIT
"""`mrts simulate`."""

from pathlib import Path
from typing import Any

from click import argument, option

from mrts.base.errors import InputError, require_extra
from mrts.commands import options
from mrts.commands.console import FEASIBLE, INFEASIBLE, Outputs, working
from mrts.commands.options import HTML, Named


@options.command
@options.cell
@argument("plan", type=Named(".npz", ".csv", ".mcap", ".db3"), metavar="PLAN",
          help="saved result (.npz), CSV table with torques and wrenches, or ROS 2 bag, as `mrts scale` writes "
          "them")  # fmt: skip
@option("--set", "given", multiple=True, metavar="KEY=VALUE",
        help="a number of the controller or of the cell's errors; once for each (docs/simulate.md)")  # fmt: skip
@option("--override", metavar="FILE|random:SEED",
        help="play it at the speeds that a CSV table of t and speed wants, or at random ones "
        "(docs/override.md)")  # fmt: skip
@options.rates
@option("--trials", type=int, metavar="N", help="play it again so often with drawn errors (default: 0)")
@option("--seed", type=int, metavar="N", help="of the drawn errors and of noise (default: 0)")
@options.json
@options.plot("a figure of what was used over what was planned")
@option("--report", type=HTML, metavar="FILE",
        help="write an HTML page that opens offline (needs the extra 'report')")  # fmt: skip
@option("-v", "--verbose", is_flag=True, help="print the table of all limits, not the nearest ones")
def run(
    cell: Path,
    plan: Path,
    given: tuple[str, ...] = (),
    *,
    override: str | None = None,
    json: Path | None = None,
    plot: Path | None = None,
    report: Path | None = None,
    verbose: bool = False,
    **draw: Any,
) -> int:
    """Does a plan keep its limits when a controller plays it on a cell that is not quite the plan's?

    Examples:
        mrts simulate cell.yaml result.npz
        mrts simulate cell.yaml trajectory.csv --set delay=2e-3 --set mass=0.05 --set com=0.002,0,0
        mrts simulate cell.yaml result.npz --override random:1
        mrts simulate cell.yaml result.npz --trials 100 -q --json - | jq .trials.largest
    """
    from mrts.control.controller import Controller, PlantErrors, with_settings
    from mrts.control.plan_file import load_plan
    from mrts.control.simulate import simulate
    from mrts.control.speed_override import random_wishes, read_wishes

    require_extra("mrts simulate", "simulate", "mujoco")
    controller, errors = with_settings(Controller(), PlantErrors(), dict(map(_setting, given)))
    compiled = options.compiled_cell(cell)
    with working(f"reading {plan}"):
        planned = (options.result_of_cell if plan.suffix.lower() == ".npz" else load_plan)(compiled, plan)
    if override is not None:
        word, sign, seed = override.partition(":")
        drawn = (word, sign) == ("random", ":")
        if drawn and not seed.isdecimal():
            raise InputError("override", "must be random:SEED with a whole number, or a CSV table.", value=override)
        draw["override"] = random_wishes(int(seed), planned.duration or 1.0) if drawn else read_wishes(override)
    with working(f"simulating {compiled.name}") as progress:
        found = simulate(planned, controller, errors, progress=progress, **draw)
    outputs = Outputs(found, json)
    if plot is not None:
        from mrts.plots import simulation_plot, write_plots

        outputs.write(plot, lambda folder: write_plots([simulation_plot(found)], folder))
    if report is not None:
        from mrts.output.report_page import write_report

        outputs.write(report, lambda file: write_report(found, file))
    return outputs.answer(found.lines(every=verbose), FEASIBLE if found.kept else INFEASIBLE)


def _setting(text: str) -> tuple[str, Any]:
    from mrts.base.yaml_text import parse_yaml

    name, sign, value = text.partition("=")
    if not sign:
        raise InputError("given", "must be KEY=VALUE, such as delay=2e-3.", value=text)
    try:
        values: Any = parse_yaml(f"[{value}]")
    except ValueError as error:
        raise InputError("given", f"{error}.", value=text) from None
    return name, values[0] if len(values) == 1 else values
