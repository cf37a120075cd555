# SPDX-License-Identifier: MIT
"""`mrts configurations`."""

import argparse
from pathlib import Path

from mrts.base.errors import InputError
from mrts.commands.options.common import (
    add_between,
    add_cell_and_motion,
    add_plot,
    add_reserve,
    between_option,
    limited_cell_option,
    plot_form,
    sharing_option,
)
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.output_files import Outputs, check_outputs
from mrts.console.progress import working
from mrts.console.terminal import put, say

EXAMPLES = """\
examples:
  mrts configurations cell.yaml motion.yaml --show 5
  mrts configurations cell.yaml motion.yaml --share equal --cap 100 --json ranking.json"""


def add(study: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    add_cell_and_motion(study)
    study.add_argument("--share", metavar="equal|A,B,…", help="fixed distribution of the load")
    add_between(study)
    study.add_argument("--no-velocity-limits", action="store_true", help="let velocity limits bound nothing")
    add_reserve(study)
    study.add_argument("--cap", type=int, default=1024, help="most combinations to evaluate (default: %(default)s)")
    study.add_argument("--show", type=int, default=10, metavar="N", help="rows to print (default: %(default)s)")
    study.add_argument("--solver", default=None, help="solver of the registry (default: kernel)")
    study.add_argument("--json", type=Path, metavar="FILE", help="write the whole ranking ('-' is standard output)")
    add_plot(study, "a figure")
    study.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Rank the configurations."""
    from mrts.motion.motion_file import load_motion
    from mrts.motion.object_motion import ObjectMotion
    from mrts.program.solvers import DEFAULT_SOLVER
    from mrts.studies.configurations import rank_configurations

    options.plot_format = plot_form(options)
    if options.show < 0:
        raise InputError("--show", "must be at least 0.", value=options.show)
    check_outputs({"--json": options.json}, {"--plot": options.plot})
    between = between_option(options.between)
    motion = load_motion(options.motion)
    if not isinstance(motion, ObjectMotion):
        raise InputError(options.motion, "a table of joint motion fixes the configuration; give the object's motion.")
    sharing = sharing_option(options.share)
    cell = limited_cell_option(options)
    with working(f"configurations of {cell.name}") as progress:
        study = rank_configurations(
            cell,
            motion,
            sharing=sharing,
            cap=options.cap,
            solver=options.solver or DEFAULT_SOLVER,
            between=between,
            progress=progress,
        )
    feasible = bool(study.ranked) and study.ranked[0].range.status.admits_motion
    outputs = Outputs()
    if options.json is not None and str(options.json) != "-":
        with outputs.attempt(options.json):
            study.write_json(options.json)
    if options.plot is not None:
        with outputs.attempt(options.plot):
            from mrts.plots import ranking_plot, write_plot

            drawn = ranking_plot(study, f"{cell.name}: configurations")
            write_plot(drawn, options.plot / f"configurations.{options.plot_format}")
    if str(options.json) == "-":
        put(study.json_text())
    else:
        outcome, table = study.table(options.show).split("\n", 1)
        say(outcome, "strong" if feasible else "bad")
        say(table)
        for line in outputs.lines():
            say(line)
    return outputs.code(FEASIBLE if feasible else INFEASIBLE)
