# SPDX-License-Identifier: MIT
"""`mrts check`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import InputError
from mrts.commands.options.common import add_xacro_arg, xacro_arguments
from mrts.console.exit_codes import BAD_INPUT, FEASIBLE, INFEASIBLE
from mrts.console.output_files import Outputs, check_outputs
from mrts.console.progress import working
from mrts.console.terminal import fail, put, say

if TYPE_CHECKING:
    from mrts.diagnosis.cell_check import CellCheck
    from mrts.starting.urdf_check import UrdfCheck

CODES = {"fine": FEASIBLE, "impossible": INFEASIBLE, "wrong-input": BAD_INPUT}
"""Exit code by what came of the check."""

EXAMPLES = """\
examples:
  mrts check cell.yaml
  mrts check cell.yaml motion.yaml
  mrts check cell.yaml motion.yaml -q --json - | jq .hints
  mrts check arm.urdf                             a URDF or xacro by itself, before there is a cell"""


def add(check: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    check.add_argument("cell", type=Path, metavar="CELL", help="cell file, or a URDF or xacro by itself")
    check.add_argument("motion", type=Path, metavar="MOTION", nargs="?",
                       help="motion file, CSV table, or ROS 2 bag with joint trajectories")  # fmt: skip
    check.add_argument("--json", type=Path, metavar="FILE", help="write all of it ('-' is standard output)")
    add_xacro_arg(check, "a xacro by itself")
    check.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Check a cell and a motion, or a URDF."""
    check_outputs({"--json": options.json}, {})
    found = _found(options)
    outputs = Outputs()
    if options.json is not None and str(options.json) != "-":
        with outputs.attempt(options.json):
            write_text_atomically(options.json, found.json_text() + "\n")
    if str(options.json) == "-":
        put(found.json_text())
    else:
        outcome, *details = found.lines()
        say(outcome, "strong" if found.status == "fine" else "bad")
        for line in details:
            say(line, "note" if line.startswith(("hint:", "warning:")) else "plain")
        for line in outputs.lines():
            say(line)
    if found.status == "wrong-input" and (options.json is not None or options.quiet):
        place = "" if options.json is None else f" (all of it: {options.json})"
        fail(f"error: {found.outcome()}{place}")
    return outputs.code(CODES[found.status])


def _found(options: argparse.Namespace) -> "CellCheck | UrdfCheck":
    """What is found of what the line names.

    Raises:
        InputError: If it takes more than goes with that.
    """
    from mrts.diagnosis.check import check
    from mrts.starting.urdf_check import check_urdf, is_urdf

    args = xacro_arguments(options.xacro_arg)
    if is_urdf(options.cell):
        if options.motion is not None:
            raise InputError(
                "MOTION", "does not go with a URDF, which is checked by itself.", value=str(options.motion)
            )
        return check_urdf(options.cell, args)
    if args:
        raise InputError("--xacro-arg", "a cell file gives its own: 'xacro_args' of each robot.")
    with working(f"checking {options.cell}") as progress:
        return check(options.cell, options.motion, progress=progress)
